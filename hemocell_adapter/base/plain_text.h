// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sanitising of user-supplied text for terminals and for files of other programs.
#pragma once

#include <string>
#include <string_view>

namespace packmesh::hemocell {

/// True if `text` is UTF-8 without control characters, byte order marks and characters that change the
/// direction of the text after them.
bool isPlainText(std::string_view text);

/// True if `text` is plain and, apart from blanks of ASCII, without invisible characters.
bool isVisible(std::string_view text);

/// `text` with every byte that is not plain replaced by `?`; line ends and tabs are kept.
std::string plainText(std::string_view text);

/// `text` with the middle of every excessively long word replaced by "...". Pre: UTF-8.
std::string withShortenedNames(std::string_view text);

}  // namespace packmesh::hemocell
