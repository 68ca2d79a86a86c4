// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/command_line.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/xml_tags.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/packing_section.h"
#include "hemocell_adapter/settings/request_json.h"
#include "hemocell_adapter/settings/value_specs.h"

namespace packmesh::hemocell {
namespace {

/// A section that is a word.
Request sectionIn(const std::string& word) {
  constexpr const char* where = "argument";
  tinyxml2::XMLDocument document;
  parseXml(document, word, where);
  const tinyxml2::XMLElement* const packing = document.RootElement();
  if (!packing || packing->Name() != std::string("packing"))
    throw InputError(fmt::format("{}: expected a section <packing>", where));
  Request section = readPackingSection(*packing, where);
  for (auto& [key, origin] : section.origins) origin.kind = Origin::Kind::argument;
  return section;
}

/// One option with its values, in the order of the command line.
struct Assignment {
  const Setting* setting = nullptr;
  std::vector<Value> values;
};
using Assignments = std::vector<Assignment>;

/// `base`, overridden by the options.
Request withOptions(Request base, const Assignments& options) {
  for (const Assignment& one : options) one.setting->apply(base, one.values, {Origin::Kind::option, ""});
  return base;
}

/// Sizes of a box. packCells reads them with atoi; under its name packMesh does the same, with a warning if
/// that matters.
Vec3 boxSizes(const std::vector<std::string>& texts, bool asPackCells, std::vector<std::string>& remarks) {
  const ValueSpec spec = specs::length("");
  Vec3 sizes;
  for (int k = 0; k < 3; ++k) {
    const std::string& text = texts[k];
    located<UsageError>(fmt::format("size s{}", "XYZ"[k]), [&] {
      sizes[k] = std::get<double>(parseValue(spec, text));
      const double truncated = std::atoi(text.c_str());
      if (!asPackCells || truncated == sizes[k]) return;
      const std::string notice = fmt::format(
          "size {} is read as {}, as packCells does; packMesh takes it as it is", text, truncated);
      if (!(truncated > 0)) throw InputError(notice);
      remarks.push_back(notice);
      sizes[k] = truncated;
    });
  }
  return sizes;
}

/// Possible meaning of a word after dashes.
struct Candidate {
  std::string name;
  bool packCells;
  const Setting* setting;  ///< nullptr: a command
  Command command;
};

std::vector<Candidate> allCandidates() {
  std::vector<Candidate> all;
  for (const Setting& setting : settingsTable()) {
    if (!setting.option.empty()) all.push_back({setting.option, setting.packCells, &setting, Command::pack});
  }
  all.insert(all.end(), {{"help", true, nullptr, Command::help},
                         {"version", false, nullptr, Command::version},
                         {"reference", false, nullptr, Command::reference},
                         {"print-config-reference", false, nullptr, Command::reference},
                         {"man", false, nullptr, Command::man},
                         {"completion", false, nullptr, Command::completion}});
  return all;
}

/// The option named by `word` (without dashes and value), in full or by a unique prefix.
Candidate resolve(const std::string& word, const std::string& asTyped) {
  const std::vector<Candidate> all = allCandidates();
  std::vector<Candidate> matches, packCellsMatches;
  for (const Candidate& candidate : all) {
    if (candidate.name == word) return candidate;
    if (candidate.name.compare(0, word.size(), word) != 0) continue;
    matches.push_back(candidate);
    if (candidate.packCells) packCellsMatches.push_back(candidate);
  }
  if (packCellsMatches.size() == 1) return packCellsMatches.front();
  if (matches.size() == 1) return matches.front();
  std::vector<std::string> names;
  if (!matches.empty()) {
    for (const Candidate& match : matches) names.push_back("--" + match.name);
    throw UsageError(fmt::format("option '{}' is ambiguous: {}", asTyped, alternatives(names)));
  }
  for (const Candidate& candidate : all) names.push_back(candidate.name);
  const auto nearest = nearestName(word, names);
  throw UsageError(fmt::format("unknown option '{}'{}", asTyped,
                               nearest ? fmt::format(", did you mean '--{}'?", *nearest) : "; see --help"));
}

std::string usage(const Setting& setting) {
  std::string text = fmt::format("--{}", setting.option);
  if (setting.isFlag()) return text;
  for (const ValueSpec& value : setting.values) text += fmt::format(" {}", value.placeholder);
  return text;
}

class Parser {
 public:
  Parser(const std::vector<std::string>& words, bool asPackCells) : words_(words) {
    result_.asPackCells = result_.request.packCellsConventions = asPackCells;
  }

  CommandLine parse() {
    readWords();
    if (isCommand_) return result_;
    result_.request = withOptions(std::move(result_.request), assignments_);
    understandPositionals();
    for (std::size_t i = 0, r = 0; i < words_.size(); ++i) {
      while (r < restart_.size() && restart_[r].second <= i) ++r;
      if (r == restart_.size() || i < restart_[r].first) result_.request.words.push_back(words_[i]);
    }
    return result_;
  }

  /// Of words without a container.
  Request options() {
    readWords();
    if (isCommand_ || !positionals_.empty())
      throw UsageError(fmt::format("expected options, found {}", fmt::join(words_, " ")));
    return withOptions({}, assignments_);
  }
  const Assignments& assignments() const { return assignments_; }

 private:
  void readWords() {
    bool optionsEnded = false;
    while (next_ < words_.size()) {
      const std::string& word = words_[next_++];
      if (!optionsEnded && word == "--") {
        optionsEnded = true;
      } else if (!optionsEnded && looksLikeOption(word)) {
        option(word);
      } else {
        positionals_.push_back(word);
      }
    }
  }

  /// "-" and negative numbers are not options.
  static bool looksLikeOption(const std::string& word) {
    return word.size() > 1 && word[0] == '-' && !toNumber(word).has_value();
  }

  void option(const std::string& word) {
    const bool twoDashes = word[1] == '-';
    std::string name = word.substr(twoDashes ? 2 : 1);
    std::optional<std::string> attached;
    if (const auto equals = name.find('='); equals != std::string::npos) {
      attached = name.substr(equals + 1);
      name.resize(equals);
    }
    if (!twoDashes && !name.empty()) {
      // -h 0.3, -h=0.3 and, if no option has this name, -h0.3.
      if (const Setting* setting = byLetter(name[0]); setting && (name.size() == 1 || !isPrefix(name))) {
        if (name.size() > 1 && setting->isFlag()) throw UsageError(fmt::format("unknown option '{}'", word));
        if (name.size() > 1 && !attached) attached = name.substr(1);
        assign(*setting, attached, word);
        return;
      }
    }
    const std::string typed = word.substr(0, word.find('='));
    const Candidate candidate = resolve(name, typed);
    if (candidate.setting) {
      const std::size_t begin = next_ - 1;
      assign(*candidate.setting, attached, typed);
      if (candidate.name == "restart") restart_.emplace_back(begin, next_);
    } else if (!isCommand_) {
      result_.command = candidate.command;
      isCommand_ = true;
    }
  }

  static const Setting* byLetter(char letter) {
    for (const Setting& setting : settingsTable()) {
      if (setting.letter == letter) return &setting;
    }
    return nullptr;
  }

  static bool isPrefix(const std::string& name) {
    const auto all = allCandidates();
    return std::any_of(all.begin(), all.end(),
                       [&](const Candidate& c) { return c.name.compare(0, name.size(), name) == 0; });
  }

  void assign(const Setting& setting, std::optional<std::string> attached, const std::string& typed) {
    Assignment assignment{&setting, {}};
    for (std::size_t i = 0; i < setting.values.size(); ++i) {
      std::string text;
      if (i == 0 && attached) {
        text = *attached;
      } else if (setting.isFlag()) {
        text = "true";
      } else if (next_ < words_.size() && !looksLikeOption(words_[next_])) {
        text = words_[next_++];
        if (setting.values[i].kind == Kind::numbers)
          while (next_ < words_.size() && toNumber(words_[next_])) text += " " + words_[next_++];
      } else {
        throw UsageError(fmt::format("option '{}' needs {} ({}); the {} is missing", typed,
                                     setting.values.size() == 1 ? "a value" : "more values", usage(setting),
                                     setting.values[i].placeholder));
      }
      const std::string which =
          setting.values.size() > 1 ? fmt::format(", {}", setting.values[i].placeholder) : "";
      assignment.values.push_back(located<UsageError>(fmt::format("option '--{}'{}", setting.option, which),
                                                      [&] { return parseValue(setting.values[i], text); }));
    }
    assignments_.push_back(std::move(assignment));
  }

  void understandPositionals() {
    const auto check = std::find(positionals_.begin(), positionals_.end(), "check");
    if (check != positionals_.end()) {
      result_.command = Command::check;
      positionals_.erase(check);
    }
    const auto section = std::find_if(positionals_.begin(), positionals_.end(),
                                      [](const std::string& word) { return word.rfind("<packing", 0) == 0; });
    if (section != positionals_.end()) {
      result_.request = overridden(sectionIn(*section), result_.request);
      positionals_.erase(section);
    }
    const bool checkBox = result_.request.checkBox;
    const bool ownLumen = result_.request.container && result_.request.container->lumen;
    if (positionals_.empty()) {
      if (ownLumen) return;
      if (!restart_.empty() && !checkBox && result_.command == Command::pack) return;
      if (checkBox) throw UsageError("check --box needs three sizes: check --box sX sY sZ");
      throw UsageError(result_.command == Command::check
                           ? "nothing to check: give a config.xml or --box sX sY sZ [µm]"
                           : "no container: give a config.xml or three sizes sX sY sZ [µm]");
    }
    refuseOtherCommands();
    if (positionals_.size() == 1 && !toNumber(positionals_.front()) && !checkBox) {
      result_.request.config = positionals_.front();
      result_.request.origins["config"] = {};
      return;
    }
    if (positionals_.size() != 3 && checkBox) {
      throw UsageError(fmt::format("check --box needs three sizes: check --box sX sY sZ; found '{}'",
                                   fmt::join(positionals_, " ")));
    }
    if (positionals_.size() != 3) {
      const bool numbers = std::all_of(positionals_.begin(), positionals_.end(),
                                       [](const std::string& word) { return toNumber(word).has_value(); });
      throw UsageError(fmt::format("expected a config.xml or three sizes sX sY sZ [µm], found {} {}{}: {}",
                                   positionals_.size(), numbers ? "size" : "word",
                                   positionals_.size() == 1 ? "" : "s", fmt::join(positionals_, " ")));
    }
    result_.request.boxSize = boxSizes(positionals_, result_.asPackCells, result_.request.remarks);
  }

  /// A word that is almost "check", or a command of packmesh.
  void refuseOtherCommands() const {
    std::error_code ignored;
    for (const std::string& word : positionals_)
      if (result_.command != Command::check && nearestName(word, {"check"}) &&
          !std::filesystem::exists(word, ignored))
        throw UsageError(fmt::format("unknown command '{}', did you mean 'check'?", word));
    const std::string& first = positionals_.front();
    const bool isWord = first.find_first_not_of("abcdefghijklmnopqrstuvwxyz-") == first.npos;
    if (isWord && !toNumber(first) && !std::filesystem::exists(first, ignored))
      throw UsageError(
          fmt::format("'{}' is no file, and packMesh has no such command; the other program, packmesh, may "
                      "have: packmesh {}",
                      first, fmt::join(positionals_, " ")));
  }

  const std::vector<std::string>& words_;
  std::size_t next_ = 0;
  std::vector<std::string> positionals_;
  Assignments assignments_;
  CommandLine result_;
  std::vector<std::pair<std::size_t, std::size_t>> restart_;  ///< words [first, second) of --restart
  bool isCommand_ = false;
};

bool isGiven(const Assignments& all, const std::string& option) {
  return std::any_of(all.begin(), all.end(),
                     [&](const Assignment& a) { return option == a.setting->option; });
}

/// Rejects two descriptions of one cell, of which one would be ignored.
void refuseTwoShapes(const Assignments& all) {
  std::map<std::string, std::string> described;  // name -> option
  for (const Assignment& a : all) {
    const std::string option = a.setting->option;
    if (option != "cell" && option != "cell-mesh") continue;
    const std::string& name = std::get<std::string>(a.values.front());
    const auto [by, isNew] = described.try_emplace(name, option);
    if (!isNew)
      throw UsageError(
          fmt::format("option '--{}': cell '{}' is already described by '--{}'", option, name, by->second));
  }
}

/// The subject of an option that can be given several times: a cell, a parameter, a file named after a cell.
std::string subjectOf(const Assignment& a) {
  const Kind kind = a.setting->values.front().kind;
  const bool several = a.setting->values.size() > 1 && (kind == Kind::name || kind == Kind::choice);
  if (!several && !a.setting->repeats) return "";
  if (const auto* number = std::get_if<std::int64_t>(&a.values.front())) return std::to_string(*number);
  const auto* text = std::get_if<std::string>(&a.values.front());
  if (!text) return "";
  return kind == Kind::text ? std::filesystem::path(*text).stem().string() : *text;
}

/// Rejects options given twice.
void refuseTwice(const Assignments& all) {
  std::map<std::pair<const Setting*, std::string>, const Assignment*> known;
  for (const Assignment& a : all) {
    const std::string option = a.setting->option;
    if (option == "export") continue;
    const auto [other, isNew] = known.try_emplace({a.setting, subjectOf(a)}, &a);
    if (isNew || other->second->values == a.values) continue;
    throw UsageError(
        fmt::format("option '--{}' is given twice{}, with different values", option,
                    other->first.second.empty() ? "" : fmt::format(" for '{}'", other->first.second)));
  }
}

/// Rejects options that contradict each other or the mode.
void checkCombination(const Assignments& all, Command command) {
  refuseTwoShapes(all);
  for (const char* hematocrit : {"hematocrit", "discharge-hematocrit"}) {
    for (const char* other : {"rbc", "plt"}) {
      if (isGiven(all, hematocrit) && isGiven(all, other)) {
        throw UsageError(
            fmt::format("option '--{}' excludes '--{}': the hematocrit determines the number{}", hematocrit,
                        other, other == std::string("plt") ? ", and --plt_ratio that of platelets" : ""));
      }
    }
  }
  if (command == Command::check)
    for (const Assignment& a : all)
      if (a.setting->packingOnly)
        throw UsageError(fmt::format("option '--{}' is for packing, not for check", a.setting->option));
  if (isGiven(all, "quiet") && isGiven(all, "verbose")) throw UsageError("--quiet excludes --verbose");
  const char* lumen = nullptr;
  for (const char* option : {"cylinder", "sphere", "vessel"}) {
    if (!isGiven(all, option)) continue;
    if (lumen) throw UsageError(fmt::format("--{} excludes --{}: there is only one lumen", lumen, option));
    lumen = option;
  }
  if (isGiven(all, "box") && command != Command::check) {
    throw UsageError("option '--box' is for check; to pack a box, give only its sizes: sX sY sZ");
  }
}

/// The words of a command, and the section for what has no option.
class Printer {
 public:
  explicit Printer(const Request& request) : packing_(document_.NewElement("packing")) {
    document_.InsertEndChild(packing_);
    words_.emplace_back(request.packCellsConventions ? "packCells" : "packMesh");
    Json json = toJson(request);
    json.erase("packCells");
    json.erase("restart");
    for (const auto& [key, value] : json.items()) {
      if (key == "config")
        words_.push_back(textOf(value)[0] == '-' ? "./" + textOf(value) : textOf(value));
      else if (key == "box")
        for (const Json& size : value) words_.push_back(textOf(size));
      else if (key == "container")
        container(value);
      else if (key == "regions")
        for (Json region : value) {
          const Json body = region["body"], species = region.value("species", Json::array());
          region.erase("body");
          region.erase("species");
          tinyxml2::XMLElement* const tag = addTag(*packing_, "region", region);
          addTag(*tag, body);
          for (const Json& one : species) addTag(*tag, "species", one);
        }
      else if (key == "species")
        species(value);
      else if (key == catTag)
        for (const auto& [name, parameter] : value.items()) option(catTag, {name, textOf(parameter)});
      else
        setting(key, value);
    }
  }

  std::vector<std::string> words() {
    if (packing_->NoChildren()) return words_;
    tinyxml2::XMLPrinter text(nullptr, true);
    document_.Print(&text);
    words_.emplace_back(text.CStr());
    return words_;
  }

 private:
  tinyxml2::XMLElement* addTag(tinyxml2::XMLElement& parent, const std::string& name,
                               const Json& attributes) {
    tinyxml2::XMLElement* const tag = document_.NewElement(name.c_str());
    parent.InsertEndChild(tag);
    for (const auto& [key, value] : attributes.items()) tag->SetAttribute(key.c_str(), textOf(value).c_str());
    return tag;
  }
  void addTag(tinyxml2::XMLElement& parent, Json body) {
    const std::string kind = textOf(body["kind"]);
    body.erase("kind");
    addTag(parent, kind, body);
  }

  void option(const std::string& name, std::vector<std::string> values) {
    if (!values.empty() && values[0][0] == '-') values = {"=" + values[0]};
    const bool attached = !values.empty() && values[0][0] == '=';
    words_.push_back("--" + name + (attached ? values[0] : ""));
    if (!attached) words_.insert(words_.end(), values.begin(), values.end());
  }

  /// By its option, a flag that states the value, or its tag.
  void setting(const std::string& key, const Json& value) {
    for (const Setting& row : settingsTable()) {
      if (row.option.empty() || row.key() != key) continue;
      if (!row.isWritten()) {
        Request stated;
        if (row.isFlag()) row.apply(stated, {true}, {});
        if (!row.isFlag() || toJson(stated)[key] != value) continue;
        return option(row.option, {});
      }
      if (row.isFlag() && value == true) return option(row.option, {});
      for (const Json& entry : row.repeats ? value : Json::array({value})) {
        std::vector<std::string> values;
        for (const Json& one : row.values.size() > 1 ? entry : Json::array({entry}))
          values.push_back(textOf(one));
        if (row.isFlag()) values[0] = "=" + values[0];
        option(row.option, values);
      }
      return;
    }
    addTag(*packing_, key, Json::object())->SetText(textOf(value).c_str());
  }

  void container(const Json& json) {
    const Json lumen = json.contains("lumen") ? json["lumen"] : Json::object();
    const std::string kind = lumen.contains("kind") ? textOf(lumen["kind"]) : "";
    const bool placed = lumen.contains("center") || lumen.value("offset", Json()) != Json({0.0, 0.0, 0.0});
    if (kind == "cylinder" && !lumen.contains("center"))
      option(kind, {textOf(lumen["axis"]), textOf(lumen["radius"]), textOf(lumen["length"])});
    else if (kind == "sphere" && !lumen.contains("center"))
      option(kind, {textOf(lumen["radius"])});
    else if (kind == "mesh" && !placed)
      option("vessel", {textOf(lumen["file"]), textOf(lumen["scale"])});
    else if (!kind.empty())
      addTag(*addTag(*packing_, "container", Json::object()), lumen);
    if (lumen.contains("openAxis") && (kind.empty() || !placed))
      option("open-axis", {textOf(lumen["openAxis"])});
    if (!json.contains("obstacles") && !json.contains("nodes")) return;
    tinyxml2::XMLElement* tag = packing_->FirstChildElement("container");
    if (!tag) tag = addTag(*packing_, "container", Json::object());
    if (json.contains("obstacles")) {
      tinyxml2::XMLElement* const obstacles = addTag(*tag, "obstacles", Json::object());
      for (const Json& body : json["obstacles"]) addTag(*obstacles, body);
    }
    if (json.contains("nodes")) addTag(*tag, "nodes", Json::object())->SetText(textOf(json["nodes"]).c_str());
  }

  /// Options come after the section: those at the end that are numbers alone. The order is that of the cells.
  void species(const Json& all) {
    const auto optionOf = [](const Json& one) -> const Setting* {
      const auto& table = settingsTable();
      const auto row = std::find_if(table.begin(), table.end(), [&](const Setting& s) {
        return !s.countOf.empty() && s.countOf == textOf(one["name"]);
      });
      return row != table.end() && one.size() == 2 && one.contains("count") ? &*row : nullptr;
    };
    std::size_t plain = all.size();
    while (plain > 0 && optionOf(all[plain - 1])) --plain;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (i < plain)
        addTag(*packing_, "species", all[i]);
      else
        option(optionOf(all[i])->option, {textOf(all[i]["count"])});
  }

  std::vector<std::string> words_;
  tinyxml2::XMLDocument document_;
  tinyxml2::XMLElement* packing_;
};

}  // namespace

std::vector<std::string> wordsOf(const Request& request) {
  return Printer(request).words();
}

CommandLine parseCommandLine(const std::string& programName, const std::vector<std::string>& arguments) {
  const std::string program = std::filesystem::path(programName).filename().string();
  const bool asPackCells = program == "packCells";
  if (arguments.empty()) {
    throw UsageError("nothing to do: give a config.xml or three sizes sX sY sZ [µm]; see --help");
  }
  Parser parser(arguments, asPackCells);
  CommandLine result = parser.parse();
  result.request.words.insert(result.request.words.begin(), program);
  checkCombination(parser.assignments(), result.command);
  if (!asPackCells) refuseTwice(parser.assignments());
  if (result.command == Command::pack || result.command == Command::check) requireConsistent(result.request);
  return result;
}

Request readOptions(const std::vector<std::string>& words) {
  Parser parser(words, false);
  Request request = parser.options();
  checkCombination(parser.assignments(), Command::pack);
  refuseTwice(parser.assignments());
  return request;
}

}  // namespace packmesh::hemocell
