// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Blood that flows already: the cells of a piece of it, repeated over the lumen.
#pragma once

#include <cstdint>
#include <vector>

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// A scene with the cells of Request::blood among those that its species start from. The piece is repeated
/// along all its axes, by its periods or, where it has none, by the size of its box; it begins at the low end
/// of the lumen along periodic axes, is centred along the others, and is turned so that its axis is that of
/// the lumen, if that has one. Where both are periodic, distances between cells are changed by up to a tenth
/// if a whole number of pieces fits then. Cells that are not in the lumen, or that HemoCell would delete, are
/// left out; those that meet cells before them start further ones. The same on every number of ranks. Does
/// not communicate.
/// @throws InputError if the state does not fit the species
Scene withBlood(Scene scene, Notices& notices);

/// Further cells of flowing blood: each is like a random one of the cells that are there, with its number and
/// its shape, at a random place as far from the wall, turned as the wall is (in a pipe about its axis), so
/// that the layers of the blood stay what they are. None where there is no wall. Every rank computes all of
/// them. @param stream of the random numbers
std::vector<Cell> addLike(const std::vector<Cell>& there, std::int64_t count, const Scene& scene,
                          std::uint32_t stream);

}  // namespace packmesh::hemocell
