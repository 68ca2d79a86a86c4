// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The settings, grouped by topic.
#pragma once

#include <vector>

#include "hemocell_adapter/settings/setting.h"

namespace packmesh::hemocell {

std::vector<Setting> cellSettings();
std::vector<Setting> lumenSettings();
std::vector<Setting> methodSettings();
/// Of Method::cat, and the choice of the method.
std::vector<Setting> catSettings();
/// Of Method::cat, among those of the output.
Setting framesSetting();
std::vector<Setting> limitSettings();
std::vector<Setting> outputSettings();
/// Options of packCells that packMesh accepts and ignores.
std::vector<Setting> ignoredSettings();

}  // namespace packmesh::hemocell
