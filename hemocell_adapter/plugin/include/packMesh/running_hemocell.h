// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Reads a running HemoCell, and adds cells to it. Part of packMesh/hemocell.h. C++11.
#pragma once

#include <hemocell.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "packMesh/hemocell_system.h"

namespace packmesh {
namespace plugin {

/// Prints XML with each tag in the line that it has in the file.
class LinePrinter : public tinyxml2::XMLPrinter {
 public:
  LinePrinter() : tinyxml2::XMLPrinter(nullptr, true) {}
  bool VisitEnter(const tinyxml2::XMLElement& element, const tinyxml2::XMLAttribute* attribute) override {
    const std::string text = CStr();
    const auto lines = 1 + std::count(text.begin(), text.end(), '\n');
    if (lines < element.GetLineNum())
      PushText(std::string(static_cast<std::size_t>(element.GetLineNum() - lines), '\n').c_str());
    return tinyxml2::XMLPrinter::VisitEnter(element, attribute);
  }
  using tinyxml2::XMLPrinter::VisitEnter;
};

/// Whether this rank has cells: with a pre-inlet, only its ranks do.
inline bool hasCells(hemo::HemoCell& hemocell) {
  return !(hemocell.preInlet && hemocell.preInlet->initialized) || hemocell.partOfpreInlet;
}

inline std::array<std::int64_t, 3> low(const plb::Box3D& box) {
  return {{box.x0, box.y0, box.z0}};
}
inline std::array<std::int64_t, 3> high(const plb::Box3D& box) {
  return {{box.x1, box.y1, box.z1}};
}

inline std::string configText(hemo::HemoCell& hemocell) {
  LinePrinter printer;
  (*hemocell.cfg)["domain"].getOrig()->GetDocument()->Print(&printer);
  return printer.CStr();
}

inline CellType typeOf(hemo::HemoCellField& field) {
  CellType type;
  type.name = field.name;
  type.minimumDistanceFromSolid = static_cast<int>(field.minimumDistanceFromSolid);
  type.volume = field.volume;
  auto& mesh = field.getMesh();
  for (plb::plint i = 0; i < mesh.getNumVertices(); ++i) {
    const auto v = mesh.getVertex(i);
    type.vertices.push_back({{v[0], v[1], v[2]}});
  }
  for (const auto& t : field.triangle_list)
    type.triangles.push_back({{static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2])}});
  return type;
}

/// The flags of a block, without its envelope.
inline Block blockOf(hemo::HemoCell& hemocell, plb::plint id) {
  const plb::Box3D bulk = hemocell.lattice->getMultiBlockManagement().getBulk(id);
  auto& fluid = hemocell.lattice->getComponent(id);
  const plb::Dot3D at = fluid.getLocation();
  Block block;
  block.first = low(bulk);
  block.last = high(bulk);
  for (plb::plint x = bulk.x0; x <= bulk.x1; ++x)
    for (plb::plint y = bulk.y0; y <= bulk.y1; ++y)
      for (plb::plint z = bulk.z0; z <= bulk.z1; ++z)
        block.fluid.push_back(!fluid.get(x - at.x, y - at.y, z - at.z).getDynamics().isBoundary());
  return block;
}

inline System systemOf(hemo::HemoCell& hemocell, const MPI_Comm& ranks) {
  System system;
  system.ranks = &ranks;
  system.dx = hemo::param::dx * 1e6;
  const plb::Box3D all = hemocell.lattice->getBoundingBox();
  system.first = low(all);
  system.last = high(all);
  auto& particles = *hemocell.cellfields->immersedParticles;
  for (int axis = 0; axis < 3; ++axis) system.periodic[axis] = particles.periodicity().get(axis);
  system.isPreInlet = hemocell.preInlet && hemocell.preInlet->initialized;
  system.particleEnvelope = static_cast<int>(hemocell.cellfields->envelopeSize);
  system.config = configText(hemocell);
  for (unsigned int t = 0; t < hemocell.cellfields->size(); ++t)
    system.types.push_back(typeOf(*(*hemocell.cellfields)[t]));
  for (const plb::plint id : hemocell.lattice->getLocalInfo().getBlocks())
    system.blocks.push_back(blockOf(hemocell, id));
  return system;
}

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
