// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The exchange of particles as HemoCell 2.7 does it after the first iteration, written from
/// docs/explanation/proposals.md (9), with the error described there and without it.
#pragma once

#include "hemocell.h"

namespace hemo {

enum class Exchange { shiftsBuffer, copies };

namespace exchange {

typedef HemoCellParticle::serializeValues_t Values;
typedef std::array<int, 3> Image;

inline void shift(HemoCellFields& fields, const Image& image, Values& values) {
  const plb::Box3D box = fields.hemocell.lattice->getBoundingBox();
  const plb::plint n[3] = {box.x1 - box.x0 + 1, box.y1 - box.y0 + 1, box.z1 - box.z0 + 1};
  const plb::plint steps[3] = {1, fields.periodicity_limit_offset_y, fields.periodicity_limit_offset_z};
  for (int a = 0; a < 3; ++a) {
    values.position[a] += image[a] * n[a];
    values.cellId += image[a] * steps[a] * fields.number_of_cells;
  }
}

/// Whether the nodes `from`, moved by an image, meet the envelope around the nodes `to`.
inline bool reaches(HemoCellFields& fields, const plb::Box3D& from, const Image& image,
                    const plb::Box3D& to) {
  const plb::Box3D box = fields.hemocell.lattice->getBoundingBox();
  const plb::plint n[3] = {box.x1 - box.x0 + 1, box.y1 - box.y0 + 1, box.z1 - box.z0 + 1};
  const plb::plint lo[3] = {from.x0, from.y0, from.z0}, hi[3] = {from.x1, from.y1, from.z1};
  const plb::plint first[3] = {to.x0, to.y0, to.z0}, last[3] = {to.x1, to.y1, to.z1};
  const plb::plint envelope = static_cast<plb::plint>(fields.envelopeSize);
  for (int a = 0; a < 3; ++a)
    if (lo[a] + image[a] * n[a] > last[a] + envelope || hi[a] + image[a] * n[a] < first[a] - envelope)
      return false;
  return true;
}

/// Images that a periodic system has: the one in place first.
inline std::vector<Image> images(HemoCellFields& fields) {
  std::vector<Image> all = {{{0, 0, 0}}};
  for (int i = 0; i < 27; ++i) {
    const Image image = {{1 - i / 9, 1 - i / 3 % 3, 1 - i % 3}};
    bool possible = i != 13;
    for (int a = 0; a < 3; ++a)
      possible = possible && (image[a] == 0 || fields.immersedParticles->periodicity().get(a));
    if (possible) all.push_back(image);
  }
  return all;
}

}  // namespace exchange

/// One buffer from each rank, given to every pair of blocks and every image; then copies within this rank, of
/// all that its blocks have received. Incomplete cells are deleted.
inline void exchangeParticles(HemoCellFields& fields, Exchange how) {
  using namespace exchange;
  const plb::Blocks& blocks = fields.hemocell.lattice->getMultiBlockManagement().blocks;
  MultiParticleField& field = *fields.immersedParticles;
  int me = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &me);
  std::vector<std::vector<Values>> buffers = particlesOfRanks(field);
  for (const plb::plint id : field.getLocalInfo().getBlocks()) {
    HemoCellParticleField& block = field.getComponent(id);
    block.removeIf(
        [&](HemoCellParticle const& p) { return !block.isContainedABS(p.sv.position, block.localDomain); });
  }
  for (int local = 0; local < 2; ++local)
    for (const Image& image : images(fields))
      for (const plb::plint to : field.getLocalInfo().getBlocks())
        for (std::size_t from = 0; from < blocks.bulk.size(); ++from) {
          if ((blocks.rank[from] == me) != (local == 1)) continue;
          if (!reaches(fields, blocks.bulk[from], image, blocks.bulk[to])) continue;
          std::vector<Values> own;
          if (local == 1)
            for (HemoCellParticle const& p : field.getComponent(static_cast<plb::plint>(from)).particles)
              own.push_back(p.sv);
          for (Values& received : local == 1 ? own : buffers[blocks.rank[from]]) {
            Values copied = received;
            Values& shifted = how == Exchange::copies ? copied : received;
            shift(fields, image, shifted);
            field.getComponent(to).addParticle(shifted);
          }
        }
  fields.deleteIncompleteCells(false);
}

}  // namespace hemo
