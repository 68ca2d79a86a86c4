// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Detection and resolution of contacts between two bodies, and between a body and the wall.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/field/sampled_distance.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/contact_kernels.h"
#include "packMesh/relaxation/neighbor_list.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// A wall in closed form, or sampled: on a fine grid for points that may touch it, on a coarse one to exclude
/// distant points and for cells that are deep in the wall.
class WallField {
 public:
  /// @param wall must outlive this
  /// @param region that contains all cells [µm]
  WallField(const Wall& wall, const Box& region);

  /// Distance at a point; exceeds the true one by at most slack() [µm].
  double distance(const Vec3& p) const;
  double slack() const { return slack_; }

  /// The wall in the frame of a cell that extends `reach` from its centre [µm].
  /// @param deep the cell is deep in the wall, so that coarse distances suffice
  WallFrame frameOf(const Body& body, double reach, bool deep) const;

 private:
  struct Sampled {
    const SampledDistance &coarse, &fine;
  };

  std::optional<ClosedFormWall> form_;
  std::optional<Sampled> sampled_;
  double slack_ = 0.0;
};

/// Contacts deeper than this are found with coarse samples [µm]: they are resolved in fewer sweeps than with
/// fine ones, in which cells lock.
constexpr double deepContact = 0.4;

/// Properties of a shape that relaxation uses.
struct ShapeModel {
  const Shape* shape;
  SupportBound bound;
  double radius;          ///< [µm]
  double inverseMass;     ///< of a cell of scale 1 that can move; 1 for the shape of the median volume
  double inverseInertia;  ///< isotropic [1/µm²], times inverseMass
  double lockedDepth;     ///< deeper contacts may be locked [µm]

  /// What finds contacts; that of a deformed cell is made when it is first needed.
  const ContactViews& views() const { return shape->views(); }

  /// References the shape, which must outlive the model.
  /// @param referenceVolume volume of a cell of mass 1 [µm³]
  ShapeModel(const Shape& of, double referenceVolume);
};

/// Constraints of a species.
struct SpeciesModel {
  const Wall* wall;  ///< nullptr: none
  Freedom freedom = {};
  const WallField* wallField = nullptr;  ///< of the wall; set by the solver
  const WallField* layerWall = nullptr;  ///< of the free layer
};

/// Finds and resolves contacts, one pair after the other (over-relaxed projected Gauss-Seidel): the two cells
/// of a contact are moved as rigid bodies, in proportion to their inverse masses and inertias, so that
/// `omega` times the penetration is removed.
class ContactSolver {
 public:
  /// @param region where cells can be [µm]
  ContactSolver(std::vector<ShapeModel> shapes, std::vector<SpeciesModel> species, const Box& region,
                const Vec3& period, double clearance, double wallClearance);

  /// @param slack penetrations up to this are not resolved [µm]
  void setPush(double omega, double slack) {
    omega_ = omega;
    slack_ = slack;
  }
  /// @param motion expected relative displacement of two cells within some sweeps [µm]
  void setExpectedMotion(double motion) { expectedMotion_ = motion; }

  /// Examine every pair completely, also where it did not touch last.
  void setThoroughly(bool thoroughly) { thoroughly_ = thoroughly; }
  /// Use coarse samples for all contacts.
  void setCoarsely(bool coarsely) { coarsely_ = coarsely; }
  /// Move a body once for both contacts of a pair, and examine touching pairs completely less often: cheaper
  /// sweeps, of which dense packings need as many.
  void setEconomical(bool economical) { economical_ = economical; }
  void setMobile(bool rotate) { rotate_ = rotate; }

  /// Resolves the contacts of a pair; records in the pair how long its next test can be skipped.
  void resolve(ContactPair& pair, std::vector<Body>& bodies, SweepSums& sums) const;

  /// Resolves the contacts of a body with its wall and, if its species is restricted to a region, moves it
  /// there.
  void resolveSurroundings(Body& body, SweepSums& sums) const;

 private:
  struct Contact;
  struct Meeting;
  struct Motion;
  struct Push;
  /// Lower bound of the distance between the surfaces of two bodies, from bounding volumes [µm]; may be
  /// negative.
  double boundedGap(const Body& a, const Body& b, const Vec3& fromB) const;
  /// Samples of one body (side 0: of the first) against the surface of the other; see ContactKernel for
  /// `margin` and `mask`.
  bool findContact(const Meeting& meeting, int side, bool coarsely, double margin, ClusterMask& mask,
                   Contact& contact, double& nearest, ClusterMask& touched) const;
  /// Whether it suffices to examine the clusters that touched at the last complete test.
  bool mayLookQuickly(const ContactPair& pair) const;
  bool findKnownContacts(ContactPair& pair, const Meeting& meeting, Contact (&contacts)[2],
                         bool (&touching)[2]) const;
  bool findContacts(ContactPair& pair, const Meeting& meeting, Contact (&contacts)[2], bool (&touching)[2],
                    double& nearest) const;
  void resolve(const Contact (&contacts)[2], const bool (&touching)[2], Body& a, Body& b,
               SweepSums& sums) const;
  void resolveWall(Body& body, SweepSums& sums) const;
  void resolveLayer(Body& body, SweepSums& sums) const;
  void resolveRegion(Body& body, SweepSums& sums) const;
  /// Of a contact, which adds to the overlaps of both bodies.
  Push pushOf(const Contact& contact, Body& away, Body& back) const;
  void push(Body& body, const WallSums& found, SweepSums& sums) const;
  void move(Body& body, const Vec3& translation, const Vec3& rotation) const;
  bool isFixed(const Body& body) const { return species_[body.species].freedom.fixed; }

  std::vector<ShapeModel> shapes_;
  std::vector<SpeciesModel> species_;
  Vec3 period_;
  double clearance_, wallClearance_;
  double omega_ = 1.0, slack_ = 0.0;
  bool rotate_ = true, coarsely_ = false, thoroughly_ = true, economical_ = false;
  double expectedMotion_ = 0.1;
  ContactKernel kernel_;
  WallKernel wallKernel_;
  std::vector<std::unique_ptr<WallField>> walls_;
};

}  // namespace packmesh
