// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Dicts and arrays of Python as requests and numbers, and packings as arrays.
#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/session/in_memory.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/packing/state_file.h"

/// Of a dict with what JSON would have (request_json.h), and numbers of NumPy where a file may be. Needs
/// Python's lock. @throws UsageError
packmesh::hemocell::Request requestOf(const pybind11::dict& stated);

/// A request as such a dict; {"given": ...} stands for numbers.
pybind11::object dictOf(const packmesh::hemocell::Request& request);

/// The words of a command that states a request; None if numbers are given, which no command has.
pybind11::object wordsIn(const packmesh::hemocell::Request& request);

/// Numbers that a request takes in place of a file.
struct PythonNumbers {
  std::shared_ptr<const packmesh::hemocell::MemoryInput> given;
};

/// @param setting, of it, with which messages begin
PythonNumbers numbersOf(const std::string& setting, const std::string& of,
                        std::vector<packmesh::StateTable> tables);

void addRequests(pybind11::module_& module);

/// Adds Lumen, lumen(), Meshes, cell_template() and save_cells(), for the analysis of runs
/// (run_analysis.cpp).
void addRunAnalysis(pybind11::module_& module);

/// A packing, or the cells of a state until their packing is needed. Each rank has its share of them.
struct HeldCells {
  std::vector<packmesh::StateCells::Kind> kinds;  ///< their numbers are those of all ranks
  packmesh::Communicator ranks;
  std::filesystem::path file;  ///< from which they were loaded; empty if they were packed
  std::shared_ptr<const packmesh::hemocell::Packing> packing;  ///< nullptr: only loaded
  std::vector<int> kindOf;                                     ///< of each species of the packing
  std::shared_ptr<const packmesh::StateCells> loaded;          ///< nullptr: there is a packing

  std::size_t size() const { return packing ? packing->cells.size() : loaded->cells.size(); }
  const packmesh::Pose& pose(std::size_t cell) const {
    return packing ? packing->poses[cell] : loaded->cells[cell].pose;
  }
  int kind(std::size_t cell) const {
    return packing ? kindOf[packing->cells[cell].species] : loaded->cells[cell].species;
  }
  /// Vertices of a cell that has a mesh of its own, in the frame of the template [µm]; nullptr: it has that.
  const std::vector<packmesh::Vec3>* ownVertices(std::size_t cell) const;
  /// As it is written.
  packmesh::Placement placement(std::size_t cell) const;
  /// What was asked for; nullptr: its state does not say.
  std::shared_ptr<const packmesh::hemocell::Request> request() const;
};
using Held = std::shared_ptr<const HeldCells>;

/// What Python holds: cells that never change. Loaded ones are replaced by their packing as soon as that is
/// needed, while other threads may still read the former. Python's lock protects the pointer.
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
/// Of each cell: index into HeldCells::kinds.
pybind11::array_t<std::int32_t> speciesOf(const PythonPacking& packing);
/// Of the cells of a kind: their vertices, shape (n, V, 3).
pybind11::array_t<double> verticesOf(const PythonPacking& packing, int species);
/// Vertices and triangles of a kind.
pybind11::tuple templateOf(const PythonPacking& packing, int species);
