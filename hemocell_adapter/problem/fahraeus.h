// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The Fåhraeus effect: blood in a narrow tube has a lower hematocrit than the blood that leaves it.
///
/// Pries, Secomb, Gaehtgens, Gross: Blood flow in microvascular networks. Experiments and simulation.
/// Circulation Research 67, 826-834 (1990): a fit to measurements of human blood in glass tubes,
/// H_T / H_D = H_D + (1 - H_D) (1 + 1.7 exp(-0.415 D) - 0.6 exp(-0.011 D)) with the diameter D in µm.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "hemocell_adapter/problem/lumen.h"

namespace packmesh::hemocell {

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

}  // namespace packmesh::hemocell
