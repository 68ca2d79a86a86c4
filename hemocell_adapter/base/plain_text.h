// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Text from users that goes to terminals and into files of other programs.
#pragma once

#include <string>
#include <string_view>

namespace packmesh::hemocell {

/// Whether `text` is UTF-8 without control characters.
bool isPlainText(std::string_view text);

/// `text` with every byte that is not so replaced by `?`; ends of lines and tabs stay.
std::string plainText(std::string_view text);

/// `text` with the middle of every word that is longer than any sensible name replaced by "...". Pre: UTF-8.
std::string withShortenedNames(std::string_view text);

}  // namespace packmesh::hemocell
