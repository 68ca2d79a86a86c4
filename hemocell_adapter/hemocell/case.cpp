// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/case.h"

#include <fmt/format.h>

#include "hemocell_adapter/base/xml_tags.h"
#include "hemocell_adapter/hemocell/running_case_file.h"
#include "hemocell_adapter/settings/packing_section.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

using tinyxml2::XMLElement;
namespace fs = std::filesystem;

/// 2^20 nodes along one axis are half a metre of vessel at dx = 0.5 µm: larger numbers are probably errors.
constexpr double mostNodesOfAnAxis = 1 << 20;

/// The value of a tag of `<domain>`.
Value required(const XMLElement& domain, const char* tag, const ValueSpec& spec, const fs::path& file) {
  const XMLElement* element = onlyChild(domain, tag, file);
  if (!element) {
    throw InputError(
        fmt::format("{}: has no <{}>; expected {}", placeOf(domain, file), tag, expectation(spec)));
  }
  Value value = valueOf(*element, spec, file);
  // HemoCell stops reading at the first non-digit: 1e3 is read as 1.
  if (spec.kind == Kind::integer && textOf(*element).find_first_of("eE") != std::string::npos) {
    throw InputError(fmt::format("{}: expected a whole number without exponent, found '{}'",
                                 placeOf(*element, file), trimmed(textOf(*element))));
  }
  return value;
}

int nodesIn(const XMLElement& domain, const char* tag, int least, const fs::path& file) {
  const ValueSpec spec = specs::integer("", "lattice nodes", least, mostNodesOfAnAxis);
  return int(std::get<std::int64_t>(required(domain, tag, spec, file)));
}

/// `<nx> <ny> <nz>` or `<Nx> <Ny> <Nz>`: all three or none.
std::optional<std::array<int, 3>> boxNodes(const XMLElement& domain, const fs::path& file) {
  for (const auto& names : {std::array<const char*, 3>{"nx", "ny", "nz"}, {"Nx", "Ny", "Nz"}}) {
    if (!domain.FirstChildElement(names[0])) continue;
    std::array<int, 3> nodes{};
    for (int k = 0; k < 3; ++k) nodes[k] = nodesIn(domain, names[k], 1, file);
    return nodes;
  }
  return {};
}

Domain readDomain(const XMLElement& domain, const fs::path& file) {
  Domain result;
  constexpr double micrometresPerMetre = 1e6;
  // A spacing of 100 µm or more is probably in a wrong unit.
  const ValueSpec spacing = specs::number("", "m; 5e-7 is 0.5 µm", 0, true, 1e-4);
  result.dx = std::get<double>(required(domain, "dx", spacing, file)) * micrometresPerMetre;
  result.dxWhere = placeOf(*onlyChild(domain, "dx", file), file);
  if (const XMLElement* geometry = onlyChild(domain, "geometry", file)) {
    result.geometry = file.parent_path() / std::get<std::string>(valueOf(*geometry, specs::file(), file));
    result.geometryWhere = placeOf(*geometry, file);
    result.refDir = int(std::get<std::int64_t>(
        required(domain, "refDir", specs::integer("", "0, 1, 2 for x, y, z", 0, 2), file)));
    result.refDirN = nodesIn(domain, "refDirN", 1, file);
  }
  if (const XMLElement* envelope = onlyChild(domain, "particleEnvelope", file)) {
    result.particleEnvelope = nodesIn(domain, "particleEnvelope", 0, file);
    result.particleEnvelopeWhere = placeOf(*envelope, file);
  }
  result.boxNodes = boxNodes(domain, file);
  if (!result.geometry && !result.boxNodes) {
    if (!domain.FirstChildElement("refDirN")) {
      throw InputError(
          fmt::format("{}: has neither <geometry> (with <refDir> and <refDirN>) nor <nx> <ny> <nz> nor "
                      "<Nx> <Ny> <Nz> nor <refDirN>: the lattice is unknown",
                      placeOf(domain, file)));
    }
    const int n = nodesIn(domain, "refDirN", 1, file);
    result.boxNodes = {n, n, n};
  }
  return result;
}

/// A <packing> that is not a child of the root would have no effect.
class StrayPacking : public tinyxml2::XMLVisitor {
 public:
  explicit StrayPacking(const fs::path& file) : file_(file) {}
  bool VisitEnter(const XMLElement& element, const tinyxml2::XMLAttribute*) override {
    const XMLElement* parent = element.Parent() ? element.Parent()->ToElement() : nullptr;
    const bool inRoot = parent && parent == element.GetDocument()->RootElement();
    const std::string name = element.Name();
    if (name == "packing" && !inRoot)
      throw InputError(
          fmt::format("{}: found {}; it must be a child of <hemocell>", placeOf(element, file_),
                      parent ? fmt::format("in <{}>", parent->Name()) : "outside of <hemocell>"));
    if (inRoot && isMisspelled(element, name))
      throw InputError(fmt::format("{}: unknown tag, did you mean <packing>?", placeOf(element, file_)));
    return !(inRoot && name == "packing");  // <packing> is read strictly later
  }

 private:
  /// HemoCell ignores tags that it does not know, so a case may have tags of its own: one that is only
  /// similar is an error if there is no section of the right name.
  static bool isMisspelled(const XMLElement& element, const std::string& name) {
    if (name == "packing") return false;
    if (lowered(name) == "packing") return true;
    return nearestName(name, {"packing"}) && !element.Parent()->FirstChildElement("packing");
  }

  fs::path file_;
};

void takePacking(const XMLElement& root, Case& read) {
  const XMLElement* packing = onlyChild(root, "packing", read.file);
  if (!packing) return;
  read.packing = readPackingSection(*packing, read.file);
}

}  // namespace

Case readCase(const fs::path& file) {
  tinyxml2::XMLDocument document;
  loadXml(document, file);
  const XMLElement* root = document.RootElement();
  if (!root) throw InputError(fmt::format("{}: is not XML; expected the root <hemocell>", file.string()));
  if (std::string(root->Name()) != "hemocell") {
    throw InputError(fmt::format("{}: expected the root <hemocell>", placeOf(*root, file)));
  }
  Case result;
  result.file = file;
  result.folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const XMLElement* domain = onlyChild(*root, "domain", file);
  if (!domain) throw InputError(fmt::format("{}: has no <domain>", placeOf(*root, file)));
  result.domain = readDomain(*domain, file);
  if (const XMLElement* preInlet = root->FirstChildElement("preInlet")) {
    result.hasPreInlet = true;
    if (const XMLElement* parameters = onlyChild(*preInlet, "parameters", file);
        parameters && parameters->FirstChildElement("lengthN"))
      result.preInletLength = nodesIn(*parameters, "lengthN", 1, file);
  }
  StrayPacking search(file);
  document.Accept(&search);
  takePacking(*root, result);
  result.source = readCaseSource(result.folder);
  return result;
}

Case packingSectionOf(const std::string& text) {
  tinyxml2::XMLDocument document;
  parseXml(document, text, "the XML that HemoCell has read");
  Case result;
  const std::optional<fs::path> file = runningCaseFile(document);
  result.file = file.value_or("config.xml");
  result.folder = result.file.has_parent_path() ? result.file.parent_path() : fs::path(".");
  const XMLElement* root = document.RootElement();
  if (!root || std::string(root->Name()) == "Checkpoint") return result;
  if (!file) result.file = "the XML that HemoCell has read";
  takePacking(*root, result);
  result.file = file.value_or("config.xml");
  return result;
}

}  // namespace packmesh::hemocell
