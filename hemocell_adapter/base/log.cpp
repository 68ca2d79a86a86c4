// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/log.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

#include "hemocell_adapter/base/plain_text.h"
#include "hemocell_adapter/base/setting_name.h"

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
