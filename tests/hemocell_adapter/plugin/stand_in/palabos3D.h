// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a case calls of HemoCell and Palabos besides what the plug-in uses, declared as there: to
/// compile cases, not to run them. The other headers that a case includes (palabos3D.hh, fluidInfo.h,
/// cellInfo.h, the models) include this one.
#pragma once

#include <ostream>

#include "hemocell.h"

using std::string;  // HemoCell's headers use the whole of std

#define DESCRIPTOR StandInDescriptor
template <class Number>
struct StandInDescriptor {
  struct ExternalField {
    static const int forceBeginsAt = 0;
  };
};

namespace plb {

typedef unsigned long pluint;

template <class Number, int size>
struct Array {
  Array(Number x, Number y, Number z);
};

template <class Number>
class MultiScalarField3D {
 public:
  Number& get(plint x, plint y, plint z);
};

template <class Number>
class VoxelizedDomain3D {
 public:
  MultiBlockManagement3D const& getMultiBlockManagement() const;
};

template <class Number, template <class> class Descriptor>
using MultiBlockLattice3D = MultiBlockLattice;

template <class Number, template <class> class Descriptor>
struct BounceBack {
  explicit BounceBack(Number rho);
};

template <class Number, template <class> class Descriptor>
void defineDynamics(MultiBlockLattice& lattice, MultiScalarField3D<int>& flags, Box3D box,
                    BounceBack<Number, Descriptor>* dynamics, int flag);
template <class Number, template <class> class Descriptor>
void defineDynamics(MultiBlockLattice& lattice, plint x, plint y, plint z,
                    BounceBack<Number, Descriptor>* dynamics);

namespace boundary {
enum BcType { dirichlet, density };
}
template <class Number, template <class> class Descriptor>
struct WrappedZouHeBoundaryManager3D;
template <class Number, template <class> class Descriptor, class Manager>
class BoundaryConditionInstantiator3D {
 public:
  void addPressureBoundary0P(Box3D box, MultiBlockLattice& lattice, boundary::BcType type);
  void addPressureBoundary1N(Box3D box, MultiBlockLattice& lattice, boundary::BcType type);
  void addPressureBoundary1P(Box3D box, MultiBlockLattice& lattice, boundary::BcType type);
  void addPressureBoundary2N(Box3D box, MultiBlockLattice& lattice, boundary::BcType type);
  void addPressureBoundary2P(Box3D box, MultiBlockLattice& lattice, boundary::BcType type);
};
void setBoundaryDensity(MultiBlockLattice& lattice, Box3D box, double rho);
void setExternalVector(MultiBlockLattice& lattice, Box3D box, int begins, Array<double, 3> value);

}  // namespace plb

enum { RBC_FROM_SPHERE, ELLIPSOID_FROM_SPHERE, MESH_FROM_STL, WBC_SPHERE };
enum { OUTPUT_POSITION, OUTPUT_TRIANGLES, OUTPUT_FORCE, OUTPUT_CELL_ID, OUTPUT_VELOCITY, OUTPUT_DENSITY };

namespace hemo {

class RbcHighOrderModel;
class RbcMalariaModel;
class PltSimpleModel;
class WbcHighOrderModel;

struct FluidStatistics {
  T avg;
};
struct FluidInfo {
  static FluidStatistics calculateVelocityStatistics(HemoCell* hemocell);
};
struct CellInformationFunctionals {
  static plb::pluint getNumberOfCellsFromType(HemoCell* hemocell, string type);
};

extern std::ostream hlog;

namespace param {
void lbm_base_parameters(Config& config);
}
void getFlagMatrixFromSTL(string file, plb::plint envelope, plb::plint refDirN, plb::plint refDir,
                          plb::VoxelizedDomain3D<T>*& domain, plb::MultiScalarField3D<int>*& flags,
                          plb::plint blockSize, int particleEnvelope);
void boundaryFromFlagMatrix(plb::MultiBlockLattice* lattice, plb::MultiScalarField3D<int>* flags,
                            bool partOfPreInlet);

}  // namespace hemo
