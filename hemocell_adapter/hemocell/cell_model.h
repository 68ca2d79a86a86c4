// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell cell types: parameters, and the template mesh that HemoCell builds from them.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/settings/request.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/shape/shape.h"
#include "packMesh/soft/membrane.h"

namespace packmesh::hemocell {

/// `<kLink>`, `<kBend>`, `<kVolume>` and `<kArea>` of `<Cell>.xml`; of platelets and white cells
/// `<InnerEdges>`, and of the latter `<kInnerRigid>`, `<kCytoskeleton>`, `<coreRadius>` and `<radius>`.
struct StatedMembrane {
  std::optional<MembraneConstants> constants;  ///< empty: there are none
  std::vector<std::string> missing;            ///< tags of some, if there are others
};

/// The shape of a cell as specified by `<Cell>.xml`.
struct CellModel {
  std::string name;
  Construction construction = Construction::rbcFromSphere;
  double radius = 0.0;  ///< [µm]
  int minNumTriangles = 0;
  double aspectRatio = 1.0;       ///< ELLIPSOID_FROM_SPHERE only
  std::filesystem::path stlFile;  ///< MESH_FROM_STL only; absolute or relative to the working directory
  std::optional<double> hemocellVolume;  ///< `<Volume>` [µm³]; used by HemoCell for its density output only
  StatedMembrane membrane;
};

/// @param name of the cell, which says by what model HemoCell's cases compute its forces: PltSimpleModel of
/// PLT*, WbcHighOrderModel of WBC*, otherwise RbcHighOrderModel
/// @throws InputError with file, line, tag, value and what was expected
StatedMembrane readMembrane(const std::filesystem::path& file, const std::string& name);

/// Those of HemoCell's cell templates for cells of this name (PLT*, WBC*; others: red cells).
/// @param mesh with the vertices that are linked through the cell
MembraneConstants defaultMembrane(const std::string& name, const TriangleMesh& mesh = {});

/// Half the thickness of RBC_FROM_SPHERE at distance r from its axis, both divided by the radius, is sqrt(1 -
/// r²) (C0 + C2 r² + C4 r⁴) (Evans and Fung 1972, with HemoCell's coefficients).
inline constexpr double biconcaveC0 = 0.054322, biconcaveC2 = 1.001279, biconcaveC4 = -0.561381;

/// HemoCell's default parameters of RBC, RBC_m, PLT, PLT_m, PLT_mko, WBC; empty for other names.
std::optional<CellModel> defaultModel(const std::string& name);

/// Full axis lengths along x, y, z [µm] of cells for which HemoCell has no template without an STL: vRBC,
/// with packCells' axes; empty for other names. See makeEllipsoid.
std::optional<std::array<double, 3>> defaultEllipsoid(const std::string& name);

/// The construction HemoCell cases use for a cell of this name (RBC*, PLT*, WBC*; with an STL:
/// MESH_FROM_STL).
std::optional<Construction> defaultConstruction(const std::string& name, bool hasStlFile);

/// Reads `<Cell>.xml`. `construction` overrides the default for the name. `<StlFile>` is relative to the
/// folder of `file`.
/// @throws InputError with file, line, tag, value and what was expected
CellModel readCellXml(const std::filesystem::path& file, const std::string& name,
                      std::optional<Construction> construction = {});

/// The template exactly as HemoCell builds it: same vertices (to 1e-7 µm), order and triangles.
/// @param dx lattice spacing [µm]: the mesh is inflated by 1e-3 dx; 0: not inflated
/// @throws InputError if the STL cannot be read
TriangleMesh buildTemplate(const CellModel& model, double dx);

/// Applies MESH_FROM_STL to a mesh that already has its final size [µm]: axes rotated, (x, y, z) to (-y, -z,
/// x), inflated, and centred on its bounding box.
TriangleMesh meshFromStl(TriangleMesh mesh, double dx);

/// The template with its data for packing. If HemoCell's construction has a closed form, the closed form is
/// used; it contains all vertices of the template up to rounding and lies at most 2e-3 dx outside them.
/// @param warnings if not null, receives the repairs of an STL
/// @throws MeshError if an STL is not a closed surface
std::shared_ptr<const Shape> makeShape(const CellModel& model, double dx,
                                       std::vector<std::string>* warnings = nullptr,
                                       const Threads& threads = {});

/// The template that a running HemoCell has built: as makeShape() makes it from `<Cell>.xml` in the working
/// directory, if one of the constructions gives that mesh; otherwise from the mesh alone.
/// @throws MeshError if the mesh is not a closed surface
std::shared_ptr<const Shape> makeShapeOfBuilt(const TriangleMesh& mesh, const std::string& name, double dx,
                                              const Threads& threads = {});

/// The closed form used by makeShape for the template mesh `mesh` of `model`; empty for MESH_FROM_STL.
std::optional<ProfileSurface> profileOf(const CellModel& model, const TriangleMesh& mesh);

/// An ellipsoid with full axis lengths e1, e2, e3 along x, y, z [µm] (packCells' `--cell`).
/// @throws InputError if a length is not positive and finite
std::shared_ptr<const Shape> makeEllipsoid(double e1, double e2, double e3);

/// Any closed mesh file, multiplied by `scale` [µm per unit of the file], rotated and inflated as by
/// MESH_FROM_STL or not, and centred on its bounding box. Repairs are appended to `warnings`.
/// @param dx as in buildTemplate
std::shared_ptr<const Shape> makeShapeFromFile(const Source& file, double scale, MeshFrame frame, double dx,
                                               std::vector<std::string>& warnings,
                                               const Threads& threads = {});

}  // namespace packmesh::hemocell
