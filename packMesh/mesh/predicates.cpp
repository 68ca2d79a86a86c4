// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/predicates.h"

// Exported by the TetGen library; its header declares the front ends only.
void exactinit(int verbose, int noexact, int nofilter, double maxx, double maxy, double maxz);
double orient3dadapt(double* pa, double* pb, double* pc, double* pd, double permanent);
double orient2dadapt(double* pa, double* pb, double* pc, double detsum);

namespace packmesh::predicates {

namespace {

/// The adaptive stages need constants computed by exactinit. They depend only on the arithmetic, so it is
/// harmless if TetGen computes them again. A function-local static makes the first call safe from any thread
/// and during static initialisation.
void initialise() {
  static const bool done = (exactinit(0, 0, 1, 1.0, 1.0, 1.0), true);
  (void)done;
}

int sign(double x) {
  return (x > 0.0) - (x < 0.0);
}

/// The predicates only read their arguments, but are declared without const.
double* mutableView(const double* p) {
  return const_cast<double*>(p);
}

}  // namespace

int exactSideOfPlane(const double* a, const double* b, const double* c, const double* p, double permanent) {
  if (permanent == 0.0) return 0;  // every product is exactly zero
  initialise();
  // Shewchuk's orient3d is positive below the plane.
  return -sign(orient3dadapt(mutableView(a), mutableView(b), mutableView(c), mutableView(p), permanent));
}

int exactTurn(const double* a, const double* b, const double* p, double permanent) {
  if (permanent == 0.0) return 0;
  initialise();
  return sign(orient2dadapt(mutableView(a), mutableView(b), mutableView(p), permanent));
}

}  // namespace packmesh::predicates
