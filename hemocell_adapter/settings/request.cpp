// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/request.h"

#include <algorithm>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {

SpeciesRequest& speciesNamed(Request& request, const std::string& name) {
  for (SpeciesRequest& species : request.species) {
    if (species.name == name) return species;
  }
  if (request.species.size() >= mostSpecies)
    throw InputError("more than " + std::to_string(mostSpecies) + " species");
  request.species.emplace_back().name = name;
  return request.species.back();
}

const SpeciesRequest* findSpecies(const Request& request, const std::string& name) {
  const auto found = std::find_if(request.species.begin(), request.species.end(),
                                  [&](const SpeciesRequest& s) { return s.name == name; });
  return found == request.species.end() ? nullptr : &*found;
}

}  // namespace packmesh::hemocell
