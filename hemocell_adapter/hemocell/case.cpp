// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <fstream>
#include <sstream>
#include <vector>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/base/xml_tags.h"
#include "hemocell_adapter/settings/packing_section.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

bool isSource(const fs::path& file) {
  const std::string ending = file.extension().string();
  for (const char* one : {".cpp", ".cc", ".cxx", ".C", ".h", ".hh", ".hpp", ".hxx"})
    if (ending == one) return true;
  return false;
}

constexpr const char* blanks = " \t\r\n";

/// A text of the same length without comments, and one without the contents of literals, too.
struct Code {
  std::string withLiterals, bare;
};

Code codeOf(const std::string& text) {
  Code code{text, text};
  const std::size_t size = text.size();
  for (std::size_t at = 0; at < size;) {
    const std::size_t first = at;
    const auto past = [&](const char* end, std::size_t length) {
      const std::size_t found = text.find(end, first + 2);
      return found == text.npos ? size : found + length;
    };
    const char c = text[at];
    const bool separator = c == '\'' && at > 0 && text[at - 1] >= '0' && text[at - 1] <= '9';  // 1'000
    const bool comment = c == '/' && at + 1 < size && (text[at + 1] == '/' || text[at + 1] == '*');
    if (comment) {
      at = text[at + 1] == '/' ? past("\n", 0) : past("*/", 2);
    } else if ((c == '"' || c == '\'') && !separator) {
      // A literal that is not closed ends with its line.
      for (++at; at < size && text[at] != c && text[at] != '\n'; ++at)
        if (text[at] == '\\' && at + 1 < size) ++at;
    } else {
      ++at;
      continue;
    }
    for (std::size_t i = comment ? first : first + 1; i < at; ++i) {
      if (text[i] == '\n') continue;
      code.bare[i] = ' ';
      if (comment) code.withLiterals[i] = ' ';
    }
    if (!comment) at = std::min(at + 1, size);
  }
  return code;
}

/// A call of a member function.
struct Call {
  std::string where, text;
  std::vector<std::string> arguments;
};

/// `text` on one line, truncated if long: for messages.
std::string shortenedCode(const std::string& text) {
  std::string line;
  for (const char c : text) {
    const bool blank = std::strchr(blanks, c) != nullptr;
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  constexpr std::size_t longest = 120;
  return plainText(line.size() > longest ? line.substr(0, longest) + "..." : line);
}

/// The call whose name is at [at, open), of a file; empty if its bracket at `open` is not closed soon.
std::optional<Call> callAt(const Code& code, std::size_t at, std::size_t open, const std::string& file) {
  constexpr std::size_t longest = 2000;  // [characters]
  Call call;
  std::size_t first = open + 1, depth = 0;
  for (std::size_t i = first; i < std::min(code.bare.size(), open + longest); ++i) {
    const char c = code.bare[i];
    const bool closes = c == ')' || c == ']' || c == '}';
    if (depth == 0 && (c == ',' || closes)) {
      call.arguments.push_back(trimmed(code.withLiterals.substr(first, i - first)));
      first = i + 1;
    }
    if (depth == 0 && closes) {
      if (c != ')') return {};
      const auto line = 1 + std::count(code.bare.begin(), code.bare.begin() + std::ptrdiff_t(at), '\n');
      call.where = fmt::format("{}:{}", file, line);
      call.text = shortenedCode(code.withLiterals.substr(at, i + 1 - at));
      return call;
    }
    if (c == '(' || c == '[' || c == '{') ++depth;
    if (closes) --depth;
  }
  return {};
}

/// The calls of a member function, or of one that is none, with this number of arguments; 0: any.
std::vector<Call> callsOf(const std::string& name, std::size_t arguments, const Code& code,
                          const std::string& file, bool ofMember = true) {
  std::vector<Call> calls;
  for (std::size_t at = code.bare.find(name); at != code.bare.npos; at = code.bare.find(name, at + 1)) {
    const std::size_t open = code.bare.find_first_not_of(blanks, at + name.size());
    const std::size_t before = at > 0 ? code.bare.find_last_not_of(blanks, at - 1) : code.bare.npos;
    if (open == code.bare.npos || code.bare[open] != '(' || before == code.bare.npos) continue;
    const bool arrow = before > 0 && code.bare.compare(before - 1, 2, "->") == 0;
    const char last = code.bare[at - 1];
    const bool isPartOfName = std::isalnum(static_cast<unsigned char>(last)) || last == '_';
    if (isPartOfName || ofMember != (code.bare[before] == '.' || arrow)) continue;
    std::optional<Call> call = callAt(code, at, open, file);
    if (call && (arguments == 0 || call->arguments.size() == arguments)) calls.push_back(std::move(*call));
  }
  return calls;
}

/// The contents of a string literal without backslashes; empty for anything else.
std::optional<std::string> literalString(const std::string& argument) {
  if (argument.size() < 2 || argument.front() != '"' || argument.back() != '"') return {};
  std::string inside = argument.substr(1, argument.size() - 2);
  if (inside.find_first_of("\"\\") != inside.npos) return {};
  return inside;
}

/// The value of a decimal literal with optional sign and suffix; empty for anything else.
std::optional<double> literalNumber(std::string argument) {
  if (argument.find_first_of("0123456789") == argument.npos) return {};
  while (std::strchr("fFlLuU", argument.back())) argument.pop_back();
  return toNumber(argument);
}

/// The direction in `Direction::Xpos`.
std::optional<std::string> directionIn(const std::string& argument) {
  const std::size_t scope = argument.rfind("::");
  const std::string last = scope == argument.npos ? argument : argument.substr(scope + 2);
  for (const char* name : {"Xneg", "Xpos", "Yneg", "Ypos", "Zneg", "Zpos"})
    if (last == name) return last;
  return {};
}

}  // namespace

void scanSource(const std::string& text, const std::string& file, CaseSource& source) {
  const Code code = codeOf(text);
  source.files.push_back(file);
  for (const Call& call : callsOf("setInitialMinimumDistanceFromSolid", 2, code, file))
    source.distances.push_back(
        {call.where, call.text, literalString(call.arguments[0]), literalNumber(call.arguments[1])});
  for (const Call& call : callsOf("setSystemPeriodicityLimit", 2, code, file))
    source.periodicity.push_back({literalNumber(call.arguments[0]), literalNumber(call.arguments[1])});
  for (const Call& call : callsOf("setSystemPeriodicity", 2, code, file))
    if (call.arguments[1] != "false") {
      const auto axis = literalNumber(call.arguments[0]);
      const bool known = axis && (*axis == 0.0 || *axis == 1.0 || *axis == 2.0);
      source.periodicAxes.push_back(
          {call.where, call.text, known ? std::optional(int(*axis)) : std::nullopt});
    }
  for (const Call& call : callsOf("defineDynamics", 0, code, file, false))  // (lattice, box, dynamics)
    if (call.arguments.size() > 2 && call.arguments[2].find("BounceBack") != std::string::npos)
      source.walls.push_back({call.where, call.text});
  for (const Call& call : callsOf("preInletFromSlice", 2, code, file))
    source.preInlets.push_back({call.where, call.text, directionIn(call.arguments[0]), {}});
  for (const Call& call : callsOf("autoPreinletFromBoundary", 1, code, file)) {
    PreInletCall& inlet = source.preInlets.emplace_back();
    inlet = {call.where, call.text, directionIn(call.arguments[0]), {}};
    // HemoCell takes the last plane but one, or the second.
    if (inlet.direction) inlet.slice = (*inlet.direction)[1] == 'p' ? -2 : 1;
  }
}

CaseSource readCaseSource(const fs::path& folder) {
  CaseSource source;
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (isSource(entry->path())) files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  constexpr std::uintmax_t largest = 1 << 20;  // [bytes]; handwritten files are smaller
  for (const fs::path& file : files) {
    std::error_code ignored;
    const std::string name = file.filename().string();
    if (fs::is_directory(file, ignored)) continue;
    if (fs::is_regular_file(file, ignored) && fs::file_size(file, ignored) > largest) {
      source.unread.push_back(fmt::format("{}: is larger than 1 MB and was not searched for calls", name));
      continue;
    }
    try {
      scanSource(contentOf(file, "a C++ file"), name, source);
    } catch (const InputError& failure) {
      source.unread.push_back(fmt::format("{}; it was not searched for calls", failure.what()));
    }
  }
  return source;
}

namespace {

/// Without white space between tags.
std::string printed(const tinyxml2::XMLDocument& document) {
  tinyxml2::XMLPrinter printer(nullptr, true);
  document.Print(&printer);
  return printer.CStr();
}

/// The words of the command line after the program; none where the system does not tell.
std::vector<std::string> commandLineWords() {
  std::ifstream in("/proc/self/cmdline");
  std::vector<std::string> words;
  for (std::string word; std::getline(in, word, '\0');) words.push_back(word);
  if (!words.empty()) words.erase(words.begin());
  return words;
}

}  // namespace

std::optional<fs::path> runningCaseFile(const tinyxml2::XMLDocument& document) {
  const std::string wanted = printed(document);
  std::vector<std::string> candidates = commandLineWords();
  candidates.push_back("config.xml");
  for (const fs::path candidate : candidates) {
    std::error_code ignored;
    constexpr std::uintmax_t most = 1 << 24;  // [bytes]; other files of the command line may be large
    if (!fs::is_regular_file(candidate, ignored) || fs::file_size(candidate, ignored) > most) continue;
    std::ostringstream text;
    text << std::ifstream(candidate).rdbuf();
    tinyxml2::XMLDocument other;
    if (other.Parse(text.str().c_str()) == tinyxml2::XML_SUCCESS && printed(other) == wanted)
      return candidate;
  }
  return {};
}

namespace {

using tinyxml2::XMLElement;

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

/// `<wallShearStress>`, a tag of packMesh beside HemoCell's: the largest stress that the case expects [Pa].
std::optional<double> wallShearStress(const XMLElement& domain, const fs::path& file) {
  if (!onlyChild(domain, "wallShearStress", file)) return {};
  return std::get<double>(required(domain, "wallShearStress", specs::number("", "Pa", 0, true, 1e6), file));
}

/// HemoCell: constantConversion.cpp.
void readThermalEnergy(const XMLElement& domain, const fs::path& file, Domain& result) {
  const XMLElement* element = onlyChild(domain, "kBT", file);
  if (!element) return;
  // From 7 K to 7,000 K: others are probably in a wrong unit.
  ValueSpec energy = specs::number("", "J; 4.1e-21 is that at 297 K", 1e-22, false, 1e-19);
  result.thermalEnergy = pnMicrometresPerJoule * std::get<double>(valueOf(*element, energy, file));
  result.thermalEnergyWhere = placeOf(*element, file);
}

Domain readDomain(const XMLElement& domain, const fs::path& file) {
  Domain result;
  readThermalEnergy(domain, file, result);
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
  result.wallShearStress = wallShearStress(domain, file);
  result.boxNodes = boxNodes(domain, file);
  if (!result.geometry && !result.boxNodes && domain.FirstChildElement("refDirN")) {
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
  const std::optional<ContainerRequest>& container = result.packing.container;
  if (!result.domain.geometry && !result.domain.boxNodes && !(container && container->nodes))
    throw InputError(
        fmt::format("{}: has neither <geometry> (with <refDir> and <refDirN>) nor <nx> <ny> <nz> nor "
                    "<Nx> <Ny> <Nz> nor <refDirN>: the lattice is unknown. <container><nodes> can give it",
                    placeOf(*domain, file)));
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
  if (const XMLElement* domain = root->FirstChildElement("domain")) {
    result.domain.wallShearStress = wallShearStress(*domain, result.file);
    readThermalEnergy(*domain, result.file, result.domain);
  }
  result.file = file.value_or("config.xml");
  return result;
}

}  // namespace packmesh::hemocell
