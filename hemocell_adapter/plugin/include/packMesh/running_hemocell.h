// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Reads a running HemoCell. Part of packMesh/hemocell.h. C++11.
#pragma once

#include <mpi.h>

#include <string>

#include <hemocell.h>
#include "packMesh/hemocell_system.h"
#include "packMesh/line_printer.h"

namespace packmesh {
namespace plugin {

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

}  // namespace plugin
}  // namespace packmesh
