// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/settings.h"

#include <algorithm>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {

void requireRoomForSpecies(const Settings& settings) {
  if (settings.species.size() >= mostSpecies)
    throw InputError("more than " + std::to_string(mostSpecies) + " species");
}

SpeciesRequest& speciesNamed(Settings& settings, const std::string& name) {
  for (SpeciesRequest& species : settings.species) {
    if (species.name == name) return species;
  }
  requireRoomForSpecies(settings);
  settings.species.emplace_back().name = name;
  return settings.species.back();
}

const SpeciesRequest* findSpecies(const Settings& settings, const std::string& name) {
  const auto found = std::find_if(settings.species.begin(), settings.species.end(),
                                  [&](const SpeciesRequest& s) { return s.name == name; });
  return found == settings.species.end() ? nullptr : &*found;
}

}  // namespace packmesh::hemocell
