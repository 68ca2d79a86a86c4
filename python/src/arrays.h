// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packings as arrays of NumPy, and arrays as lines of .pos files.
#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/session/held_packing.h"

using Held = std::shared_ptr<const packmesh::hemocell::HeldPacking>;

/// What Python holds: a packing that never changes. A loaded one is replaced by the same one with its scene
/// as soon as that is needed, while other threads may still read the former. Python's lock protects the
/// pointer.
struct PythonPacking {
  Held held;
};

pybind11::tuple vectorOf(const packmesh::Vec3& v);

/// Vertices, shape (V, 3), and triangles, shape (T, 3).
pybind11::tuple arraysOf(const packmesh::TriangleMesh& mesh);

/// The lines of .pos files, shape (n, 6).
pybind11::array_t<double> arrayOf(const std::vector<packmesh::hemocell::PosLine>& lines);

/// @throws InputError if `text` cannot be the name of cells, which is that of their file
std::string cellName(const std::string& text);

using Rows = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;
/// @throws InputError unless they are finite, shape (n, 6)
std::vector<packmesh::hemocell::PosLine> linesOf(const std::string& name, const Rows& rows);

/// Views of what the packing holds, shapes (N, 3) and (N, 4), which are not written to.
pybind11::array positionsOf(const PythonPacking& packing);
pybind11::array rotationsOf(const PythonPacking& packing);
/// Of each cell: index into HeldPacking::kinds.
pybind11::array_t<std::int32_t> speciesOf(const PythonPacking& packing);
/// Of the cells of a kind: their vertices, shape (n, V, 3).
pybind11::array_t<double> verticesOf(const PythonPacking& packing, int species);
/// Vertices and triangles of a kind.
pybind11::tuple templateOf(const PythonPacking& packing, int species);
