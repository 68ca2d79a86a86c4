// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A stand-in of the part of HemoCell that the plug-in uses, written from docs/reference/plugin.md,
/// which lists these interfaces. What builds the lattice of a case is declared only (palabos3D.h): cases are
/// compiled with it, not run. Blocks of a lattice are distributed over the ranks; particles have
/// envelopes, cross periodic faces under new numbers, and are deleted with their cell if it is incomplete, as
/// there. No flow, no mechanics.
#pragma once

#include <mpi.h>
#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace plb {

typedef long plint;

struct Dot3D {
  plint x, y, z;
};

struct Box3D {
  Box3D() : x0(0), x1(0), y0(0), y1(0), z0(0), z1(0) {}
  Box3D(plint x0_, plint x1_, plint y0_, plint y1_, plint z0_, plint z1_)
      : x0(x0_), x1(x1_), y0(y0_), y1(y1_), z0(z0_), z1(z1_) {}
  plint x0, x1, y0, y1, z0, z1;
};

/// Blocks of a lattice: which nodes each has, and on which rank it is.
struct Blocks {
  std::vector<Box3D> bulk;
  std::vector<int> rank;
};

class LocalInfo {
 public:
  std::vector<plint> const& getBlocks() const { return blocks; }
  std::vector<plint> blocks;
};

class MultiBlockManagement3D {
 public:
  Box3D getBulk(plint blockId) const { return blocks.bulk[blockId]; }
  Blocks blocks;
};

class Periodicity {
 public:
  void toggleAll(bool periodic);
  bool get(plint direction) const { return axes[direction]; }
  bool axes[3];
};

struct Dynamics {
  bool isBoundary() const { return boundary; }
  bool boundary;
};

struct Node {
  Dynamics const& getDynamics() const { return dynamics; }
  Dynamics dynamics;
};

/// A block of the fluid with its envelope of one node.
class BlockLattice {
 public:
  Dot3D getLocation() const { return location; }
  Node& get(plint x, plint y, plint z) {
    node.dynamics.boundary = solid(x + location.x, y + location.y, z + location.z);
    return node;
  }
  Dot3D location;
  std::function<bool(plint, plint, plint)> solid;
  Node node;
};

class MultiBlockLattice {
 public:
  Periodicity& periodicity();
  void toggleInternalStatistics(bool on);
  void initialize();
  Box3D getBoundingBox() const { return box; }
  MultiBlockManagement3D const& getMultiBlockManagement() const { return management; }
  LocalInfo const& getLocalInfo() const { return local; }
  BlockLattice& getComponent(plint blockId) { return components[blockId]; }
  Box3D box;
  MultiBlockManagement3D management;
  LocalInfo local;
  std::map<plint, BlockLattice> components;
};

class Mesh {
 public:
  plint getNumVertices() const { return static_cast<plint>(vertices.size()); }
  std::array<double, 3> getVertex(plint vertex) const { return vertices[vertex]; }
  std::vector<std::array<double, 3>> vertices;
};

template <class Number, int size>
struct Array;
template <class Number>
class MultiScalarField3D;

}  // namespace plb

enum Direction : int { Xpos, Xneg, Ypos, Yneg, Zpos, Zneg };

namespace hemo {

typedef double T;

template <class Number, int size>
struct Array {
  Number data[size];
  Number& operator[](int i) { return data[i]; }
  Number const& operator[](int i) const { return data[i]; }
};

namespace param {
static double dx = 5e-7;
extern double dt, rho_p;
}  // namespace param

struct ConfigValues {
  std::string checkpointDirectory = "./checkpoint/";
};
static ConfigValues global;

class XMLElement {
 public:
  explicit XMLElement(tinyxml2::XMLElement* element) : original(element) {}
  XMLElement operator[](std::string name) const;
  template <class Value>
  Value read();
  tinyxml2::XMLElement* getOrig() { return original; }

 private:
  tinyxml2::XMLElement* original;
};

class Config {
 public:
  explicit Config(std::string const& file) {
    document.LoadFile(file.c_str());
    checkpointed = std::string(document.RootElement()->Name()) == "Checkpoint";
  }
  tinyxml2::XMLElement* root() const {
    tinyxml2::XMLElement* first = const_cast<tinyxml2::XMLDocument&>(document).RootElement();
    return checkpointed ? first->FirstChildElement("hemocell") : first;
  }
  XMLElement operator[](std::string name) const {
    return XMLElement(root()->FirstChildElement(name.c_str()));
  }
  bool checkpointed;

 private:
  tinyxml2::XMLDocument document;
};

class HemoCell;

class PreInlet {
 public:
  PreInlet() {}
  PreInlet(HemoCell* hemocell, plb::MultiScalarField3D<int>* flags);
  void autoPreinletFromBoundary(Direction direction);
  void initializePreInlet();
  void createBoundary();
  void calculateDrivingForce();
  void setDrivingForce();
  void applyPreInlet();
  bool initialized = false;
};

class HemoCellParticle {
 public:
  struct serializeValues_t {
    Array<double, 3> position;
    plb::plint cellId;
    unsigned short vertexId;
    unsigned char celltype;
  };
  HemoCellParticle(Array<double, 3> position, plb::plint cellId, plb::plint vertexId,
                   unsigned long celltype) {
    sv.position = position;
    sv.cellId = cellId;
    sv.vertexId = static_cast<unsigned short>(vertexId);
    sv.celltype = static_cast<unsigned char>(celltype);
  }
  serializeValues_t sv;
};

class HemoCellFields;

class HemoCellParticleField {
 public:
  bool isContainedABS(Array<double, 3> const& position, plb::Box3D const& box) const {
    const plb::plint lo[3] = {box.x0, box.y0, box.z0}, hi[3] = {box.x1, box.y1, box.z1};
    const plb::plint at[3] = {location.x, location.y, location.z};
    for (int a = 0; a < 3; ++a) {
      const double p = position[a] - at[a];
      if (!(p > lo[a] - 0.5 && p <= hi[a] + 0.5)) return false;
    }
    return true;
  }
  void addParticle(HemoCellParticle::serializeValues_t const& sv);
  void removeParticles(plb::Box3D box) {
    removeIf([&](HemoCellParticle const& p) { return isContainedABS(p.sv.position, box); });
  }
  plb::Box3D& getBoundingBox() { return boundingBox; }
  std::map<int, std::vector<int>> const& get_particles_per_cell();
  int deleteIncompleteCells();
  template <class Condition>
  void removeIf(Condition condition) {
    particles.erase(std::remove_if(particles.begin(), particles.end(), condition), particles.end());
    index.clear();
    indexed = false;
  }

  std::vector<HemoCellParticle> particles;
  plb::Box3D localDomain, boundingBox;
  plb::Dot3D location;
  HemoCellFields* fields;
  std::map<int, std::vector<int>> index;
  bool indexed = false;
};

class MultiParticleField {
 public:
  plb::LocalInfo const& getLocalInfo() const { return local; }
  HemoCellParticleField& getComponent(plb::plint blockId) { return components[blockId]; }
  plb::Periodicity& periodicity() { return periodic; }
  plb::LocalInfo local;
  plb::Periodicity periodic;
  std::map<plb::plint, HemoCellParticleField> components;
};

class HemoCellField {
 public:
  plb::Mesh& getMesh() { return mesh; }
  std::string name;
  std::vector<Array<plb::plint, 3>> triangle_list;
  unsigned int minimumDistanceFromSolid = 0;
  int numVertex = 0;
  double volume = 0;
  plb::Mesh mesh;
};

class HemoCellFields {
 public:
  explicit HemoCellFields(HemoCell& owner) : hemocell(owner) {}
  HemoCellField* operator[](unsigned int index) { return &types[index]; }
  unsigned int size() { return static_cast<unsigned int>(types.size()); }
  void syncEnvelopes();
  void deleteIncompleteCells(bool verbose = true);
  int base_cell_id(int wrapped) {
    const int rest = wrapped % number_of_cells;
    return rest < 0 ? rest + number_of_cells : rest;
  }

  HemoCell& hemocell;
  std::vector<HemoCellField> types;
  MultiParticleField* immersedParticles = 0;
  unsigned long envelopeSize = 0;
  int number_of_cells = 0;
  int periodicity_limit_offset_y = 100;
  int periodicity_limit_offset_z = 10000;
};

class HemoCell {
 public:
  HemoCell() {}
  HemoCell(char* configFileName, int argc, char* argv[]);
  void initializeLattice(plb::MultiBlockManagement3D const& management);
  void latticeEquilibrium(T rho, plb::Array<T, 3> velocity);
  void initializeCellfield();
  template <class Mechanics>
  void addCellType(std::string name, int constructType);
  void setMaterialTimeScaleSeparation(std::string name, unsigned int separation);
  void setParticleVelocityUpdateTimeScaleSeparation(unsigned int separation);
  void setOutputs(std::string name, std::vector<int> outputs);
  void setFluidOutputs(std::vector<int> outputs);
  void setSystemPeriodicity(unsigned int axis, bool bePeriodic);
  void checkExitSignals();
  void loadParticles();
  void writeOutput();
  /// Deletes vertices on wall nodes, as HemoCell does where it moves them.
  void iterate();
  void saveCheckPoint();
  void loadCheckPoint();
  PreInlet* preInlet = 0;
  bool partOfpreInlet = false;
  Config* cfg = 0;
  plb::MultiBlockLattice* lattice = 0;
  HemoCellFields* cellfields = 0;
  unsigned int iter = 0;
};

inline std::map<int, std::vector<int>> const& HemoCellParticleField::get_particles_per_cell() {
  if (indexed) return index;
  index.clear();
  for (std::size_t i = 0; i < particles.size(); ++i) {
    std::vector<int>& cell = index[static_cast<int>(particles[i].sv.cellId)];
    if (cell.empty()) cell.assign((*fields)[particles[i].sv.celltype]->numVertex, -1);
    cell[particles[i].sv.vertexId] = static_cast<int>(i);
  }
  indexed = true;
  return index;
}

/// A particle that is there already is replaced, unless it is in the block itself.
inline void HemoCellParticleField::addParticle(HemoCellParticle::serializeValues_t const& sv) {
  if (!isContainedABS(sv.position, boundingBox)) return;
  get_particles_per_cell();
  std::vector<int>& cell = index[static_cast<int>(sv.cellId)];
  if (cell.empty()) cell.assign((*fields)[sv.celltype]->numVertex, -1);
  int& at = cell[sv.vertexId];
  if (at >= 0) {
    if (!isContainedABS(particles[at].sv.position, localDomain)) particles[at].sv = sv;
    return;
  }
  at = static_cast<int>(particles.size());
  particles.emplace_back(sv.position, sv.cellId, sv.vertexId, sv.celltype);
}

inline int HemoCellParticleField::deleteIncompleteCells() {
  const std::map<int, std::vector<int>> cells = get_particles_per_cell();
  const std::size_t before = particles.size();
  removeIf([&](HemoCellParticle const& p) {
    const std::vector<int>& cell = cells.at(static_cast<int>(p.sv.cellId));
    return std::find(cell.begin(), cell.end(), -1) != cell.end();
  });
  return static_cast<int>(before - particles.size());
}

inline void HemoCellFields::deleteIncompleteCells(bool) {
  for (const plb::plint id : immersedParticles->getLocalInfo().getBlocks())
    immersedParticles->getComponent(id).deleteIncompleteCells();
}

/// Particles of each rank, from the blocks that they are in.
inline std::vector<std::vector<HemoCellParticle::serializeValues_t>> particlesOfRanks(
    MultiParticleField& field) {
  typedef HemoCellParticle::serializeValues_t Values;
  std::vector<Values> mine;
  for (const plb::plint id : field.getLocalInfo().getBlocks()) {
    HemoCellParticleField& block = field.getComponent(id);
    for (HemoCellParticle const& p : block.particles)
      if (block.isContainedABS(p.sv.position, block.localDomain)) mine.push_back(p.sv);
  }
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  std::vector<std::vector<Values>> all;
  for (int r = 0; r < ranks; ++r) {
    std::vector<Values> part = mine;
    unsigned long count = part.size();
    MPI_Bcast(&count, 1, MPI_UNSIGNED_LONG, r, MPI_COMM_WORLD);
    part.resize(count);
    MPI_Bcast(part.data(), static_cast<int>(count * sizeof(Values)), MPI_BYTE, r, MPI_COMM_WORLD);
    all.push_back(part);
  }
  return all;
}

/// Every block receives the particles of all blocks, in all images; it keeps those within its envelope.
inline void HemoCellFields::syncEnvelopes() {
  typedef HemoCellParticle::serializeValues_t Values;
  for (const plb::plint id : immersedParticles->getLocalInfo().getBlocks()) {
    HemoCellParticleField& block = immersedParticles->getComponent(id);
    block.removeIf(
        [&](HemoCellParticle const& p) { return !block.isContainedABS(p.sv.position, block.localDomain); });
  }
  const std::vector<std::vector<Values>> all = particlesOfRanks(*immersedParticles);
  const plb::Box3D box = hemocell.lattice->getBoundingBox();
  const plb::plint n[3] = {box.x1 - box.x0 + 1, box.y1 - box.y0 + 1, box.z1 - box.z0 + 1};
  const plb::plint steps[3] = {1, periodicity_limit_offset_y, periodicity_limit_offset_z};
  for (const plb::plint id : immersedParticles->getLocalInfo().getBlocks()) {
    HemoCellParticleField& block = immersedParticles->getComponent(id);
    int image[3];
    for (image[0] = -1; image[0] <= 1; ++image[0])
      for (image[1] = -1; image[1] <= 1; ++image[1])
        for (image[2] = -1; image[2] <= 1; ++image[2]) {
          bool possible = true;
          for (int a = 0; a < 3; ++a)
            possible = possible && (image[a] == 0 || immersedParticles->periodicity().get(a));
          if (!possible) continue;
          for (const std::vector<Values>& part : all)
            for (Values moved : part) {
              for (int a = 0; a < 3; ++a) {
                moved.position[a] += image[a] * n[a];
                moved.cellId += image[a] * steps[a] * number_of_cells;
              }
              block.addParticle(moved);
            }
        }
  }
}

inline void HemoCell::iterate() {
  ++iter;
  for (const plb::plint id : cellfields->immersedParticles->getLocalInfo().getBlocks()) {
    HemoCellParticleField& block = cellfields->immersedParticles->getComponent(id);
    plb::BlockLattice& fluid = lattice->getComponent(id);
    block.removeIf([&](HemoCellParticle const& p) {
      const auto node = [&](int axis) { return std::lround(p.sv.position[axis]); };
      return block.isContainedABS(p.sv.position, block.localDomain) && fluid.solid(node(0), node(1), node(2));
    });
  }
}

/// Text and tags only: HemoCell's checkpoints have no attributes.
inline void writeElement(std::ostream& out, const tinyxml2::XMLElement* element) {
  out << '<' << element->Name() << '>' << (element->GetText() ? element->GetText() : "");
  for (auto* child = element->FirstChildElement(); child; child = child->NextSiblingElement())
    writeElement(out, child);
  out << "</" << element->Name() << '>';
}

inline void HemoCell::saveCheckPoint() {
  const auto all = particlesOfRanks(*cellfields->immersedParticles);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) {
    if (std::system(("mkdir -p " + global.checkpointDirectory).c_str()) != 0) std::exit(1);
    std::ofstream data(global.checkpointDirectory + "particleField.dat", std::ios::binary);
    for (auto const& part : all)
      data.write(reinterpret_cast<const char*>(part.data()), part.size() * sizeof(part[0]));
    std::ofstream xml(global.checkpointDirectory + "checkpoint.xml");
    xml << "<?xml version=\"1.0\" ?>\n<Checkpoint>\n";
    writeElement(xml, cfg->root());
    xml << "<General><Iteration>" << iter
        << "</Iteration><OutDirectory>./</OutDirectory></General></Checkpoint>\n";
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

/// Counts cells in files, as HemoCell does: without a file the number is undefined.
inline void HemoCell::loadCheckPoint() {
  std::ifstream data(global.checkpointDirectory + "particleField.dat", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(data)), std::istreambuf_iterator<char>());
  MultiParticleField& field = *cellfields->immersedParticles;
  for (const plb::plint id : field.getLocalInfo().getBlocks()) {
    HemoCellParticleField& block = field.getComponent(id);
    block.removeParticles(block.getBoundingBox());
    HemoCellParticle::serializeValues_t one;
    for (std::size_t at = 0; at < bytes.size(); at += sizeof one) {
      std::copy(bytes.data() + at, bytes.data() + at + sizeof one, reinterpret_cast<char*>(&one));
      if (block.isContainedABS(one.position, block.localDomain)) block.addParticle(one);
    }
  }
  cellfields->number_of_cells = 0;
  for (unsigned int t = 0; t < cellfields->size(); ++t) {
    int count = 65528;
    std::ifstream pos((*cellfields)[t]->name + ".pos");
    if (pos) pos >> count;
    cellfields->number_of_cells += count;
  }
  cellfields->syncEnvelopes();
  cellfields->deleteIncompleteCells();
}

}  // namespace hemo
