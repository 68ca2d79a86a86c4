// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/request.h"

#include <algorithm>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {

const Origin* Request::originOf(const std::string& key) const {
  for (auto found = origins.lower_bound(key); found != origins.end(); ++found) {
    if (found->first.compare(0, key.size(), key) != 0) return nullptr;
    if (found->first.size() == key.size() || found->first[key.size()] == '.') return &found->second;
  }
  return nullptr;
}

std::string keyOfSpecies(const std::string& name, const std::string& attribute) {
  return "species." + name + "." + attribute;
}

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
