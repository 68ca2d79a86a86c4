// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/filed_species.h"

#include <algorithm>

#include "packMesh/io/hdf5_writer.h"
#include "packMesh/packing/stored_membranes.h"

namespace packmesh {

FiledSpecies::FiledSpecies(const Physics& physics) : physics_(physics), firstId_{0} {
  const std::vector<Species>& all = physics.species;
  for (std::size_t s = 0; s < all.size(); ++s) {
    const Shape* const undeformed = all[s].shape->undeformed().get();
    const bool continues = s > 0 && undeformed && undeformed == all[s - 1].shape->undeformed().get() &&
                           all[s].name == all[s - 1].name;
    if (!continues) groups_.push_back({int(s), 0, 0, undeformed ? undeformed : all[s].shape.get()});
    ++groups_.back().species;
    groups_.back().count += all[s].count;
    groupOf_.push_back(std::int32_t(groups_.size()) - 1);
    firstId_.push_back(firstId_.back() + all[s].count);
  }
}

std::optional<int> FiledSpecies::speciesOf(std::int64_t group, std::int64_t id) const {
  if (group < 0 || group >= std::int64_t(groups_.size())) return {};
  const Group& of = groups_[group];
  if (of.species == 1) return of.first;
  const auto after = std::upper_bound(firstId_.begin(), firstId_.end(), id);
  const auto species = int(after - firstId_.begin()) - 1;
  if (species < of.first || species >= of.first + of.species) return {};
  return species;
}

void FiledSpecies::write(Hdf5Writer& out) const {
  out.group("/species");
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const std::string path = pathOfSpecies(g);
    out.group(path);
    out.attribute(path, "name", physics_.species[groups_[g].first].name);
    out.attribute(path, "count", groups_[g].count);
    writeMesh(out, path, groups_[g].shape->mesh());
  }
}

void FiledSpecies::writeMembranes(Hdf5Writer& out, const PackingState& state,
                                  const Communicator& ranks) const {
  std::vector<std::int32_t> species;
  for (const BodyState& cell : state.cells) species.push_back(of(cell.species));
  const auto verticesOf = [&](std::size_t i) -> const std::vector<Vec3>* {
    if (!state.vertices.empty()) return state.vertices[i].empty() ? nullptr : &state.vertices[i];
    if (species[i] < 0) return nullptr;
    const Shape& shape = physics_.shapeOf(state.cells[i].species);
    return shape.undeformed() ? &shape.mesh().vertices : nullptr;
  };
  packmesh::writeMembranes(out, groups_.size(), species, verticesOf, ranks);
}

}  // namespace packmesh
