// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/plain_text.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

namespace packmesh::hemocell {
namespace {

struct Character {
  std::size_t bytes = 0;
  std::uint32_t code = 0;
};

/// Whether terminals and editors show the text after it in another direction or order.
bool changesDirection(std::uint32_t code) {
  return (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

/// The character at the beginning of `text`, which is not empty; without bytes if it is invalid, a control
/// character, a byte order mark or one that changes the direction.
Character characterOf(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first < 0x20 || first == 0x7F ? Character{} : Character{1, first};
  const std::size_t length = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
  if (length == 0 || text.size() < length) return {};
  std::uint32_t code = first & (0xFFu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0u) != 0x80u) return {};
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  const bool tooLong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  if (tooLong || surrogate || code > 0x10FFFF || code < 0xA0) return {};
  if (changesDirection(code) || code == 0xFEFF) return {};
  return {length, code};
}

/// Blanks beyond ASCII, and characters without a shape of their own: Default_Ignorable_Code_Point, Zl, Zp, Zs
/// and Cf of Unicode 15.
bool isInvisible(std::uint32_t code) {
  constexpr std::pair<std::uint32_t, std::uint32_t> ranges[] = {
      {0x00A0, 0x00A0},   {0x00AD, 0x00AD},   {0x034F, 0x034F},   {0x0600, 0x0605},   {0x061C, 0x061C},
      {0x06DD, 0x06DD},   {0x070F, 0x070F},   {0x0890, 0x0891},   {0x08E2, 0x08E2},   {0x115F, 0x1160},
      {0x1680, 0x1680},   {0x17B4, 0x17B5},   {0x180B, 0x180F},   {0x2000, 0x200F},   {0x2028, 0x202F},
      {0x205F, 0x206F},   {0x3000, 0x3000},   {0x3164, 0x3164},   {0xFE00, 0xFE0F},   {0xFEFF, 0xFEFF},
      {0xFFA0, 0xFFA0},   {0xFFF0, 0xFFFB},   {0x110BD, 0x110BD}, {0x110CD, 0x110CD}, {0x13430, 0x1343F},
      {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A}, {0xE0000, 0xE0FFF}};
  return std::any_of(std::begin(ranges), std::end(ranges),
                     [&](const auto& range) { return code >= range.first && code <= range.second; });
}

}  // namespace

bool isVisible(std::string_view text) {
  while (!text.empty()) {
    const Character character = characterOf(text);
    if (character.bytes == 0 || isInvisible(character.code)) return false;
    text.remove_prefix(character.bytes);
  }
  return true;
}

std::string plainText(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const std::size_t length = characterOf(text).bytes;
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
