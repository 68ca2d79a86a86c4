// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Adds cells to a running HemoCell. Part of packMesh/hemocell.h. C++11.
#pragma once

#include <algorithm>
#include <cmath>

#include <hemocell.h>
#include "packMesh/hemocell_system.h"
#include "packMesh/running_hemocell.h"

namespace packmesh {
namespace plugin {

/// A position in HemoCell: three numbers.
typedef decltype(hemo::HemoCellParticle::serializeValues_t::position) Point;

/// Where HemoCell keeps the vertices of one type of cell, relative to the cell: the template, centred.
inline std::vector<Point> centredTemplate(const CellType& type) {
  std::array<double, 3> lo = type.vertices.front(), hi = lo;
  for (const auto& v : type.vertices)
    for (int a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], v[a]);
      hi[a] = std::max(hi[a], v[a]);
    }
  std::vector<Point> centred;
  for (const auto& v : type.vertices) {
    Point p;
    for (int a = 0; a < 3; ++a) p[a] = v[a] - 0.5 * (lo[a] + hi[a]);
    centred.push_back(p);
  }
  return centred;
}

/// Adds vertices to the blocks of this rank in which they lie. A vertex beyond a periodic face is added at
/// the opposite one, with the number that HemoCell gives to the part of a cell that has crossed that face.
class ParticleAdder {
 public:
  explicit ParticleAdder(hemo::HemoCell& hemocell)
      : fields_(*hemocell.cellfields),
        first_(low(hemocell.lattice->getBoundingBox())),
        last_(high(hemocell.lattice->getBoundingBox())) {
    for (const plb::plint id : fields_.immersedParticles->getLocalInfo().getBlocks())
      blocks_.push_back(&fields_.immersedParticles->getComponent(id));
    for (unsigned int t = 0; t < fields_.size(); ++t)
      templates_.push_back(centredTemplate(typeOf(*fields_[t])));
  }

  void operator()(const Cell& cell) {
    const std::vector<Point>& shape = templates_[cell.type];
    const bool deformed = !cell.vertices.empty();
    for (std::size_t i = 0; i < shape.size(); ++i) {
      Point p;
      for (int row = 0; row < 3; ++row)
        p[row] = deformed ? cell.vertices[i][row]
                          : cell.linear[3 * row] * shape[i][0] + cell.linear[3 * row + 1] * shape[i][1] +
                                cell.linear[3 * row + 2] * shape[i][2] + cell.translation[row];
      const plb::plint id = cell.id + wrap(p);
      for (hemo::HemoCellParticleField* block : blocks_) {
        if (!block->isContainedABS(p, block->localDomain)) continue;
        block->addParticle(hemo::HemoCellParticle(p, id, i, cell.type).sv);
        break;
      }
    }
  }

 private:
  /// Moves p into the lattice along periodic axes. @return what HemoCell adds to the number of the cell
  plb::plint wrap(Point& p) const {
    const plb::plint steps[3] = {1, fields_.periodicity_limit_offset_y, fields_.periodicity_limit_offset_z};
    plb::plint offset = 0;
    for (int a = 0; a < 3; ++a) {
      if (!fields_.immersedParticles->periodicity().get(a)) continue;
      const double period = static_cast<double>(last_[a] - first_[a] + 1);
      // Vertices at -0.5 < p - first <= period - 0.5 are in the lattice.
      const double images = std::ceil((p[a] - first_[a] + 0.5) / period) - 1.0;
      p[a] -= images * period;
      offset -= steps[a] * static_cast<plb::plint>(images);
    }
    return offset * fields_.number_of_cells;
  }

  hemo::HemoCellFields& fields_;
  std::array<std::int64_t, 3> first_, last_;
  std::vector<hemo::HemoCellParticleField*> blocks_;
  std::vector<std::vector<Point>> templates_;
};

}  // namespace plugin
}  // namespace packmesh
