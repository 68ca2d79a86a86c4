// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One kind of cell of a job.
#pragma once

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/acceptance.h"
#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "packMesh/relaxation/freedom.h"

namespace packmesh::hemocell {

/// A SpeciesRequest, resolved: makeJob() fills in what it is made of and how its number is decided,
/// buildScene() what follows from these and from the lumen.
struct CellSpecies {
  // By makeJob().
  enum class Template { model, mesh, ellipsoid };
  std::string name;
  Template kind = Template::model;
  CellModel model;                 ///< model
  std::filesystem::path meshFile;  ///< mesh
  double meshScale = 1.0;          ///< mesh: µm per unit of the file
  MeshFrame meshFrame = MeshFrame::hemocell;
  Vec3 ellipsoidAxes = Vec3::Zero();  ///< ellipsoid: full lengths [µm]
  std::string origin;                 ///< "RBC.xml, RBC_FROM_SPHERE", for people
  bool redCell = false;
  /// A red cell that the hematocrit asked for includes; packCells' leaves out those with a count.
  bool sharesHematocrit = false;
  std::optional<std::int64_t> statedCount;  ///< neither count nor ratio: the hematocrit decides
  std::optional<double> ratio;
  std::optional<double> statedDistanceFromSolid;  ///< by the configuration [µm]
  int minimumDistanceFromSolid = 0;               ///< as HemoCell has it [µm]
  std::string distanceFromSolidOrigin;            ///< "pipeflow.cpp:91", for people
  std::int64_t stock = 0;                         ///< so many more, when escaping
  std::vector<PosLine> fixed, start;              ///< existing cells: that stay, or may move
  std::string fixedFrom, startFrom;               ///< files
  double ownWallClearance = 0.0;                  ///< of this species, where more than that of all [µm]
  std::optional<AxisCone> cone;

  // By buildScene().
  std::shared_ptr<const Shape> shape;
  double countedVolume = 0.0;                    ///< of a cell, in the hematocrit asked for [µm³]
  std::shared_ptr<const Acceptance> acceptance;  ///< nullptr without a lattice
  std::int64_t count = 0;                        ///< to be packed
  std::shared_ptr<const Wall> wall;              ///< where packing allows it; nullptr: the container's own

  std::int64_t mostCells() const { return count + stock; }  ///< of a packing

  /// What its cells keep from the wall, and how much of that is more than the others keep [µm].
  double wallClearance(double ofAll) const { return std::max(ofAll, ownWallClearance); }
  double extraWallClearance(double ofAll) const { return wallClearance(ofAll) - ofAll; }
};

}  // namespace packmesh::hemocell
