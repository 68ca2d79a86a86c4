// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sanitising of user-supplied text for terminals and for files of other programs.
#pragma once

#include <string>
#include <string_view>

namespace packmesh::hemocell {

/// True if `text` is UTF-8 without control characters.
bool isPlainText(std::string_view text);

/// `text` with every invalid byte replaced by `?`; line ends and tabs are kept.
std::string plainText(std::string_view text);

/// `text` with the middle of every excessively long word replaced by "...". Pre: UTF-8.
std::string withShortenedNames(std::string_view text);

}  // namespace packmesh::hemocell
