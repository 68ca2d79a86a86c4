// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Where the tests find files and programs. CMake fills in places.cpp, so that all other objects are
/// the same in every folder and a compiler cache can share them.
#pragma once

namespace packmesh::test {

extern const char* const sourceFolder;
extern const char* const programFolder;  ///< of the built programs
extern const char* const localeFolder;   ///< of a locale with a decimal comma
extern const int timeout;                ///< of a test [s]

}  // namespace packmesh::test
