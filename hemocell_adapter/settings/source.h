// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a request takes meshes, cells and tables from: files, or numbers in memory.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/packing/state_cells.h"

namespace packmesh::hemocell {

/// Numbers that a front end gives instead of a file: a mesh has the tables "vertices" (3 columns, in the unit
/// of the request) and "triangles" (3), a profile one of a column for each of its own, lines of .pos files
/// one of 6 columns for each kind of cell; cells of a state those of storedCells().
struct Given {
  std::string key;   ///< its name in JSON and in states, unique in a request
  std::string what;  ///< the setting, with which messages begin (setting_name.h)
  std::vector<StateTable> tables;

  const StateTable* find(const std::string& name) const;
};
/// By their keys.
using Gifts = std::map<std::string, std::shared_ptr<const Given>>;

/// A file or numbers in memory. Messages name it by string().
struct Source {
  Source() = default;
  Source(std::filesystem::path path) : file(std::move(path)) {}
  Source(const std::string& path) : file(path) {}
  Source(const char* path) : file(path) {}
  Source(std::shared_ptr<const Given> numbers) : file(numbers->what), given(std::move(numbers)) {}

  std::filesystem::path file;  ///< with numbers: what messages call them
  std::shared_ptr<const Given> given;

  bool empty() const { return file.empty(); }
  std::string string() const { return file.string(); }
};
inline bool operator==(const Source& a, const Source& b) {
  return a.file == b.file && a.given == b.given;
}

/// Whether a source of existing cells is a state, by the name of the file; otherwise it has lines of .pos
/// files.
bool isState(const Source& source);

/// The mesh, as readMesh() reads it. @throws InputError
TriangleMesh meshFrom(const Source& source, std::vector<std::string>* notes = nullptr);

/// The cells of a state; of numbers in memory all ranks have them, and this one's share is returned. All
/// ranks call. @throws InputError
StateCells cellsFrom(const Source& source, const Communicator& ranks, bool withMeshes = true);

/// Cells of a state as numbers. Pre: all of them
std::vector<StateTable> storedCells(const StateCells& state);

}  // namespace packmesh::hemocell
