// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The one declaration of every option and every tag of `<packing>`: it drives parsing, range checks,
/// error messages, `--help` and the reference.
#pragma once

#include <vector>

#include "hemocell_adapter/settings/setting.h"

namespace packmesh::hemocell {

/// All settings, in the order of the help text.
const std::vector<Setting>& settingsTable();

}  // namespace packmesh::hemocell
