// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the analysis of runs needs of the library: lumens, and the exact test of deformed membranes.
#pragma once

#include <pybind11/pybind11.h>

/// Adds Lumen, lumen(), Meshes, cell_template() and save_cells().
void addRunAnalysis(pybind11::module_& module);
