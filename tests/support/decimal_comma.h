// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A locale with a decimal comma.
#pragma once

#include <clocale>
#include <cstdlib>
#include <locale>
#include <stdexcept>

#include "tests/support/places.h"

namespace packmesh::test {

/// While it lives, the C library and C++ streams of this process write 1,5 for one and a half.
class DecimalComma {
 public:
  DecimalComma() {
    ::setenv("LOCPATH", localeFolder, 1);  // made by tests/CMakeLists.txt
    before_ = std::locale::global(std::locale("de_DE.UTF-8"));
    ::unsetenv("LOCPATH");
    if (*std::localeconv()->decimal_point == ',') return;
    std::locale::global(before_);
    throw std::runtime_error("the locale has no decimal comma");
  }
  ~DecimalComma() { std::locale::global(before_); }
  DecimalComma(const DecimalComma&) = delete;
  DecimalComma& operator=(const DecimalComma&) = delete;

 private:
  std::locale before_;
};

}  // namespace packmesh::test
