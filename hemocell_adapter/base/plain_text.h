// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Sanitising of user-supplied text for terminals and for files of other programs.
#pragma once

#include <string>
#include <string_view>

namespace packmesh::hemocell {

/// `text` with `?` for every byte that is not plain: not UTF-8, or of control characters, byte order marks
/// and characters that change the direction of the text after them. Line ends and tabs are kept.
std::string plainText(std::string_view text);

/// `text` with the middle of every excessively long word replaced by "...". Pre: UTF-8.
std::string withShortenedNames(std::string_view text);

}  // namespace packmesh::hemocell
