// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/running_case_file.h"

#include <fstream>
#include <sstream>
#include <vector>

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

/// Without white space between tags.
std::string printed(const tinyxml2::XMLDocument& document) {
  tinyxml2::XMLPrinter printer(nullptr, true);
  document.Print(&printer);
  return printer.CStr();
}

/// The words of the command line after the program; none where the system does not tell.
std::vector<std::string> commandLineWords() {
  std::ifstream in("/proc/self/cmdline");
  std::vector<std::string> words;
  for (std::string word; std::getline(in, word, '\0');) words.push_back(word);
  if (!words.empty()) words.erase(words.begin());
  return words;
}

}  // namespace

std::optional<fs::path> runningCaseFile(const tinyxml2::XMLDocument& document) {
  const std::string wanted = printed(document);
  std::vector<std::string> candidates = commandLineWords();
  candidates.push_back("config.xml");
  for (const fs::path candidate : candidates) {
    std::error_code ignored;
    constexpr std::uintmax_t most = 1 << 24;  // [bytes]; other files of the command line may be large
    if (!fs::is_regular_file(candidate, ignored) || fs::file_size(candidate, ignored) > most) continue;
    std::ostringstream text;
    text << std::ifstream(candidate).rdbuf();
    tinyxml2::XMLDocument other;
    if (other.Parse(text.str().c_str()) == tinyxml2::XML_SUCCESS && printed(other) == wanted)
      return candidate;
  }
  return {};
}

}  // namespace packmesh::hemocell
