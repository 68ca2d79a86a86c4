// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Figures of growth and CAT cells, as Markdown tables; see usage(). Cases are in
/// tests/benchmark/growth.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <regex>

#include "tests/benchmark/growth/cases.h"

using namespace packmesh::benchmark;

namespace {

void usage() {
  std::puts(
      "growth_benchmark --list\n"
      "growth_benchmark pattern ... [--seeds n] [--check]\n"
      "  pattern     runs the cases whose name contains a match of one of these regular expressions\n"
      "  --list      names the cases\n"
      "  --seeds n   packs with seeds 1 to n; figures are means\n"
      "  --check     packs once more and certifies every accepted state");
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::regex> patterns;
  Options options;
  bool list = false;
  try {
    for (int i = 1; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument == "--list")
        list = true;
      else if (argument == "--check")
        options.check = true;
      else if (argument == "--seeds" && i + 1 < argc)
        options.seeds = std::stoi(argv[++i]);
      else if (argument.rfind("--", 0) == 0) {
        usage();
        return argument == "--help" ? 0 : 2;
      } else
        patterns.emplace_back(argument);
    }
    std::vector<Case> cases = packingCases(), parts = partCases();
    cases.insert(cases.end(), parts.begin(), parts.end());
    std::sort(cases.begin(), cases.end(), [](const Case& a, const Case& b) { return a.name < b.name; });
    if (!list && patterns.empty()) {
      usage();
      return 2;
    }
    for (const Case& c : cases) {
      if (list) {
        fmt::print("{:24} {}\n", c.name, c.about);
        continue;
      }
      if (std::none_of(patterns.begin(), patterns.end(),
                       [&](const std::regex& pattern) { return std::regex_search(c.name, pattern); }))
        continue;
      fmt::print("## {}: {}\n\n", c.name, c.about);
      std::fflush(stdout);
      c.run(options);
      std::puts("");
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
