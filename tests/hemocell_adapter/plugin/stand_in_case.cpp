// SPDX-License-Identifier: AGPL-3.0-or-later
// A case of the stand-in: stand_in_case <lumen> <blocks x> <y> <z> <what> [file]
//   lumen  box: 48 x 40 x 40 nodes without walls, periodic along all axes; planes: the same with walls at
//   both ends of z;
//          pipe: a pipe along x in 60 x 44 x 44 nodes, periodic; capillary: a narrow one; channel: an oblique
//          step in it; inlet: a pre-inlet at x >= 20, of the ranks but the last
//   what   words for the program (--hematocrit 0.3 --seed 2 ...); or load FILE [leave-out], save FILE, short
//   (an envelope
//          of 4 nodes); stretch N (at the end: cells become longer along x by 1 % in each of N iterations)
//          [stop]; deform (as 2 of these iterations do), cross (the first cell gets a mesh that intersects
//          itself); before all others, in this order: config FILE; catch (failures are thrown); shifts or
//          copies (HemoCell's exchange of particles, with its error or without); then, or before the
//          program's: restart (own or plugin); checkpoint; lose or double (a vertex, in the
//          first iteration)
// Prints the cells that arrived, and writes every vertex to particles.txt: type, number of its cell, vertex,
// position.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <set>

#include "exchange.h"
#include "hemocell.h"
#include "packMesh/hemocell.h"

namespace {

int rank = 0, ranks = 1;

plb::Mesh meshOf(const std::string& file, hemo::HemoCellField& field) {
  std::ifstream in(file);
  std::string off;
  long vertices = 0, triangles = 0, three = 0;
  in >> off >> vertices >> triangles >> three;
  plb::Mesh mesh;
  for (long i = 0; i < vertices; ++i) {
    std::array<double, 3> v;
    in >> v[0] >> v[1] >> v[2];
    for (double& x : v) x = x / (1e6 * hemo::param::dx) + 7.0;  // [nodes]; around any point
    mesh.vertices.push_back(v);
  }
  for (long i = 0; i < triangles; ++i) {
    hemo::Array<plb::plint, 3> t;
    in >> three >> t[0] >> t[1] >> t[2];
    field.triangle_list.push_back(t);
  }
  return mesh;
}

struct Lumen {
  plb::Box3D box;
  bool periodic[3];
  std::function<bool(plb::plint, plb::plint, plb::plint)> solid;
};

Lumen lumenOf(const std::string& name) {
  const double finer = 5e-7 / hemo::param::dx;  // the pipe has the same size at any spacing
  const double radius = name == "capillary" ? 5.0 : 20.0;
  const auto inPipe = [=](double y, double z) {
    const double dy = y / finer - 21.5, dz = z / finer - 21.5;
    return dy * dy + dz * dz <= radius * radius;
  };
  if (name == "box")
    return {{0, 47, 0, 39, 0, 39}, {true, true, true}, [](long, long, long) { return false; }};
  if (name == "planes")
    return {{0, 47, 0, 39, 0, 39}, {true, true, false}, [](long, long, long z) { return z <= 0 || z >= 39; }};
  if (name == "inlet")
    return {{20, 69, 3, 46, 0, 43}, {true, false, false}, [=](long, long y, long z) {
              return !inPipe(y - 3, z);
            }};
  const bool step = name == "channel";
  const plb::plint n[2] = {std::lround(60 * finer) - 1, std::lround(44 * finer) - 1};
  return {{0, n[0], 0, n[1], 0, n[1]}, {true, false, false}, [=](long x, long y, long z) {
            return !inPipe(y, z) || (step && x > 20 && x < 40 && y + 0.3 * x < 22);
          }};
}

/// Sets up blocks; with a pre-inlet, the last rank has none of them.
void build(hemo::HemoCell& hemocell, const Lumen& lumen, const int counts[3], bool inlet, int envelope) {
  hemocell.lattice = new plb::MultiBlockLattice;
  hemocell.lattice->box = lumen.box;
  hemocell.cellfields = new hemo::HemoCellFields(hemocell);
  hemocell.cellfields->envelopeSize = envelope;
  hemo::MultiParticleField* particles = new hemo::MultiParticleField;
  hemocell.cellfields->immersedParticles = particles;
  std::copy(lumen.periodic, lumen.periodic + 3, particles->periodic.axes);
  const int having = inlet && ranks > 1 ? ranks - 1 : ranks;
  hemocell.partOfpreInlet = inlet && rank < having;
  if (inlet) {
    hemocell.preInlet = new hemo::PreInlet;
    hemocell.preInlet->initialized = true;
  }
  const auto part = [](plb::plint lo, plb::plint hi, int i, int n) { return lo + (hi - lo + 1) * i / n; };
  plb::Blocks& blocks = hemocell.lattice->management.blocks;
  for (int i = 0; i < counts[0]; ++i)
    for (int j = 0; j < counts[1]; ++j)
      for (int k = 0; k < counts[2]; ++k) {
        const plb::plint id = static_cast<plb::plint>(blocks.bulk.size());
        const plb::Box3D& b = lumen.box;
        blocks.bulk.push_back({part(b.x0, b.x1, i, counts[0]), part(b.x0, b.x1, i + 1, counts[0]) - 1,
                               part(b.y0, b.y1, j, counts[1]), part(b.y0, b.y1, j + 1, counts[1]) - 1,
                               part(b.z0, b.z1, k, counts[2]), part(b.z0, b.z1, k + 1, counts[2]) - 1});
        blocks.rank.push_back(static_cast<int>(id) * having / (counts[0] * counts[1] * counts[2]));
        if (blocks.rank.back() != rank) continue;
        const plb::Box3D bulk = blocks.bulk.back();
        hemocell.lattice->local.blocks.push_back(id);
        particles->local.blocks.push_back(id);
        plb::BlockLattice& fluid = hemocell.lattice->components[id];
        fluid.location = {bulk.x0 - 1, bulk.y0 - 1, bulk.z0 - 1};
        fluid.solid = lumen.solid;
        hemo::HemoCellParticleField& field = particles->components[id];
        field.fields = hemocell.cellfields;
        field.location = {bulk.x0 - envelope, bulk.y0 - envelope, bulk.z0 - envelope};
        const plb::plint n[3] = {bulk.x1 - bulk.x0, bulk.y1 - bulk.y0, bulk.z1 - bulk.z0};
        field.localDomain = {envelope, envelope + n[0], envelope, envelope + n[1], envelope, envelope + n[2]};
        field.boundingBox = {0, n[0] + 2 * envelope, 0, n[1] + 2 * envelope, 0, n[2] + 2 * envelope};
      }
}

/// What a flow does to cells: each becomes 1 % longer along x.
void stretch(hemo::HemoCell& hemocell) {
  hemo::HemoCellFields& fields = *hemocell.cellfields;
  fields.syncEnvelopes();
  for (const plb::plint id : fields.immersedParticles->getLocalInfo().getBlocks()) {
    hemo::HemoCellParticleField& block = fields.immersedParticles->getComponent(id);
    for (const auto& numbered : block.get_particles_per_cell()) {
      const std::vector<int>& at = numbered.second;
      if (std::count(at.begin(), at.end(), -1) > 0) continue;
      double middle = 0.0;
      for (const int i : at) middle += block.particles[i].sv.position[0] / double(at.size());
      for (const int i : at) {
        double& x = block.particles[i].sv.position[0];
        x = middle + 1.01 * (x - middle);
      }
    }
  }
  ++hemocell.iter;
}

/// A time loop in which the cells are watched.
void watched(hemo::HemoCell& hemocell, int iterations, bool stops) {
  packmesh::WatchOptions options;
  options.every = 1;
  options.stop = stops;
  for (int i = 0; i < iterations; ++i) {
    stretch(hemocell);
    const packmesh::WatchedCells cells = packmesh::watchCells(hemocell, options);
    if (rank == 0)
      std::printf("(stand-in) %u: %ld cells, %.6f µm, %ld too long\n", hemocell.iter, long(cells.cells),
                  cells.longest, long(cells.tooLong));
    double sums[2] = {double(cells.tooLong), cells.longest}, expected[2] = {ranks * sums[0], ranks * sums[1]};
    MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    if (sums[0] != expected[0] || std::abs(sums[1] - expected[1]) > 1e-9)
      std::puts("(stand-in) ranks differ");
    hemocell.cellfields->syncEnvelopes();
    hemocell.cellfields->deleteIncompleteCells(false);
  }
}

/// The first vertex of the first cell passes through the opposite part of its membrane.
void cross(hemo::HemoCell& hemocell) {
  hemo::HemoCellFields& fields = *hemocell.cellfields;
  for (const plb::plint id : fields.immersedParticles->getLocalInfo().getBlocks()) {
    hemo::HemoCellParticleField& block = fields.immersedParticles->getComponent(id);
    for (const auto& numbered : block.get_particles_per_cell()) {
      const std::vector<int>& at = numbered.second;
      if (std::count(at.begin(), at.end(), -1) > 0 || fields.base_cell_id(numbered.first) != 0) continue;
      for (int k = 0; k < 3; ++k) {
        double middle = 0.0;
        for (const int i : at) middle += block.particles[i].sv.position[k] / double(at.size());
        double& x = block.particles[at[0]].sv.position[k];
        x = middle - 1.05 * (x - middle);
      }
    }
  }
}

/// Every vertex that is in a block, in the order of cells, whatever the blocks.
void writeParticles(hemo::HemoCell& hemocell) {
  std::string mine;
  for (const plb::plint id : hemocell.cellfields->immersedParticles->getLocalInfo().getBlocks()) {
    hemo::HemoCellParticleField& block = hemocell.cellfields->immersedParticles->getComponent(id);
    for (const hemo::HemoCellParticle& p : block.particles) {
      if (!block.isContainedABS(p.sv.position, block.localDomain)) continue;
      char line[200];
      std::snprintf(line, sizeof line, "%d %8ld %5d %.12g %.12g %.12g\n", p.sv.celltype, p.sv.cellId,
                    p.sv.vertexId, p.sv.position[0], p.sv.position[1], p.sv.position[2]);
      mine += line;
    }
  }
  std::ofstream("particles." + std::to_string(rank)) << mine;
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank != 0) return;
  std::set<std::string> lines;
  for (int r = 0; r < ranks; ++r) {
    std::ifstream in("particles." + std::to_string(r));
    for (std::string line; std::getline(in, line);) lines.insert(line);
    std::remove(("particles." + std::to_string(r)).c_str());
  }
  std::ofstream out("particles.txt");
  for (const std::string& line : lines) out << line << '\n';
}

bool taken(std::vector<std::string>& words, const std::string& word) {
  if (words.empty() || words[0] != word) return false;
  words.erase(words.begin());
  return true;
}

std::string takenNext(std::vector<std::string>& words) {
  const std::string next = words.at(0);
  words.erase(words.begin());
  return next;
}

packmesh::LoadedParticles load(hemo::HemoCell& hemocell, std::vector<std::string>& words) {
  if (taken(words, "restart")) {
    if (takenNext(words) == "plugin") return packmesh::loadCheckPoint(hemocell);
    hemocell.loadCheckPoint();
    return {};
  }
  if (taken(words, "load")) {
    const std::string file = takenNext(words);
    return packmesh::loadParticles(
        hemocell, file, taken(words, "leave-out") ? packmesh::Unkept::leaveOut : packmesh::Unkept::refuse);
  }
  packmesh::PackingOptions options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "save" || words[i] == "fit") break;
    if (words[i] == "nodes") {
      options.mostNodesOnEveryRank = std::atol(words[++i].c_str());
    } else if (words[i] == "member") {
      options.hematocrit = std::atof(words[i + 2].c_str());
      i += 2;
    } else if (words[i] == "--count") {
      options.counts[words[i + 1]] = std::atol(words[i + 2].c_str());
      i += 2;
    } else {
      options.more.push_back(words[i]);
    }
  }
  return packmesh::loadParticles(hemocell, options);
}

void run(hemo::HemoCell& hemocell, std::vector<std::string> words) {
  const bool stops = !words.empty() && words.back() == "stop";
  if (stops) words.pop_back();
  int iterations = 0;
  if (words.size() > 1 && words[words.size() - 2] == "stretch") {
    iterations = std::atoi(words.back().c_str());
    words.resize(words.size() - 2);
  }
  const bool shifts = taken(words, "shifts"), copies = taken(words, "copies");
  const bool checkpoint = taken(words, "checkpoint"), lose = taken(words, "lose"),
             doubles = taken(words, "double");
  const bool deforms = taken(words, "deform"), crosses = taken(words, "cross");
  const packmesh::LoadedParticles loaded = load(hemocell, words);
  for (int i = 0; deforms && i < 2; ++i) stretch(hemocell);
  if (crosses) cross(hemocell);
  if (deforms) hemocell.cellfields->syncEnvelopes();
  const std::string last = words.size() > 1 ? words[words.size() - 2] : "";
  if (last == "save" || last == "fit") packmesh::savePositions(hemocell, words.back(), last == "fit");
  hemocell.iterate();
  if (shifts) hemo::exchangeParticles(*hemocell.cellfields, hemo::Exchange::shiftsBuffer);
  if (copies) hemo::exchangeParticles(*hemocell.cellfields, hemo::Exchange::copies);
  if (lose)
    for (const plb::plint id : hemocell.cellfields->immersedParticles->getLocalInfo().getBlocks())
      hemocell.cellfields->immersedParticles->getComponent(id).removeIf(
          [](hemo::HemoCellParticle const& p) { return p.sv.cellId == 0 && p.sv.vertexId == 0; });
  for (const plb::plint id : hemocell.cellfields->immersedParticles->getLocalInfo().getBlocks()) {
    hemo::HemoCellParticleField& block = hemocell.cellfields->immersedParticles->getComponent(id);
    for (std::size_t i = 0, end = doubles ? block.particles.size() : 0; i < end; ++i)
      if (block.particles[i].sv.cellId == 0 && block.particles[i].sv.vertexId == 0)
        block.particles.push_back(hemo::HemoCellParticle(block.particles[i]));
  }
  if (!loaded.counts.empty()) packmesh::verifyParticles(hemocell, loaded);
  if (checkpoint) hemocell.saveCheckPoint();
  watched(hemocell, iterations, stops);
  if (rank == 0) {
    std::cout << "(stand-in)";
    for (const std::int64_t count : loaded.counts) std::cout << ' ' << count;
    std::cout << std::endl;
  }
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const std::string name = argv[1];
  const int counts[3] = {std::atoi(argv[2]), std::atoi(argv[3]), std::atoi(argv[4])};
  std::vector<std::string> words(argv + 5, argv + argc);
  hemo::HemoCell hemocell;
  hemocell.cfg = new hemo::Config(taken(words, "config") ? takenNext(words) : "config.xml");
  hemo::param::dx = std::atof((*hemocell.cfg)["domain"].getOrig()->FirstChildElement("dx")->GetText());
  const bool caught = taken(words, "catch");
  const bool tooShort = taken(words, "short");
  build(hemocell, lumenOf(name), counts, name == "inlet", tooShort ? 4 : 20);
  for (const char* type : {"RBC", "PLT"}) {
    hemo::HemoCellField field;
    field.name = type;
    field.mesh = meshOf(std::string(type) + ".off", field);
    field.numVertex = static_cast<int>(field.mesh.getNumVertices());
    field.minimumDistanceFromSolid = name == "channel" ? 1 : 0;
    hemocell.cellfields->types.push_back(field);
  }
  packmesh::throwFailures(caught);
  try {
    run(hemocell, words);
    writeParticles(hemocell);
  } catch (const packmesh::Failure& failure) {
    std::cout << "(stand-in) rank " << rank << " caught, exit code " << failure.exitCode() << ": "
              << failure.what() << std::endl;
  }
  MPI_Finalize();
  return 0;
}
