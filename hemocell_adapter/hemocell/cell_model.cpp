// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/cell_model.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <charconv>
#include <cmath>
#include <sstream>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/base/xml_tags.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// Larger numbers of triangles are probably errors.
constexpr int mostTriangles = 5'000'000;
/// Plausible radii of blood cells [m]; excludes 3.91 instead of 3.91e-6.
constexpr double smallestRadius = 1e-8, largestRadius = 1e-3;

bool startsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

/// `<MaterialModel>` of one file, with errors that state file and line.
class MaterialModel {
 public:
  explicit MaterialModel(const std::filesystem::path& file) : file_(file) {
    loadXml(document_, file);
    const tinyxml2::XMLElement* root = document_.RootElement();
    if (!root) throw InputError(file.string() + ": no XML element, expected <hemocell>");
    if (std::string(root->Name()) != "hemocell")
      fail(*root, fmt::format("root is <{}>, expected <hemocell>", root->Name()));
    element_ = root->FirstChildElement("MaterialModel");
    if (!element_) fail(*root, "expected <MaterialModel> inside <hemocell>, found none");
  }

  [[noreturn]] void fail(const tinyxml2::XMLElement& at, const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", file_.string(), at.GetLineNum(), what));
  }
  [[noreturn]] void failMissing(const char* tag, const char* expected) const {
    fail(*element_, fmt::format("<MaterialModel> has no <{}>, expected {}", tag, expected));
  }
  [[noreturn]] void failValue(const char* tag, const char* expected) const {
    const tinyxml2::XMLElement& at = *element_->FirstChildElement(tag);
    fail(at, fmt::format("<{}> '{}', expected {}", tag, trimmed(textOf(at)), expected));
  }

  /// The element's text, empty if there is no such element.
  std::optional<std::string> text(const char* tag) const {
    const tinyxml2::XMLElement* found = element_->FirstChildElement(tag);
    if (!found) return {};
    if (const tinyxml2::XMLElement* second = found->NextSiblingElement(tag))
      fail(*second,
           fmt::format("<{}> occurs here and on line {}, expected only one", tag, found->GetLineNum()));
    return trimmed(textOf(*found));
  }

  std::optional<double> number(const char* tag, const char* expected) const {
    return parsed<double>(tag, expected, [](double value) { return std::isfinite(value); });
  }
  std::optional<int> integer(const char* tag, const char* expected) const {
    return parsed<int>(tag, expected, [](int) { return true; });
  }
  /// Pairs of different numbers from 0 on, in the elements inside of one; none without it.
  std::vector<std::array<int, 2>> pairs(const char* tag, const char* expected) const {
    std::vector<std::array<int, 2>> all;
    const tinyxml2::XMLElement* const list = element_->FirstChildElement(tag);
    const auto* one = list ? list->FirstChildElement() : nullptr;
    for (; one; one = one->NextSiblingElement()) {
      std::istringstream text(textOf(*one));
      std::array<int, 2> pair{};
      std::string more;
      if (!(text >> pair[0] >> pair[1]) || text >> more || pair[0] < 0 || pair[1] < 0 || pair[0] == pair[1])
        fail(*one, fmt::format("<{}> '{}', expected {}", one->Name(), trimmed(textOf(*one)), expected));
      all.push_back(pair);
    }
    return all;
  }

 private:
  /// Throws for a malformed number, which HemoCell would read as 0.
  template <class Number, class Valid>
  std::optional<Number> parsed(const char* tag, const char* expected, Valid valid) const {
    const std::optional<std::string> spelled = text(tag);
    if (!spelled) return {};
    const char *begin = spelled->data(), *end = begin + spelled->size();
    if (end - begin > 1 && begin[0] == '+' && begin[1] != '-') ++begin;
    Number value{};
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error != std::errc() || stop != end || !valid(value)) failValue(tag, expected);
    return value;
  }

  std::filesystem::path file_;
  tinyxml2::XMLDocument document_;
  const tinyxml2::XMLElement* element_ = nullptr;
};

MembraneModel modelOf(const std::string& name) {
  if (startsWith(name, "PLT")) return MembraneModel::platelet;
  if (startsWith(name, "WBC")) return MembraneModel::whiteCell;
  return MembraneModel::highOrder;
}

/// A number that HemoCell's model of white cells reads; those of a file without it are computed by another
/// one.
/// @param unit by which it is multiplied
double ofWhiteCell(const MaterialModel& material, const char* tag, const char* expected, double unit) {
  const std::optional<double> value = material.number(tag, expected);
  if (value && *value < 0.0) material.failValue(tag, expected);
  return value.value_or(0.0) * unit;
}

void readInnerLinks(const MaterialModel& material, MembraneConstants& constants) {
  constants.innerLinks = material.pairs("InnerEdges", "two different numbers of vertices, from 0 on");
  if (constants.model != MembraneModel::whiteCell) return;
  constexpr const char *newtons = "a force in N that is not negative",
                       *metres = "a length in m that is not negative";
  constexpr double piconewtons = 1e12, micrometres = 1e6;  // in one of the unit of the file
  constants.cytoskeleton = {ofWhiteCell(material, "kCytoskeleton", newtons, piconewtons),
                            ofWhiteCell(material, "radius", metres, micrometres)};
  constants.core = {ofWhiteCell(material, "kInnerRigid", newtons, piconewtons),
                    ofWhiteCell(material, "coreRadius", metres, micrometres)};
}

/// Vertices at the same distance from the middle at opposite sides of it.
std::vector<std::array<int, 2>> oppositeVertices(const std::vector<Vec3>& vertices) {
  const Box box = boundingBox({vertices, {}});
  const Vec3 twiceMiddle = box.lo + box.hi;
  const double same = 1e-3 * box.size().maxCoeff();
  std::vector<std::array<int, 2>> pairs;
  for (int a = 0; a < int(vertices.size()); ++a)
    for (int b = a + 1; b < int(vertices.size()); ++b)
      if ((vertices[a] + vertices[b] - twiceMiddle).norm() < same) pairs.push_back({a, b});
  return pairs;
}

/// `<InnerEdges>` of HemoCell's PLT_template.xml: 21 of the 33 pairs of opposite vertices.
constexpr std::array<std::array<int, 2>, 21> plateletLinks = {
    {{60, 65}, {62, 64}, {37, 42}, {54, 56}, {34, 40}, {25, 46}, {50, 59},
     {29, 47}, {61, 63}, {26, 45}, {33, 43}, {27, 35}, {32, 39}, {49, 51},
     {0, 4},   {48, 52}, {6, 10},  {53, 55}, {19, 21}, {57, 58}, {15, 13}}};
constexpr std::size_t plateletVertices = 66;

StatedMembrane readMembrane(const MaterialModel& material, const std::string& name) {
  MembraneConstants constants;
  constants.model = modelOf(name);
  StatedMembrane membrane;
  int stated = 0;
  for (const auto& [tag, constant] : {std::pair{"kLink", &MembraneConstants::link},
                                      {"kBend", &MembraneConstants::bend},
                                      {"kVolume", &MembraneConstants::volume},
                                      {"kArea", &MembraneConstants::area}}) {
    constexpr const char* expected = "a number that is not negative";
    const std::optional<double> value = material.number(tag, expected);
    if (value && *value < 0.0) material.failValue(tag, expected);
    if (!value) membrane.missing.emplace_back(tag);
    if (value) ++stated;
    constants.*constant = value.value_or(0.0);
  }
  if (stated == 0) return {};
  if (constants.model != MembraneModel::highOrder) readInnerLinks(material, constants);
  membrane.constants = constants;
  return membrane;
}

}  // namespace

StatedMembrane readMembrane(const std::filesystem::path& file, const std::string& name) {
  return readMembrane(MaterialModel(file), name);
}

MembraneConstants defaultMembrane(const std::string& name, const TriangleMesh& mesh) {
  MembraneConstants constants;
  constants.model = modelOf(name);
  const auto set = [&](double link, double bend, double volume, double area) {
    constants.link = link, constants.bend = bend, constants.volume = volume, constants.area = area;
  };
  if (constants.model == MembraneModel::platelet) {
    set(25.0, 250.0, 100.0, 8.0);
    if (mesh.vertices.size() == plateletVertices)
      constants.innerLinks.assign(plateletLinks.begin(), plateletLinks.end());
  }
  if (constants.model == MembraneModel::whiteCell) {
    set(60.0, 200.0, 20.0, 20.0);
    constants.cytoskeleton = {6.40625e-3, 4.0};
    constants.core = {6.40625, 2.5};
    constants.innerLinks = oppositeVertices(mesh.vertices);
  }
  return constants;
}

std::optional<CellModel> defaultModel(const std::string& name) {
  // HemoCell's cell templates.
  const auto model = [&](Construction construction, double radius, int triangles, double aspect) {
    return CellModel{name, construction, radius, triangles, aspect, {}, {}, {}};
  };
  if (name == "RBC") return model(Construction::rbcFromSphere, 3.91, 600, 1.0);
  if (name == "RBC_m") return model(Construction::rbcFromSphere, 2.9, 600, 1.0);
  if (name == "PLT") return model(Construction::ellipsoidFromSphere, 1.25, 66, 0.434782608696);
  if (name == "PLT_m") return model(Construction::ellipsoidFromSphere, 0.95, 66, 0.57);
  if (name == "PLT_mko") return model(Construction::ellipsoidFromSphere, 1.71, 66, 1.0);
  if (name == "WBC") return model(Construction::wbcSphere, 4.0, 600, 1.0);
  return {};
}

std::optional<std::array<double, 3>> defaultEllipsoid(const std::string& name) {
  if (name == "vRBC") return std::array<double, 3>{3.5, 6.0, 11.0};
  return {};
}

std::optional<Construction> defaultConstruction(const std::string& name, bool hasStlFile) {
  if (hasStlFile) return Construction::meshFromStl;
  if (startsWith(name, "RBC")) return Construction::rbcFromSphere;
  if (startsWith(name, "PLT")) return Construction::ellipsoidFromSphere;
  if (startsWith(name, "WBC")) return Construction::wbcSphere;
  return {};
}

CellModel readCellXml(const std::filesystem::path& file, const std::string& name,
                      std::optional<Construction> construction) {
  const MaterialModel material(file);
  const std::optional<std::string> stl = material.text("StlFile");
  if (!construction) construction = defaultConstruction(name, stl.has_value());
  if (!construction)
    throw InputError(fmt::format(
        "{}: the construction of {} is specified in the case's code, not here, and cannot be derived "
        "from its name; expected its construction, {} ({})",
        file.string(), name, alternatives(constructionNames()), "<species construction=\"...\">"));

  CellModel model;
  model.name = name;
  model.construction = *construction;

  constexpr const char* radiusExpected = "the radius in metres, e.g. 3.91e-6";
  const std::optional<double> radius = material.number("radius", radiusExpected);
  if (!radius) material.failMissing("radius", radiusExpected);
  if (!(*radius >= smallestRadius && *radius <= largestRadius)) material.failValue("radius", radiusExpected);
  model.radius = *radius * 1e6;

  constexpr const char* trianglesExpected = "a whole number from 1 to 5000000, e.g. 600";
  const std::optional<int> triangles = material.integer("minNumTriangles", trianglesExpected);
  if (triangles && (*triangles < 1 || *triangles > mostTriangles))
    material.failValue("minNumTriangles", trianglesExpected);
  if (!triangles && *construction != Construction::meshFromStl)
    material.failMissing("minNumTriangles", trianglesExpected);
  model.minNumTriangles = triangles.value_or(0);

  constexpr const char* aspectExpected = "thickness over diameter, a positive number such as 0.434782608696";
  const std::optional<double> aspect = material.number("aspectRatio", aspectExpected);
  if (aspect && !(*aspect > 0.0 && *aspect <= 100.0)) material.failValue("aspectRatio", aspectExpected);
  if (!aspect && *construction == Construction::ellipsoidFromSphere)
    material.failMissing("aspectRatio", aspectExpected);
  model.aspectRatio = aspect.value_or(1.0);

  constexpr const char* volumeExpected = "the volume in µm³, e.g. 90";
  model.hemocellVolume = material.number("Volume", volumeExpected);
  if (model.hemocellVolume && !(*model.hemocellVolume > 0.0)) material.failValue("Volume", volumeExpected);

  model.membrane = readMembrane(material, name);

  if (*construction == Construction::meshFromStl) {
    constexpr const char* stlExpected = "the name of an STL file";
    if (!stl) material.failMissing("StlFile", stlExpected);
    if (stl->empty()) material.failValue("StlFile", stlExpected);
    model.stlFile = file.parent_path() / *stl;  // an absolute *stl replaces the folder
  }
  return model;
}

}  // namespace packmesh::hemocell
