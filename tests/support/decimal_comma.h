// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A locale with a decimal comma.
#pragma once

#include <catch2/catch.hpp>
#include <clocale>
#include <cstdlib>
#include <locale>
#include <string>

namespace packmesh::test {

/// While it lives, the C library and C++ streams of this process write 1,5 for one and a half.
class DecimalComma {
 public:
  DecimalComma() {
    REQUIRE(::setenv("LOCPATH", TEST_LOCALES, 1) == 0);  // made by tests/CMakeLists.txt
    before_ = std::locale::global(std::locale("de_DE.UTF-8"));
    REQUIRE(std::string(std::localeconv()->decimal_point) == ",");
  }
  ~DecimalComma() { std::locale::global(before_); }
  DecimalComma(const DecimalComma&) = delete;
  DecimalComma& operator=(const DecimalComma&) = delete;

 private:
  std::locale before_;
};

}  // namespace packmesh::test
