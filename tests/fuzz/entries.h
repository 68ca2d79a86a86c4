// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What reads files and words of users, called with any bytes.
#pragma once

#include <string>
#include <vector>

namespace packmesh::test {

/// Reads `bytes` as users' input of a kind. Returns when they were understood or refused with a message;
/// every other exception passes, and ends the program.
struct FuzzEntry {
  std::string name;
  void (*read)(const std::string& bytes);
  std::vector<std::string> words;  ///< what a mutation may put in
};

const std::vector<FuzzEntry>& fuzzEntries();

}  // namespace packmesh::test
