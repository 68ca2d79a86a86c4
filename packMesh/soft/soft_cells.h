// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Deformable cells that grow and push each other away, free of intersections in every step.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "packMesh/parallel/threads.h"
#include "packMesh/problem/physics.h"
#include "packMesh/soft/contact_lists.h"
#include "packMesh/soft/membrane.h"
#include "packMesh/soft/soft_kernels.h"
#include "packMesh/soft/soft_shares.h"

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
  double momentum = 0.8;         ///< share of the last step that is added to the next
  double shareOfGap = 0.4;       ///< largest step: with less than a half nothing can meet
  double swelling = 0.006;       ///< of the scale per iteration
  double mostCompressed = 0.03;  ///< cells whose volume lacks more of that at rest do not grow
  /// Of bending as long as cells grow, so that they fold in few large folds; it then decreases
  /// in each iteration.
  double stiffening = 5.0;
};

struct SoftCell {
  std::shared_ptr<const Membrane> membrane;
  std::vector<Vec3> vertices;  ///< [µm]
  double scale = 1.0;          ///< of its state at rest
  bool fixed = false;          ///< it stays as it is
  int wall = -1;               ///< index into the walls; -1: none
};

/// Everything that the next steps depend on. Of cells: some numbers of each, and of each of its vertices.
struct SoftCellsState {
  std::int64_t iterations = 0;
  double stiffening = 1.0;
  double skin = 0.0;  ///< of the lists of contacts [µm]; 0: there are none
  static constexpr int perCell = 5, perVertex = 10;
  std::vector<double> cells;
  std::vector<float> vertices;
};

class SoftCells {
 public:
  /// Each rank computes the cells of a part of the lumen; few cells are computed by the first rank. All ranks
  /// call everything together, but for functions of single cells, and those of the ranks that compute.
  /// @param cells of all ranks
  /// @param period of the lumen along each axis, 0 where it is not periodic [µm]
  /// Pre: no two meshes meet, nor does one meet itself or the wall
  SoftCells(std::vector<SoftCell> cells, const Vec3& period, std::vector<WallGap> walls,
            const SoftSettings& settings, const Threads& threads, const Communicator& ranks = {});
  ~SoftCells();

  /// Whether this rank computes cells; with which others it does; steps at a time if others wait for it.
  bool computes() const { return shares_.computes(); }
  const Communicator& team() const { return shares_.team(); }
  std::int64_t stepsAtOnce() const { return shares_.isFirstAlone() ? 20 : 1; }
  /// Grows all cells that have room for it, and moves every vertex by a step down the energy. The result does
  /// not depend on the number of ranks and threads. Ranks that compute call it.
  void step();
  /// How far those have come that compute, for all. They also tell `more`. All ranks call it after steps.
  template <class T>
  T told(const T& more) {
    struct All {
      std::int64_t iterations;
      double stiffening, smallestScale;
      T more;
    } all{iterations_, stiffening_, smallestScale_, more};
    if (shares_.isFirstAlone()) all = shares_.ranks().fromFirst(all);
    iterations_ = all.iterations;
    stiffening_ = all.stiffening;
    smallestScale_ = all.smallestScale;
    return all.more;
  }

  /// Makes bending stiff again, as while cells grew, so that sharp folds open, and multiplies the range of
  /// the wall's barrier by a factor below 1, which gives them room.
  void unfold(double wallFactor) {
    narrowWall(wallFactor);
    stiffening_ = settings_.stiffening;
  }
  /// Of the same range; of cells that are continued.
  void narrowWall(double factor) { settings_.wallRange *= factor; }

  std::int64_t iterations() const { return iterations_; }
  /// Whether all cells have their full size, and the membranes their own stiffness.
  bool full() const { return stiffening_ == 1.0 && smallestScale() == 1.0; }
  double smallestScale() const { return smallestScale_; }
  /// Largest force on a vertex in the last step, of the cells that move, apart from the hundredth of them
  /// with the largest: that of all would grow with their number [pN]. Ranks that compute call it.
  double usualForce() const;

  const std::vector<int>& mine() const { return shares_.mine(); }  ///< the cells of this rank, ascending
  /// Makes all cells known to all ranks, until the next step.
  void gather();
  /// To free memory. No step may follow.
  void forgetContacts();
  // Pre: it is of this rank, or all are known to it
  double scale(std::size_t cell) const;  ///< of its state at rest
  std::vector<Vec3> vertices(std::size_t cell) const;

  /// With the numbers of this rank's share of the cells (IdShares).
  SoftCellsState state() const;
  /// Pre: of such cells, all of them
  void restore(const SoftCellsState& from);

 private:
  struct Batch;
  struct Cell;
  template <class T>
  class Pages;
  struct Thread;
  void addCells(const std::vector<SoftCell>& cells, const Communicator& ranks);
  void fillBatches(const std::vector<SoftCell>& cells);
  void summarize();
  void listContacts();
  void forgetOthers();
  void exchange();
  void pack(int cell, std::vector<float>& to) const;
  const float* unpack(int cell, const float* from);
  SoftNeighbors neighbors() const;
  void listFor(int i, const std::vector<std::pair<int, Vec3>>& neighbors, Thread& thread);
  void contacts(Cell& cell, Thread& thread) const;
  void reactions(Cell& cell) const;
  void wallForces(Cell& cell, float scale) const;
  void advance(Batch& batch, std::vector<float>& scratch);
  void grow();

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
  SoftShares shares_;
  std::vector<int> listing_;    ///< cells with contacts that concern those of this rank
  std::vector<Batch> batches_;  ///< of this rank
  std::vector<Thread> ofThread_;
  std::int64_t iterations_ = 0;
  double stiffening_;
  double smallestScale_ = 1.0;
  float farthest_ = 0.0f;  ///< of all vertices, since contacts were listed [µm]
  double skin_ = 0.0;      ///< of the lists [µm]
  float mostStep_ = 0.0f;  ///< of the current iteration [µm]
  bool listed_ = false;
};

}  // namespace packmesh
