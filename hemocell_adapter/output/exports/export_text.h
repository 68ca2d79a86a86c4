// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Texts that several export formats share. Numbers have the fewest digits that read back to the same
/// bits.
#pragma once

#include <string>

#include "hemocell_adapter/output/exports/exported_file.h"
#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// "x y z".
std::string numbers(const Vec3& v, const char* separator = " ");
/// "w x y z".
std::string numbers(const Quaternion& q, const char* separator = " ");

/// `<Cell>_template.off`: the template as packed.
ExportedFile templateFile(const CellSpecies& species);

}  // namespace packmesh::hemocell
