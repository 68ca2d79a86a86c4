// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A part of the table of settings. Internal to settings_table.
#pragma once

#include <vector>

#include "hemocell_adapter/settings/setting.h"

namespace packmesh::hemocell {

/// How to pack, when to give up, where to write: the rows of Topic::packing, limits, output and ignored.
std::vector<Setting> packingSettings();

}  // namespace packmesh::hemocell
