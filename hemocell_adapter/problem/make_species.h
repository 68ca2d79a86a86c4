// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Species with their templates, and the shapes of existing cells that have meshes of their own.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// The kinds of cells of a scene.
struct SpeciesAndShapes {
  std::vector<CellSpecies> species;
  Shapes shapes;  ///< as Scene::shapes
};

/// Builds the species that are planned for a lumen, with HemoCell's acceptance of them. Their cells are not
/// counted yet.
/// @param packs they are to be packed, not examined
/// @throws InputError, MeshError; InputError if the cells that exist cannot be started from
SpeciesAndShapes makeSpecies(std::vector<SpeciesPlan> plans, const Lumen& lumen, const Request& request,
                             const Threads& team, bool packs, Notices& notices);

/// What becomes of cells that intersect themselves.
enum class SelfIntersecting {
  keep,      ///< they are to be examined
  undeform,  ///< they get the mesh of the template, which is told
  refuse     ///< an InputError: they are fixed. Pre: all cells are of one species
};

/// Existing cells of a file, in any order of the species.
struct CellsOfFile {
  std::string file;  ///< for messages
  std::vector<PresentCell> cells;
  std::function<int(std::size_t cell)> species;
  /// Of the mesh of a cell, as the file states them.
  std::function<const std::vector<Triangle>&(std::size_t cell)> triangles;
};

/// Cells with their species, of which none has vertices: those that had some have shapes instead.
struct ShapedCells {
  std::vector<PresentCell> cells;
  Shapes shapes;  ///< from a number on, which makeShapes() is given
};

/// Makes shapes of the vertices of cells. @param first number of the first of these shapes
/// @throws InputError if the triangles are not those of the template, or a cell is inside out
ShapedCells makeShapes(CellsOfFile of, const std::vector<CellSpecies>& species, std::size_t first,
                       SelfIntersecting selfIntersecting, const Threads& team, Notices& notices);

/// What soft cells exclude. @throws UsageError
void refuseBesideDeforming(const Request& request);

/// @throws InputError if a cell's XML file has some constants of the membrane, and others not. Pre: the
/// species have their numbers
void requireMembranes(const Scene& scene);

/// HemoCell reads vertices of any number. @throws InputError if there is none of such a number
void requireLinkedVertices(const std::vector<CellSpecies>& all);

/// Of a species, at the lattice spacing of the scene. Files without any constants, and cells without a file,
/// have those of HemoCell's cell templates.
MembraneConstants membraneOf(const Scene& scene, const CellSpecies& species);

/// "RBC: soft, kLink 15, kBend 80, kVolume 20, kArea 5 (RBC.xml)", for each species that there is.
std::vector<std::string> membraneLines(const Scene& scene);

}  // namespace packmesh::hemocell
