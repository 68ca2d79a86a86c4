// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The species of a problem as files have them: the deformed cells of a kind are one, with a table of
/// vertices. Internal to packMesh/packing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/packing/packing_state.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

class Hdf5Writer;

class FiledSpecies {
 public:
  /// References the physics, which must outlive it.
  explicit FiledSpecies(const Physics& physics);

  /// Number in files of a species of the problem; -1 if there is none.
  std::int32_t of(int species) const {
    return species >= 0 && species < int(groupOf_.size()) ? groupOf_[species] : -1;
  }
  /// The species of the problem of a cell with this number of a species in the file; empty if there is none.
  std::optional<int> speciesOf(std::int64_t group, std::int64_t id) const;

  /// Writes names, numbers and templates: group `/species`. All ranks call.
  void write(Hdf5Writer& out) const;
  /// Writes the membranes of the cells of a state. All ranks call.
  void writeMembranes(Hdf5Writer& out, const PackingState& state, const Communicator& ranks) const;

 private:
  struct Group {
    int first = 0;    ///< of the species of the problem
    int species = 0;  ///< how many, in succession
    std::int64_t count = 0;
    const Shape* shape = nullptr;  ///< the template
  };
  const Physics& physics_;
  std::vector<Group> groups_;
  std::vector<std::int32_t> groupOf_;  ///< by species of the problem
  std::vector<std::int64_t> firstId_;  ///< likewise, and one past the last
};

}  // namespace packmesh
