// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/messages.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <utility>

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

namespace {

constexpr double minute = 60.0, hour = 3600.0, day = 86400.0, year = 365.25 * day;

/// "3 h 20 min"; the second part is omitted if it is 0.
std::string inTwoParts(double seconds, double large, const char* largeName, double small,
                       const char* smallName) {
  const auto parts = static_cast<std::int64_t>(std::llround(seconds / small));
  const auto perLarge = static_cast<std::int64_t>(large / small);
  std::string text = fmt::format("{} {}", parts / perLarge, largeName);
  if (parts % perLarge != 0) text += fmt::format(" {} {}", parts % perLarge, smallName);
  return text;
}

}  // namespace

std::string durationText(double seconds) {
  if (seconds < 10.0) return fmt::format("{:.3g} s", seconds);
  if (seconds < 2 * minute) return fmt::format("{:.0f} s", seconds);
  if (seconds < 2 * hour) return inTwoParts(seconds, minute, "min", 1.0, "s");
  if (seconds < 2 * day) return inTwoParts(seconds, hour, "h", minute, "min");
  if (seconds < 2 * year) return fmt::format("{:.0f} days", seconds / day);
  if (seconds < 1000 * year) return fmt::format("{:.0f} years", seconds / year);
  return "more than 1000 years";
}

namespace {

// Control characters, which log lines cannot have otherwise (messages.cpp removes them).
constexpr char markBegins = '\x01', markEnds = '\x02', partEnds = '\x03';

std::string mark(const SettingName& setting) {
  return fmt::format("{}{}{}{}{}{}{}{}{}", markBegins, setting.name, partEnds, setting.value, partEnds,
                     setting.of, partEnds, setting.begins ? "1" : "", markEnds);
}

/// Of what has no option: species["RBC"].count, obstacles[0].
std::string pathOf(const SettingName& setting) {
  const std::size_t dot = std::min(setting.name.find('.'), setting.name.size());
  const bool isNumber = setting.of.find_first_not_of("0123456789") == std::string::npos;
  const char* const quote = isNumber ? "" : "\"";
  const std::string which = setting.of.empty() ? "" : fmt::format("[{0}{1}{0}]", quote, setting.of);
  return setting.name.substr(0, dot) + which + setting.name.substr(dot);
}

std::function<std::string(const SettingName&)>& currentTerms() {
  static std::function<std::string(const SettingName&)> terms = termOfProgram;
  return terms;
}

}  // namespace

std::string termOfProgram(const SettingName& setting) {
  for (const char* const several : {"species", "obstacles", "regions"})
    if (setting.name.rfind(several, 0) == 0) return pathOf(setting);
  if (setting.name == "box") return "sX sY sZ";
  const std::string option = "--" + setting.name;
  if (setting.begins)
    return fmt::format("option '{}'{}{}", option, setting.of.empty() ? "" : " ", setting.of);
  return option + (setting.value.empty() ? "" : " ") + setting.value;
}

std::string named(const std::string& name, const std::string& value) {
  return mark({name, value, "", false});
}

std::string heading(const std::string& name, const std::string& of) {
  return mark({name, "", of, true});
}

void setTerms(std::function<std::string(const SettingName&)> terms) {
  currentTerms() = std::move(terms);
}

std::string inTermsOfUser(const std::string& message) {
  std::string text;
  std::size_t done = 0;
  for (std::size_t at = message.find(markBegins); at != std::string::npos;
       at = message.find(markBegins, done)) {
    const std::size_t end = message.find(markEnds, at);
    if (end == std::string::npos) break;
    std::array<std::string, 4> parts;
    std::size_t from = at + 1;
    for (std::string& part : parts) {
      const std::size_t to = std::min(message.find(partEnds, from), end);
      if (from < end) part = message.substr(from, to - from);
      from = to + 1;
    }
    text +=
        message.substr(done, at - done) + currentTerms()({parts[0], parts[1], parts[2], !parts[3].empty()});
    done = end + 1;
  }
  return text + message.substr(done);
}

}  // namespace packmesh::hemocell

namespace packmesh::hemocell::log {
namespace {

Level currentLevel = Level::normal;
bool statusShown = false;
std::function<void(Kind, const std::string&)> currentSink;

void clearStatus() {
  if (!statusShown) return;
  fmt::print(stdout, "\r\x1b[K");
  std::fflush(stdout);
  statusShown = false;
}

void line(Kind kind, const std::string& message) {
  if (currentLevel == Level::silent) return;
  // Messages quote file contents: remove control characters, which would affect the user's terminal.
  const std::string text = withShortenedNames(plainText(inTermsOfUser(message)));
  if (currentSink) return currentSink(kind, text);
  clearStatus();
  std::FILE* const stream = kind < Kind::warning ? stdout : stderr;
  const char* const label = kind < Kind::warning ? "" : kind == Kind::error ? "(Error) " : "(Warning) ";
  fmt::print(stream, "(packMesh) {}{}\n", label, text);
  std::fflush(stream);
}

}  // namespace

void setLevel(Level level) {
  currentLevel = level;
}
Level level() {
  return currentLevel;
}
void setSink(std::function<void(Kind, const std::string&)> sink) {
  currentSink = std::move(sink);
}

namespace {

/// The part of a text that fits into a line of the terminal; multi-byte characters count once.
std::string fitting(const std::string& text) {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 2) return text;
  std::string out;
  int columns = 0;
  for (const char c : text) {
    const bool begins = (static_cast<unsigned char>(c) & 0xC0u) != 0x80u;
    if (begins && ++columns >= size.ws_col) break;
    out += c;
  }
  return out;
}

}  // namespace

bool isTerminal() {
  // Launchers give ranks pseudo-terminals, whatever the destination of the output.
  static const bool is = isatty(STDOUT_FILENO) != 0 && std::getenv("SLURM_JOB_ID") == nullptr &&
                         std::getenv("PMIX_RANK") == nullptr && std::getenv("PMI_RANK") == nullptr;
  return is;
}

void status(const std::string& message) {
  if (currentLevel <= Level::quiet) return;
  fmt::print(stdout, "\r{}\x1b[K", fitting("(packMesh) " + plainText(message)));
  std::fflush(stdout);
  statusShown = true;
}

void info(const std::string& message) {
  if (currentLevel > Level::quiet) line(Kind::info, message);
}

void detail(const std::string& message) {
  if (currentLevel == Level::verbose) line(Kind::detail, message);
}

void warning(const std::string& message) {
  line(Kind::warning, message);
}
void repair(const std::string& message) {
  line(Kind::repair, message);
}
void error(const std::string& message) {
  line(Kind::error, message);
}

}  // namespace packmesh::hemocell::log
