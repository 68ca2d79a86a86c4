// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The lumen of a problem: container, lattice, and the nodes where HemoCell keeps cells.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/acceptance.h"
#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/hemocell/pre_inlet.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/container/container.h"
#include "packMesh/container/region.h"

namespace packmesh::hemocell {

/// A part of the lumen.
struct LumenRegion {
  std::string name;  ///< "region 1", "the rest"
  std::shared_ptr<const Region> region;
  double share = 0.0;                 ///< of the lumen's volume
  std::optional<double> hematocrit;   ///< of all its red cells; empty: a number, or as in the rest
  std::optional<std::int64_t> count;  ///< of all its red cells
  /// Whether the hematocrit or the number is its own, and red cells of its own are part of them.
  bool own = false;
  std::vector<RegionSpecies> species;  ///< cells that are in it beside those of the lumen

  std::int64_t ofSpecies(const std::string& cell) const {
    for (const RegionSpecies& one : species)
      if (one.name == cell) return one.count;
    return 0;
  }
};

/// The lattice of the same lumen at another spacing.
struct OtherLattice {
  double dx = 0.0;  ///< [µm]
  /// From coordinates of .pos files at the spacing of the case to those at this one [µm]: the frame of a
  /// vessel begins a node before its surface.
  Vec3 shift = Vec3::Zero();
  std::shared_ptr<const Lattice> lattice;
};

struct Lumen {
  std::shared_ptr<const Container> container;
  std::shared_ptr<const Lattice> lattice;  ///< nullptr without a case
  std::vector<OtherLattice> others;        ///< at which HemoCell is to keep the cells, too
  /// Without a lattice but in a box: where HemoCell would keep vertices, (lo, hi] [µm].
  std::optional<Box> keptBox;
  bool periodic = false;      ///< cells may wrap around; HemoCell drops those that do
  bool acceptedOnly = false;  ///< packing observes HemoCell's acceptance rules
  bool solidWalls = true;     ///< false: its boundaries are faces through which blood flows
  std::string note;           ///< for readers: what container->describe() does not contain
  std::string scale;          ///< what becomes of the size of the geometry, unless it is that of its file
  std::vector<std::string> notices;  ///< assumptions the user should know of
  std::vector<std::string> repairs;  ///< of meshes

  /// The volume to which a hematocrit refers [µm³].
  double fluidVolume() const { return lattice ? lattice->fluidVolume() : container->volume(); }
};

}  // namespace packmesh::hemocell
