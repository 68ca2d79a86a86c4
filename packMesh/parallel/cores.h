// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cores that this process may use.
#pragma once

namespace packmesh {

/// Number of cores that this process may use: those it is bound to (taskset, Slurm, mpirun), or fewer if its
/// control group has a quota (containers). At least 1.
int availableCores();

}  // namespace packmesh
