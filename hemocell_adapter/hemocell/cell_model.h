// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A HemoCell cell type: its parameters and the template mesh HemoCell builds from them.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/settings/construction.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/shape/shape.h"

namespace packmesh::hemocell {

/// What `<Cell>.xml` says about the shape of a cell.
struct CellModel {
  std::string name;
  Construction construction = Construction::rbcFromSphere;
  double radius = 0.0;  ///< [µm]
  int minNumTriangles = 0;
  double aspectRatio = 1.0;       ///< ELLIPSOID_FROM_SPHERE only
  std::filesystem::path stlFile;  ///< MESH_FROM_STL only; absolute or relative to the working directory
  std::optional<double> hemocellVolume;  ///< `<Volume>` [µm³]; used by HemoCell for its density output only
};

/// Half the thickness of RBC_FROM_SPHERE at distance r from its axis, both over the radius, is
/// sqrt(1 - r²) (C0 + C2 r² + C4 r⁴) (Evans and Fung 1972, with the coefficients of HemoCell).
inline constexpr double biconcaveC0 = 0.054322, biconcaveC2 = 1.001279, biconcaveC4 = -0.561381;

/// HemoCell's own default parameters of RBC, RBC_m, PLT, PLT_m, PLT_mko, WBC; nothing for other names.
std::optional<CellModel> defaultModel(const std::string& name);

/// Full axis lengths along x, y, z [µm] of cells that HemoCell has no template for unless an STL is given:
/// vRBC, with packCells' axes; nothing for other names. See makeEllipsoid.
std::optional<std::array<double, 3>> defaultEllipsoid(const std::string& name);

/// The construction HemoCell cases use for a cell of this name (RBC*, PLT*, WBC*; with an STL:
/// MESH_FROM_STL).
std::optional<Construction> defaultConstruction(const std::string& name, bool hasStlFile);

/// Reads `<Cell>.xml`. `construction` overrides the default for the name. `<StlFile>` is relative to the
/// folder of `file`.
/// @throws InputError with file, line, tag, value and what was expected
CellModel readCellXml(const std::filesystem::path& file, const std::string& name,
                      std::optional<Construction> construction = {});

/// The template exactly as HemoCell builds it: same vertices (to 1e-7 µm), same order, same triangles.
/// @param dx lattice spacing [µm]: the mesh is inflated by 1e-3 dx; 0: not inflated
/// @throws InputError when the STL cannot be read
TriangleMesh buildTemplate(const CellModel& model, double dx);

/// MESH_FROM_STL of a mesh that has its size already [µm]: its axes turned, (x, y, z) to (-y, -z, x),
/// inflated, and centred on its bounding box.
TriangleMesh meshFromStl(TriangleMesh mesh, double dx);

/// The template with everything packing needs; closed form where HemoCell's construction has one, then at or
/// outside the vertices of the template to within rounding and at most 2e-3 dx outside.
/// @param warnings if given, receives the repairs an STL needed
/// @throws MeshError when an STL is no closed surface
std::shared_ptr<const Shape> makeShape(const CellModel& model, double dx,
                                       std::vector<std::string>* warnings = nullptr);

/// The closed form behind makeShape for the template mesh `mesh` of `model`; nothing for MESH_FROM_STL.
std::optional<ProfileSurface> profileOf(const CellModel& model, const TriangleMesh& mesh);

/// An ellipsoid with full axis lengths e1, e2, e3 along x, y, z [µm] (packCells' `--cell`).
/// @throws InputError when a length is not positive and finite
std::shared_ptr<const Shape> makeEllipsoid(double e1, double e2, double e3);

/// Any closed mesh file times `scale` (its unit in µm), turned and inflated as MESH_FROM_STL or not, centred
/// on its bounding box. Repairs are appended to `warnings`.
/// @param dx as in buildTemplate
std::shared_ptr<const Shape> makeShapeFromFile(const std::filesystem::path& file, double scale,
                                               MeshFrame frame, double dx,
                                               std::vector<std::string>& warnings);

}  // namespace packmesh::hemocell
