// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Readers of the formats of mesh files: words line by line, and the contents before processing.
/// Internal to packMesh/mesh.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "packMesh/core/error.h"
#include "packMesh/core/poll.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector.h"

namespace packmesh {

/// Polygons over vertices exactly as a file lists them: nothing merged, dropped or reordered.
struct PolygonSoup {
  std::vector<Vec3> vertices;
  std::vector<int> corners;  ///< vertex indices of all polygons, one polygon after the other
  std::vector<int> ends;     ///< for each polygon, one past its last corner

  std::vector<std::string> notes;  ///< what is odd about the file, and how it was read

  void addPolygon(const std::vector<int>& polygon) {
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    ends.push_back(static_cast<int>(corners.size()));
  }
  int largestCorner() const {
    return corners.empty() ? -1 : *std::max_element(corners.begin(), corners.end());
  }
};

/// Strict readers of text and binary files: every coordinate in double precision, every count checked against
/// the file before it is used, no face skipped, every error in a text reported with its line. OpenMesh's
/// readers would need less code, but round coordinates to single precision, skip faces, and accept damaged
/// files or do not terminate on them (docs/contributing.md). Corners may refer to vertices that do not exist:
/// readMesh() checks them.
/// @param content the whole file; @param file its name, for messages
/// @throws InputError naming the file, the line of a text, what was expected and what was found
PolygonSoup readStl(const std::string& content, const std::filesystem::path& file);
PolygonSoup readObj(const std::string& content, const std::filesystem::path& file);
PolygonSoup readPly(const std::string& content, const std::filesystem::path& file);
PolygonSoup readOff(const std::string& content, const std::filesystem::path& file);

/// Largest count of anything in a file; indices are int.
constexpr long largestCount = std::numeric_limits<int>::max() / 8;

/// Iterates over the lines of a text that contain something besides comments, split into words. Independent
/// of the locale.
class TextScanner {
 public:
  /// @param comment character that starts a comment; 0: there are no comments
  TextScanner(std::string_view text, const std::filesystem::path& file, char comment)
      : text_(text), file_(file.string()), comment_(comment) {}

  /// Advances to the next line that contains words; false at the end of the text.
  bool next() {
    while (at_ < text_.size()) {
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      std::string_view line = text_.substr(at_, end - at_);
      at_ = end + 1;
      pollAt(++line_);
      if (comment_) line = line.substr(0, std::min(line.find(comment_), line.size()));
      split(line);
      if (!words_.empty()) return true;
    }
    words_.clear();
    return false;
  }

  /// As next(), but the end of the text is an error.
  void need(const std::string& expected) {
    if (!next())
      throw InputError(file_ + ": the file ends after line " + std::to_string(line_) + ", expected " +
                       expected);
  }

  /// The text after the current line.
  std::string_view rest() const { return text_.substr(std::min(at_, text_.size())); }

  const std::vector<std::string_view>& words() const { return words_; }

  /// Word `k` of the line in lower case; empty if it does not exist.
  std::string lower(std::size_t k) const {
    std::string word(k < words_.size() ? words_[k] : std::string_view());
    for (char& c : word)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return word;
  }

  /// Word `k` of the line as an integer in [lo, hi].
  long integer(std::size_t k, const char* what, long lo, long hi) const {
    long value = 0;
    if (k >= words_.size() || !parse(words_[k], value)) fail(what, k);
    if (value < lo || value > hi)
      fail(std::string(what) + " between " + std::to_string(lo) + " and " + std::to_string(hi), k);
    return value;
  }

  double coordinate(std::size_t k) const {
    double value = 0.0;
    if (k >= words_.size() || !parse(words_[k], value))
      fail(k < words_.size() && words_[k].find(',') != std::string_view::npos
               ? "a coordinate with a decimal point"
               : "a coordinate",
           k);
    if (!std::isfinite(value)) fail("a coordinate that is a finite number", k);
    if (std::abs(value) > tolerance::largestCoordinate)
      fail("a coordinate of at most " + toText(tolerance::largestCoordinate, 3), k);
    return value;
  }

  /// Words k, k+1, k+2 as coordinates.
  Vec3 point(std::size_t k) const { return {coordinate(k), coordinate(k + 1), coordinate(k + 2)}; }

  [[noreturn]] void fail(const std::string& expected, std::size_t k) const {
    std::string found =
        k < words_.size() ? "'" + std::string(words_[k].substr(0, 40)) + "'" : "the end of the line";
    for (char& c : found)
      if (static_cast<unsigned char>(c) < 32) c = '?';
    throw InputError(file_ + ":" + std::to_string(line_) + ": expected " + expected + ", found " + found);
  }

  /// Whether all of `word` is a number of type T, which is then stored in `value`.
  template <class T>
  static bool parse(std::string_view word, T& value) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    const std::from_chars_result result = std::from_chars(word.data(), word.data() + word.size(), value);
    if constexpr (std::is_floating_point_v<T>) {
      // The number is too small or too large for T: the value is 0 or infinity, which the callers reject.
      if (result.ec == std::errc::result_out_of_range) value = T(outOfRange(word));
      return result.ec != std::errc::invalid_argument && result.ptr == word.data() + word.size();
    }
    return result.ec == std::errc() && result.ptr == word.data() + word.size();
  }

 private:
  static double outOfRange(std::string_view word) {
    const std::size_t exponent = word.find_first_of("eE");
    const bool tiny =
        exponent != std::string_view::npos && exponent + 1 < word.size() && word[exponent + 1] == '-';
    return tiny ? 0.0 : HUGE_VAL;
  }

  void split(std::string_view line) {
    words_.clear();
    constexpr std::string_view blanks = " \t\r\v\f";
    for (std::size_t from = line.find_first_not_of(blanks); from != std::string_view::npos;) {
      const std::size_t to = std::min(line.find_first_of(blanks, from), line.size());
      words_.push_back(line.substr(from, to - from));
      from = line.find_first_not_of(blanks, to);
    }
  }

  std::string_view text_;
  std::string file_;
  char comment_;
  std::size_t at_ = 0, line_ = 0;
  std::vector<std::string_view> words_;
};

}  // namespace packmesh
