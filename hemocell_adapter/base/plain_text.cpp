// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/plain_text.h"

#include <cstdint>

namespace packmesh::hemocell {
namespace {

/// Whether terminals and editors show the text after it in another direction or order.
bool changesDirection(std::uint32_t code) {
  return (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

/// Bytes of the character at the beginning of `text`, which is not empty; 0 if it is invalid, a control
/// character, a byte order mark or one that changes the direction.
std::size_t lengthOfFirst(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first < 0x20 || first == 0x7F ? 0 : 1;
  const std::size_t length = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
  if (length == 0 || text.size() < length) return 0;
  std::uint32_t code = first & (0xFFu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0u) != 0x80u) return 0;
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  const bool tooLong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  if (tooLong || surrogate || code > 0x10FFFF || code < 0xA0) return 0;
  return changesDirection(code) || code == 0xFEFF ? 0 : length;
}

}  // namespace

std::string plainText(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const std::size_t length = lengthOfFirst(text);
    const bool kept = length > 0 || text[0] == '\n' || text[0] == '\t';
    if (kept)
      plain += text.substr(0, length > 0 ? length : 1);
    else
      plain += '?';
    text.remove_prefix(length > 0 ? length : 1);
  }
  return plain;
}

std::string withShortenedNames(std::string_view text) {
  constexpr std::size_t longest = 400, ends = 150;  // [bytes]; file names have up to 255
  const auto isInside = [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) == 0x80u; };
  std::string shortened;
  while (!text.empty()) {
    std::string_view word = text.substr(0, text.find_first_of(" \t\n"));
    text.remove_prefix(word.size());
    if (word.size() > longest) {
      std::size_t head = ends, tail = word.size() - ends;
      while (isInside(word[head])) --head;
      while (isInside(word[tail])) ++tail;
      shortened.append(word.substr(0, head)).append("...");
      word.remove_prefix(tail);
    }
    shortened += word;
    if (text.empty()) break;
    shortened += text[0];
    text.remove_prefix(1);
  }
  return shortened;
}

}  // namespace packmesh::hemocell
