// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How cells are distributed over the distance from the wall, and the Fåhraeus effect: blood in a
/// narrow tube has a lower hematocrit than the blood that leaves it.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/lumen.h"
#include "packMesh/container/side_wall.h"

namespace packmesh::hemocell {

// Pries, Secomb, Gaehtgens, Gross: Blood flow in microvascular networks. Experiments and simulation.
// Circulation Research 67, 826-834 (1990): a fit to measurements of human blood in glass tubes,
// H_T / H_D = H_D + (1 - H_D) (1 + 1.7 exp(-0.415 D) - 0.6 exp(-0.011 D)) with the diameter D in µm.

/// Diameters to which the fit is applied without a warning [µm]: in narrower tubes red cells pass in single
/// file, in wider ones the effect is below 0.3 %.
inline constexpr double narrowestFahraeus = 5.0, widestFahraeus = 500.0;

/// Hematocrit in a tube that blood of this hematocrit flows out of. @param diameter [µm]
double tubeHematocrit(double dischargeHematocrit, double diameter);
/// The inverse. Pre: tubeHematocrit > 0
double dischargeHematocrit(double tubeHematocrit, double diameter);

/// Thickness of a cell-free layer that explains the Fåhraeus effect [µm]: red cells are evenly distributed
/// over the core, and the velocity is that of Poiseuille flow, so that H_D / H_T = 2 - (1 - thickness / R)²
/// (Sutera, Seshadri, Croce, Hochmuth: Microvascular Research 2, 420-433, 1970). In tubes wider than 75 µm,
/// where this would decrease again, that of 75 µm.
double freeLayerOf(double tubeHematocrit, double diameter);

/// Of a cylinder its diameter, of another lumen four times its volume over the area of its side wall [µm].
/// @param ends axes along which the lumen ends other than at a wall
/// @return nothing if there is no side wall
std::optional<double> hydraulicDiameter(const Container& lumen, const std::array<bool, 3>& ends);

/// "outside of the range ...", if it is.
std::optional<std::string> fahraeusWarning(double diameter);

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
