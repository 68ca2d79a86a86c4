// SPDX-License-Identifier: AGPL-3.0-or-later
// fuzz_replay entry folder mutations: reads every file of a corpus, and so many mutations of them, with the
// entry functions of the fuzzers. The same ones each time; for builds without libFuzzer.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/fuzz/entries.h"

namespace {

std::string mutated(std::string text, const std::string& other, const std::vector<std::string>& words,
                    std::mt19937& random) {
  const auto below = [&](std::size_t n) { return std::size_t(random() % (n + 1)); };
  for (std::size_t changes = 1 + below(3); changes > 0; --changes) {
    const std::size_t at = below(text.size()), length = below(std::min<std::size_t>(text.size() - at, 40));
    switch (random() % 6) {
      case 0:
        if (at < text.size()) text[at] = char(random());
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, words[random() % words.size()]);
        break;
      case 3:
        text.insert(below(text.size()), text.substr(at, length));
        break;
      case 4:
        text.replace(at, length, other.substr(std::min(at, other.size()), length));
        break;
      default:
        if (random() % 4 == 0) text.resize(at);
    }
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 1;
  for (const packmesh::test::FuzzEntry& entry : packmesh::test::fuzzEntries()) {
    if (entry.name != argv[1]) continue;
    std::vector<std::filesystem::path> files;
    for (const auto& file : std::filesystem::directory_iterator(argv[2])) files.push_back(file.path());
    std::sort(files.begin(), files.end());
    if (files.empty()) return 1;
    std::vector<std::string> texts;
    for (const auto& path : files) {
      std::ifstream file(path, std::ios::binary);
      texts.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
      std::fprintf(stderr, "%s\n", path.c_str());
      entry.read(texts.back());
    }
    std::mt19937 random(1);
    for (int i = std::atoi(argv[3]); i > 0; --i) {
      const std::string input =
          mutated(texts[random() % texts.size()], texts[random() % texts.size()], entry.words, random);
      std::ofstream("fuzz_replay_" + entry.name + ".last", std::ios::binary) << input;
      entry.read(input);
    }
    std::printf("%s: %zu files and %s mutations\n", argv[1], files.size(), argv[3]);
    return 0;
  }
  return 1;
}
