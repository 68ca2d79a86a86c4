// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/log.h"

#include <fmt/format.h>

#include <cstdio>

namespace packmesh::hemocell::log {
namespace {

Level currentLevel = Level::normal;

void line(std::FILE* stream, const char* kind, const std::string& message) {
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
  if (currentLevel != Level::quiet) line(stdout, "", message);
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
