// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace packmesh::hemocell::log {
namespace {

Level currentLevel = Level::normal;

/// Messages quote what stands in files: control characters would reach the user's terminal.
void line(std::FILE* stream, const char* kind, std::string message) {
  if (currentLevel == Level::silent) return;
  std::replace_if(
      message.begin(), message.end(),
      [](unsigned char c) { return (c < ' ' && c != '\n' && c != '\t') || c == '\x7f'; }, '?');
  fmt::print(stream, "(packMesh) {}{}\n", kind, message);
  std::fflush(stream);
}

}  // namespace

void setLevel(Level level) {
  currentLevel = level;
}
Level level() {
  return currentLevel;
}

void info(const std::string& message) {
  if (currentLevel > Level::quiet) line(stdout, "", message);
}

void detail(const std::string& message) {
  if (currentLevel == Level::verbose) line(stdout, "", message);
}

void warning(const std::string& message) {
  line(stderr, "(Warning) ", message);
}
void error(const std::string& message) {
  line(stderr, "(Error) ", message);
}

}  // namespace packmesh::hemocell::log
