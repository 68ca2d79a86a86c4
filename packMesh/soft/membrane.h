// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Membranes of deformable cells: a mesh at rest and the elastic constants that HemoCell reads.
///
/// HemoCell's high-order model (Závodszky et al., Front. Physiol. 8, 563, 2017; rbcHighOrderModel.cpp and
/// constant_defaults.h of version 2.7) has four laws of the form k (x + x / |limit - x²|): links by the
/// strain of edges, bending by the deviation of a vertex from the centre of its neighbours along their
/// normal, area by the strain of triangles, and volume by that of the cell. Platelets (pltSimpleModel.cpp)
/// bend by the angles between triangles, and have links through the cell, of which those of white cells
/// (wbcHighOrderModel.cpp) only push.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/soft/soft_kernels.h"

namespace packmesh {

enum class MembraneModel { highOrder, platelet, whiteCell };

/// Constants of a cell's XML file (kLink, kBend, kVolume, kArea, InnerEdges) and of the simulation.
struct MembraneConstants {
  /// Links that push as long as they are shorter than twice the radius.
  struct Core {
    double force = 0.0, radius = 0.0;  ///< without length [pN], and [µm]
  };

  double link = 15.0, bend = 80.0, volume = 20.0, area = 5.0;
  double thermalEnergy = 4.100531391e-3;  ///< kBT [pN µm]; HemoCell: 4.1e-21 J at 300 K
  double spacing = 0.5;  ///< of the lattice [µm]: HemoCell's force of area is proportional to it
  MembraneModel model = MembraneModel::highOrder;
  std::vector<std::array<int, 2>> innerLinks = {};  ///< vertices; the high-order model of red cells has none
  Core cytoskeleton = {}, core = {};                ///< of white cells
};

/// Squares of the strains at which the laws have poles: constant_defaults.h of HemoCell.
struct MembraneLimits {
  static constexpr double link = 9.0, bend = 0.0555, area = 0.09, volume = 0.01;
  static constexpr double angle = 2.467;  ///< [rad²], of platelets
};

/// A template's mesh at rest, with the forces of its laws [pN, µm].
class Membrane {
 public:
  /// @throws InputError if the mesh has more than 32,767 vertices or triangles, or not the linked vertices
  /// Pre: the mesh is closed, oriented, and one surface around every vertex
  Membrane(const TriangleMesh& mesh, const MembraneConstants& constants);

  const TriangleMesh& mesh() const { return mesh_; }
  const std::vector<std::array<int, 2>>& edges() const { return edges_; }
  double volume() const { return volume_; }  ///< [µm³]
  double area() const { return area_; }      ///< [µm²]
  double meanEdge() const { return meanEdge_; }
  MembraneView view() const;

 private:
  friend double membraneEnergy(const Membrane&, const std::vector<Vec3>&, double, std::vector<Vec3>*);
  friend std::vector<Vec3> hemocellForces(const Membrane&, const std::vector<Vec3>&);
  /// The triangles at both sides of an edge.
  struct Hinge {
    int right, left;  ///< corners beside the edge, as seen from outside along it
    int rightTriangle, leftTriangle;
    double angle;  ///< at rest, see angleAt() [rad]
    double sense;  ///< -1: HemoCell bends it the other way
  };
  /// A link through the cell.
  struct Spring {
    std::array<int, 2> end;
    double length;  ///< at rest [µm]
    double force;   ///< at unit strain [pN]
    bool pulls;     ///< or it only pushes
    double strain(double lengthNow) const {
      const double x = lengthNow / length - 1.0;
      return pulls ? x : std::min(x, 0.0);
    }
  };
  void findRings();
  void findHinges();
  void findSprings();
  void measureRest();
  std::pair<Vec3, double> patchAt(const std::vector<Vec3>& x, int v) const;
  double angleAt(const std::vector<Vec3>& x, std::size_t edge) const;
  void addHemocellBending(const std::vector<Vec3>& x, std::vector<Vec3>& force) const;

  TriangleMesh mesh_;
  MembraneConstants constants_;
  std::vector<std::array<int, 2>> edges_;
  std::vector<int> ringBegin_;
  std::vector<std::int16_t> corner_, end_, ring_, ringTriangle_;
  std::vector<float> ringShare_;
  /// Those of each edge, none if bending is that of patches; and their views.
  struct {
    std::vector<Hinge> all;
    std::vector<std::int16_t> corner;
    std::vector<float> rest;
  } hinges_;
  struct {
    std::vector<Spring> all;
    std::vector<std::int16_t> end;
    std::vector<float> number;
  } springs_;
  std::vector<double> length_, triangleArea_, deviation_;  ///< at rest
  std::vector<float> inverseLength_, inverseArea_, deviationView_;
  double volume_ = 0.0, area_ = 0.0, meanEdge_ = 0.0;
  double volumeGradient_ = 0.0;                             ///< squared, of all vertices [µm⁴]
  double linkForce_, bendForce_, areaForce_, volumeForce_;  ///< at unit strain, without poles [pN]
};

/// The energy of a cell that packing minimises [pN µm], and its gradient with opposite sign.
///
/// That of HemoCell's laws, with four differences. The force of area follows the gradient of the area, where
/// HemoCell's pulls towards the centroid: along that, triangles collapse. Its pole is at a strain of 0.25
/// instead of 0.3, so that triangles stay away from HemoCell's. And near the poles all laws continue
/// linearly, so that steps that exceed them can be undone. Platelets resist bending at all edges: HemoCell's
/// give way at some of them (Membrane::findHinges()).
/// @param scale of the rest state: lengths are multiplied by it
/// @param forces appended to: 3 per vertex [pN]
double membraneEnergy(const Membrane& membrane, const std::vector<Vec3>& vertices, double scale,
                      std::vector<Vec3>* forces = nullptr);

/// Forces on the vertices as HemoCell's own laws give them in its first iteration [pN].
std::vector<Vec3> hemocellForces(const Membrane& membrane, const std::vector<Vec3>& vertices);

/// How much a cell is deformed: what summaries state, and limits refuse.
struct Deformation {
  double force = 0.0;     ///< largest on a vertex, by hemocellForces() [pN]
  double volume = 0.0;    ///< change [fraction]
  double area = 0.0;      ///< change [fraction]
  double triangle = 0.0;  ///< largest change of the area of a triangle [fraction]
  double edge = 0.0;      ///< largest change of the length of an edge [fraction]

  /// Takes over what is larger in magnitude, of another cell.
  void enlarge(const Deformation& other);
};
Deformation deformationOf(const Membrane& membrane, const std::vector<Vec3>& vertices);

}  // namespace packmesh
