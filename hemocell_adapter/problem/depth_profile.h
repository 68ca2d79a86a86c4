// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How the cells of a packing are distributed over the distance from the wall.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "packMesh/container/side_depth.h"

namespace packmesh::hemocell {

/// The cells of one species.
struct SpeciesProfile {
  std::vector<double> asked;  ///< volume fraction in each layer; empty: anywhere in the lumen
  std::vector<double>
      weight;  ///< of each shell, to which the number of cells with their centre in it is proportional
  /// Part of the volume of such cells in each layer, [shell][layer]; empty where no cell fits.
  std::vector<std::vector<double>> spread;
  double freeLayer = 0.0;  ///< membranes stay further than this from the wall [µm]

  bool isAsked() const { return !asked.empty(); }
};

/// Volume fractions in layers along the wall, and the shells in which cells are kept so that they result.
struct DepthProfile {
  std::string source;  ///< for people: "core.txt", "developed flow: ..."
  std::shared_ptr<const SideDepth> depth;
  double width = 0.0;                   ///< of the layers, the first of which is at the wall [µm]
  std::vector<double> lumen;            ///< volume of each layer [µm³], up to a factor that they share
  std::vector<double> edges;            ///< of the shells, ascending from 0 to the largest depth [µm]
  std::vector<SpeciesProfile> species;  ///< of the problem

  int shells() const { return static_cast<int>(edges.size()) - 1; }
  int layerAt(double depthOfPoint) const;
  int shellAt(double depthOfPoint) const;
  /// Volume fraction of a species at a depth. Pre: isAsked()
  double askedAt(const SpeciesProfile& one, double depthOfPoint) const {
    return one.asked[layerAt(depthOfPoint)];
  }
  /// Mean of the volume fractions of a species in the layers of a shell. Pre: isAsked()
  double askedIn(const SpeciesProfile& one, int shell) const;
  /// The same of all species that have a profile.
  double askedIn(int shell) const;
};

}  // namespace packmesh::hemocell
