// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/command_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"

namespace packmesh::hemocell {
namespace {

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
  explicit Parser(const std::vector<std::string>& words) : words_(words) {}

  CommandLine parse() {
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
    if (isCommand_) return result_;
    understandPositionals();
    for (std::size_t i = 0, r = 0; i < words_.size(); ++i) {
      while (r < restart_.size() && restart_[r].second <= i) ++r;
      if (r == restart_.size() || i < restart_[r].first) result_.words.push_back(words_[i]);
    }
    return result_;
  }

 private:
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
    Assignment assignment{&setting, {}, next_ - 1};
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
    result_.assignments.push_back(std::move(assignment));
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
      result_.section = *section;
      positionals_.erase(section);
    }
    const bool checkBox = result_.options().checkBox;
    const bool ownLumen = result_.options().container.has_value();
    if (positionals_.empty()) {
      if (ownLumen) return;
      result_.restartAlone = !restart_.empty() && !checkBox && result_.command == Command::pack;
      if (result_.restartAlone) return;
      if (checkBox) throw UsageError("check --box needs three sizes: check --box sX sY sZ");
      throw UsageError(result_.command == Command::check
                           ? "nothing to check: give a config.xml or --box sX sY sZ [µm]"
                           : "no container: give a config.xml or three sizes sX sY sZ [µm]");
    }
    refuseMisspelledCheck();
    if (positionals_.size() == 1 && !toNumber(positionals_.front()) && !checkBox) {
      result_.configFile = positionals_.front();
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
    if (ownLumen) throw UsageError("sizes sX sY sZ exclude --cylinder, --sphere and --vessel");
    result_.sizes = {positionals_[0], positionals_[1], positionals_[2]};
  }

  /// A word beside a file or sizes that is almost "check".
  void refuseMisspelledCheck() const {
    if (positionals_.size() < 2) return;
    for (const std::string& word : positionals_)
      if (result_.command != Command::check && nearestName(word, {"check"}))
        throw UsageError(fmt::format("unknown command '{}', did you mean 'check'?", word));
  }

  const std::vector<std::string>& words_;
  std::size_t next_ = 0;
  std::vector<std::string> positionals_;
  CommandLine result_;
  std::vector<std::pair<std::size_t, std::size_t>> restart_;  ///< words [first, second) of --restart
  bool isCommand_ = false;
};

bool given(const CommandLine& commandLine, const std::string& option) {
  return std::any_of(commandLine.assignments.begin(), commandLine.assignments.end(),
                     [&](const Assignment& a) { return option == a.setting->option; });
}

/// Rejects two descriptions of one cell, of which one would be ignored.
void refuseTwoShapes(const CommandLine& c) {
  std::map<std::string, std::string> described;  // name -> option
  for (const Assignment& a : c.assignments) {
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

/// Rejects options given twice. Those before word `from` can be overridden.
void refuseTwice(const CommandLine& c, std::size_t from) {
  std::map<std::pair<const Setting*, std::string>, const Assignment*> known;
  for (const Assignment& a : c.assignments) {
    const std::string option = a.setting->option;
    if (a.word < from || option == "export") continue;
    const auto [other, isNew] = known.try_emplace({a.setting, subjectOf(a)}, &a);
    if (isNew || other->second->values == a.values) continue;
    throw UsageError(
        fmt::format("option '--{}' is given twice{}, with different values", option,
                    other->first.second.empty() ? "" : fmt::format(" for '{}'", other->first.second)));
  }
}

/// Rejects options that contradict each other or the mode.
void checkCombination(const CommandLine& c) {
  refuseTwoShapes(c);
  for (const char* hematocrit : {"hematocrit", "discharge-hematocrit"}) {
    for (const char* other : {"rbc", "plt"}) {
      if (given(c, hematocrit) && given(c, other)) {
        throw UsageError(
            fmt::format("option '--{}' excludes '--{}': the hematocrit determines the number{}", hematocrit,
                        other, other == std::string("plt") ? ", and --plt_ratio that of platelets" : ""));
      }
    }
  }
  if (c.command == Command::check)
    for (const Assignment& a : c.assignments)
      if (a.setting->packingOnly)
        throw UsageError(fmt::format("option '--{}' is for packing, not for check", a.setting->option));
  if (given(c, "quiet") && given(c, "verbose")) throw UsageError("--quiet excludes --verbose");
  const char* lumen = nullptr;
  for (const char* option : {"cylinder", "sphere", "vessel"}) {
    if (!given(c, option)) continue;
    if (lumen) throw UsageError(fmt::format("--{} excludes --{}: there is only one lumen", lumen, option));
    lumen = option;
  }
  if (!c.configFile && given(c, "minimum-distance-from-solid")) {
    throw UsageError(
        "option '--minimum-distance-from-solid' requires a case: without a config.xml there are no solid "
        "nodes");
  }
  if (given(c, "box") && c.command != Command::check) {
    throw UsageError("option '--box' is for check; to pack a box, give only its sizes: sX sY sZ");
  }
  if (c.configFile) {
    for (const char* boxOnly : {"dx", "keep-all", "box"}) {
      if (given(c, boxOnly)) {
        throw UsageError(
            fmt::format("option '--{}' is for boxes; a case specifies this in config.xml", boxOnly));
      }
    }
  }
}

}  // namespace

Request CommandLine::options() const {
  return withOptions({}, *this);
}

Request withOptions(Request base, const CommandLine& commandLine) {
  for (const Assignment& assignment : commandLine.assignments)
    assignment.setting->apply(base, assignment.values);
  return base;
}

CommandLine parseCommandLine(const std::string& programName, const std::vector<std::string>& arguments,
                             std::size_t earlier) {
  const std::string program = std::filesystem::path(programName).filename().string();
  const bool asPackCells = program == "packCells";
  if (arguments.empty()) {
    throw UsageError("nothing to do: give a config.xml or three sizes sX sY sZ [µm]; see --help");
  }
  CommandLine result = Parser(arguments).parse();
  result.asPackCells = asPackCells;
  result.words.insert(result.words.begin(), program);
  checkCombination(result);
  if (!asPackCells) refuseTwice(result, earlier);
  return result;
}

}  // namespace packmesh::hemocell
