// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One kind of cell of a problem.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/hemocell/acceptance.h"
#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "packMesh/problem/physics.h"

namespace packmesh::hemocell {

/// A cell that exists already. Not a Cell: a line of a .pos file keeps the angles that it states.
struct PresentCell : PosLine {
  PresentCell() = default;
  PresentCell(const PosLine& line) : PosLine(line) {}
  /// Of a mesh of its own, in the order and frame of the template [µm], until Scene has a shape of it;
  /// empty: it has the mesh of the template.
  std::vector<Vec3> vertices;
  int shape = -1;   ///< then: index into Scene::shapes
  int species = 0;  ///< index into Scene::species, as soon as there are any
};

/// What flowing blood provides for further cells of a species.
struct FlowingBlood {
  std::int64_t cells = 0;            ///< of the piece
  std::vector<PresentCell> crowded;  ///< cells that meet others, which start the first of them
  std::vector<int> shapes;           ///< that they have; empty: the template
};

/// What is to be built of a SpeciesRequest: template, existing cells, and how their number is determined.
struct SpeciesPlan {
  enum class Template { model, mesh, ellipsoid, built };
  std::string name;
  Template kind = Template::model;
  CellModel model;         ///< model
  Source meshFile;         ///< mesh
  double meshScale = 1.0;  ///< mesh: µm per unit of the file
  MeshFrame meshFrame = MeshFrame::hemocell;
  Vec3 ellipsoidAxes = Vec3::Zero();  ///< ellipsoid: full lengths [µm]
  TriangleMesh builtMesh;             ///< built: by a running HemoCell [µm]
  std::string origin;                 ///< "RBC.xml, RBC_FROM_SPHERE", for people
  bool redCell = false;
  /// A red cell included in the requested hematocrit; under packCells' convention those with a count are not.
  bool sharesHematocrit = false;
  std::optional<std::int64_t> statedCount;  ///< neither count nor ratio: determined by the hematocrit
  std::optional<double> ratio;
  std::optional<double> statedDistanceFromSolid;  ///< by the configuration [µm]
  int minimumDistanceFromSolid = 0;               ///< as HemoCell stores it [µm]
  std::string distanceFromSolidOrigin;            ///< "pipeflow.cpp:91", for people
  std::int64_t stock = 0;                         ///< additional cells in reserve
  std::vector<PresentCell> fixed, start;          ///< existing cells: fixed, or movable
  std::vector<Triangle> ownTriangles;             ///< of those with meshes of their own
  FlowingBlood blood;                             ///< what further cells are like
  std::string fixedFrom, startFrom;               ///< files
  double ownWallClearance = 0.0;                  ///< of this species, if larger than that of all [µm]
  std::optional<AxisCone> cone;
  bool rigid = false;  ///< its cells keep their shape beside soft ones

  /// Wall clearance of its cells, and by how much it exceeds that of the others [µm].
  double wallClearance(double ofAll) const { return std::max(ofAll, ownWallClearance); }
  double extraWallClearance(double ofAll) const { return wallClearance(ofAll) - ofAll; }
};

/// A species at another lattice spacing.
struct OtherAcceptance {
  std::shared_ptr<const Acceptance> acceptance;
  TriangleMesh mesh;  ///< that HemoCell builds there [µm]
};

/// One kind of cell as the user names it, with its shape and number.
struct CellSpecies : SpeciesPlan {
  CellSpecies() = default;
  explicit CellSpecies(SpeciesPlan plan) : SpeciesPlan(std::move(plan)) {}

  std::shared_ptr<const Shape> shape;
  /// Mean of the meshes that are placed [µm³]: that of the template, unless some cells have meshes of their
  /// own.
  double meanVolume = 0.0;
  double countedVolume = 0.0;  ///< of a cell, in the requested hematocrit [µm³]: this or a stated one
  std::shared_ptr<const Acceptance> acceptance;  ///< nullptr without a lattice
  std::vector<OtherAcceptance> others;           ///< at those of Lumen::others
  std::int64_t ofRegions = 0;                    ///< cells of regions, beside those of the lumen
  std::int64_t count = 0;                        ///< to be packed, or found by a check

  std::int64_t mostCells() const { return count + stock; }  ///< of a packing
  /// Without those that exist already with meshes of their own, which stay as they are.
  std::int64_t toPack() const {
    std::int64_t left = count;
    for (const auto* const present : {&fixed, &start})
      for (const PresentCell& cell : *present) left -= cell.shape >= 0;
    return std::max<std::int64_t>(0, left);
  }
};

}  // namespace packmesh::hemocell
