// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The `.pos` files that HemoCell counts cells by. Part of packMesh/hemocell.h. C++11.
#pragma once

#include <string>
#include <vector>

#include <hemocell.h>

namespace packmesh {
namespace plugin {

inline std::vector<std::string> typeNames(hemo::HemoCell& hemocell) {
  std::vector<std::string> names;
  for (unsigned int t = 0; t < hemocell.cellfields->size(); ++t)
    names.push_back((*hemocell.cellfields)[t]->name);
  return names;
}

/// Types under names that lead HemoCell to `.pos` files of a folder, until the end of this object's life.
class NamesInFolder {
 public:
  NamesInFolder(hemo::HemoCell& hemocell, const std::string& folder)
      : hemocell_(hemocell), names_(typeNames(hemocell)) {
    for (unsigned int t = 0; t < names_.size(); ++t) (*hemocell_.cellfields)[t]->name = folder + names_[t];
  }
  ~NamesInFolder() {
    for (unsigned int t = 0; t < names_.size(); ++t) (*hemocell_.cellfields)[t]->name = names_[t];
  }
  NamesInFolder(const NamesInFolder&) = delete;
  NamesInFolder& operator=(const NamesInFolder&) = delete;

 private:
  hemo::HemoCell& hemocell_;
  std::vector<std::string> names_;
};

}  // namespace plugin
}  // namespace packmesh
