// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The lumen of a job: container, lattice, and where HemoCell keeps cells.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/acceptance.h"
#include "hemocell_adapter/problem/job.h"
#include "packMesh/container/container.h"
#include "packMesh/container/region.h"

namespace packmesh::hemocell {

/// A part of the lumen, with a hematocrit of its own.
struct LumenRegion {
  std::string name;  ///< "region 1 (config.xml:12: <sphere>)", "the rest"
  std::shared_ptr<const Region> region;
  double share = 0.0;       ///< of the lumen's volume
  double hematocrit = 0.0;  ///< asked for
};

struct Lumen {
  std::shared_ptr<const Container> container;
  std::shared_ptr<const Lattice> lattice;  ///< nullptr without a case
  /// Without a lattice but in a box: where HemoCell would keep vertices, (lo, hi] [µm].
  std::optional<Box> keptBox;
  bool periodic = false;             ///< cells may wrap around; HemoCell drops those that do
  bool acceptedOnly = false;         ///< packing keeps to HemoCell's acceptance rules
  bool solidWalls = true;            ///< false: what bounds it are faces through which blood flows
  std::vector<LumenRegion> regions;  ///< empty: one hematocrit for all of it; else the last is the rest
  std::string note;                  ///< for people: what container->describe() does not know
  std::vector<std::string> notices;  ///< assumptions and repairs the user should know of

  /// The volume a hematocrit is a share of [µm³].
  double fluidVolume() const { return lattice ? lattice->fluidVolume() : container->volume(); }
};

/// Builds the lumen of a job, for packing and checking alike.
///
/// The ends of a case's lumen are closed unless the job says otherwise, although HemoCell's flow is periodic:
/// the cells it keeps do not cross them, so that none of those can meet the image of another one.
/// @throws InputError, MeshError
Lumen makeLumen(const Job& job);

/// The wall as one species meets it when packing; nullptr: the container's own.
std::shared_ptr<const Wall> speciesWall(const Lumen& lumen, int minimumDistanceFromSolid, double reach,
                                        double wallClearance);

/// A body as a container on its own.
/// @param periodic axes along which it repeats
std::shared_ptr<const Container> makeSolid(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                           std::vector<std::string>& notices);

}  // namespace packmesh::hemocell
