// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/settings_table.h"

#include "hemocell_adapter/settings/setting_groups.h"

namespace packmesh::hemocell {

const std::vector<Setting>& settingsTable() {
  static const std::vector<Setting> table = [] {
    const std::pair<Topic, std::vector<Setting>> groups[] = {
        {Topic::cells, cellSettings()},     {Topic::lumen, lumenSettings()},
        {Topic::packing, catSettings()},    {Topic::packing, methodSettings()},
        {Topic::limits, limitSettings()},   {Topic::output, outputSettings()},
        {Topic::ignored, ignoredSettings()}};
    std::vector<Setting> all;
    for (const auto& [topic, settings] : groups)
      for (Setting setting : settings) {
        setting.topic = topic;
        all.push_back(std::move(setting));
      }
    return all;
  }();
  return table;
}

}  // namespace packmesh::hemocell
