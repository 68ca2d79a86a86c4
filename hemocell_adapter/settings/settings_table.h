// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The single declaration of all options and tags of `<packing>`: parsing, range checks, error
/// messages, `--help` and the reference are derived from it.
#pragma once

#include <vector>

#include "hemocell_adapter/settings/setting.h"

namespace packmesh::hemocell {

/// All settings, in the order of the help.
const std::vector<Setting>& settingsTable();

}  // namespace packmesh::hemocell
