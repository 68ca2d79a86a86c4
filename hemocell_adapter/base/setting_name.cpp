// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/setting_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace packmesh::hemocell {
namespace {

// Control characters, which log lines cannot have otherwise (log.cpp removes them).
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
