// SPDX-License-Identifier: AGPL-3.0-or-later
// One target of libFuzzer; FUZZ_ENTRY names which.
#include <cstdint>
#include <cstdlib>

#include "tests/fuzz/entries.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const packmesh::test::FuzzEntry* entry = [] {
    for (const packmesh::test::FuzzEntry& e : packmesh::test::fuzzEntries())
      if (e.name == FUZZ_ENTRY) return &e;
    std::abort();
  }();
  entry->read(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
