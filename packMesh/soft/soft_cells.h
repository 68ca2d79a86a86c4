// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Deformable cells that grow and push each other away, free of intersections in every step.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/soft/contact_lists.h"
#include "packMesh/soft/membrane.h"
#include "packMesh/soft/soft_kernels.h"

namespace packmesh {

/// Numbers of the method. Lengths are for cells of full size; they are multiplied by the scales of smaller
/// ones.
struct SoftSettings {
  double range = 0.14;           ///< of the barrier between a vertex and a triangle [µm]
  double edgeRange = 0.07;       ///< between two edges [µm]
  double wallRange = 0.2;        ///< between a vertex and the wall [µm]
  double skin = 0.2;             ///< contacts are listed up to their range and this [µm]
  double stiffness = 20.0;       ///< of barriers [pN/µm]
  double clearance = 0.0;        ///< that the barriers between cells keep [µm]
  double momentum = 0.9;         ///< share of the last step that is added to the next
  double shareOfGap = 0.4;       ///< largest step: with less than a half nothing can meet
  double swelling = 0.006;       ///< of the scale per iteration
  double mostCompressed = 0.03;  ///< cells whose volume lacks more of that at rest do not grow
  /// Of bending as long as cells grow, so that they fold in few large folds; it then decreases by a twentieth
  /// in each iteration.
  double stiffening = 5.0;
};

/// Distance beyond the least that a wall demands, or a lower bound of it, and its gradient. Called by several
/// threads.
using WallGap = std::function<WallDistance(const Vec3&)>;

struct SoftCell {
  std::shared_ptr<const Membrane> membrane;
  std::vector<Vec3> vertices;  ///< [µm]
  double scale = 1.0;          ///< of its state at rest
  bool fixed = false;          ///< it stays as it is
  int wall = -1;               ///< index into the walls; -1: none
};

class SoftCells {
 public:
  /// @param period of the lumen along each axis, 0 where it is not periodic [µm]
  /// Pre: no two meshes meet, nor does one meet itself or the wall
  SoftCells(std::vector<SoftCell> cells, const Vec3& period, std::vector<WallGap> walls,
            const SoftSettings& settings, const Threads& threads);
  ~SoftCells();

  /// Grows all cells that have room for it, and moves every vertex by a step down the energy. The result does
  /// not depend on the number of threads.
  void step();

  std::int64_t iterations() const { return iterations_; }
  /// Whether all cells have their full size, and the membranes their own stiffness.
  bool full() const { return stiffening_ == 1.0 && smallestScale() == 1.0; }
  double smallestScale() const;
  double scale(std::size_t cell) const;  ///< of its state at rest
  double largestForce() const;           ///< on a vertex of a cell that moves, in the last step [pN]
  std::vector<Vec3> vertices(std::size_t cell) const;

 private:
  struct Batch;
  struct Cell;
  void addCells(const std::vector<SoftCell>& cells);
  void fillBatches(const std::vector<SoftCell>& cells);
  void listContacts();
  std::vector<std::vector<std::pair<int, Vec3>>> neighbors() const;
  void listFor(int i, const std::vector<std::pair<int, Vec3>>& neighbors);
  void contacts(Cell& cell) const;
  void reactions(Cell& cell) const;
  void wallForces(Cell& cell, float scale) const;
  void advance(Batch& batch, std::vector<float>& scratch);
  void grow();
  double scaleOf(const Cell& cell) const;

  std::vector<WallGap> walls_;
  Vec3 period_;
  SoftSettings settings_;
  Threads threads_;
  ContactKernels kernels_;
  MembraneKernel membraneKernel_;
  std::vector<std::shared_ptr<const Membrane>> membranes_;
  std::vector<MembraneView> views_;
  std::vector<Clusters> clusters_;
  std::vector<Cell> cells_;
  std::vector<Batch> batches_;
  std::vector<std::vector<float>> scratch_;  ///< of each thread
  std::int64_t iterations_ = 0;
  double stiffening_;
  double skin_ = 0.0;      ///< of the lists [µm]
  float mostStep_ = 0.0f;  ///< of the current iteration [µm]
  bool listed_ = false;
};

}  // namespace packmesh
