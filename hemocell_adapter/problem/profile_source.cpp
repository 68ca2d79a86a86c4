// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/profile_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/problem/fahraeus.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
namespace {

constexpr double plateletsAtWall = 5.0;  ///< per concentration in the core

std::vector<std::string> wordsOf(std::string line) {
  line.resize(std::min(line.find('#'), line.size()));
  std::replace(line.begin(), line.end(), ',', ' ');
  std::istringstream text(line);
  std::vector<std::string> words;
  for (std::string word; text >> word;) words.push_back(word);
  return words;
}

/// Reads a table line by line. @throws InputError
class Reading {
 public:
  explicit Reading(const Source& file) : file_(file) {
    profile_.source = file.given ? "a table" : file.string();
  }

  ProfileSource operator()() {
    if (file_.given)
      readNumbers();
    else
      readLines();
    if (profile_.distance.empty())
      throw InputError(
          fmt::format("{}: expected a line such as 'distance RBC PLT' and rows of numbers", file_.string()));
    for (const ProfileSource::Column& column : profile_.columns)
      if (!(*std::max_element(column.value.begin(), column.value.end()) > 0.0))
        throw InputError(fmt::format("{}: the column '{}' has no value above 0: where are these cells to be?",
                                     file_.string(), column.species));
    return std::move(profile_);
  }

 private:
  void readLines() {
    std::istringstream lines(contentOf(file_.file, "a profile"));
    for (std::string line; std::getline(lines, line);) {
      ++line_;
      const std::vector<std::string> words = wordsOf(line);
      if (words.empty()) continue;
      if (profile_.columns.empty())
        head(words);
      else
        row(words);
    }
  }

  void readNumbers() {
    const std::vector<StateTable>& columns = file_.given->tables;
    std::vector<std::string> words;
    for (const StateTable& column : columns) words.push_back(column.name);
    if (words.empty()) return;
    head(words);
    for (std::size_t i = 0; i < columns[0].values.size(); ++i) {
      line_ = int(i) + 1;
      for (std::size_t c = 0; c < columns.size(); ++c) words[c] = fmt::format("{}", columns[c].values.at(i));
      row(words);
    }
  }

  [[noreturn]] void refuse(const std::string& reason) const {
    if (file_.given)
      throw InputError(file_.string() + (line_ > 0 ? fmt::format(": row {}", line_) : "") + ": " + reason);
    throw InputError(fmt::format("{}:{}: {}", file_.string(), line_, reason));
  }

  void head(const std::vector<std::string>& words) {
    if (words[0] != "distance" && words[0] != "fraction")
      refuse(
          fmt::format("expected 'distance' (from the wall, in µm) or 'fraction' (of the largest distance), "
                      "then names of cells; found '{}'",
                      words[0]));
    profile_.isFraction = words[0] == "fraction";
    for (std::size_t i = 1; i < words.size(); ++i) {
      if (!isCellName(words[i])) refuse(fmt::format("expected {}, found '{}'", expectedCellName(), words[i]));
      if (profile_.columnOf(words[i])) refuse(fmt::format("a second column '{}'", words[i]));
      profile_.columns.push_back({words[i], {}});
    }
    if (profile_.columns.empty()) refuse(fmt::format("names of cells are missing: {} RBC", words[0]));
  }

  void row(const std::vector<std::string>& words) {
    if (words.size() != profile_.columns.size() + 1)
      refuse(fmt::format("expected {} numbers, found {}", profile_.columns.size() + 1, words.size()));
    for (std::size_t i = 0; i < words.size(); ++i) {
      const std::optional<double> number = toNumber(words[i]);
      constexpr double largest = 1e6;
      if (!number || !(*number >= 0.0 && *number <= largest))
        refuse(fmt::format("expected a number in [0, {:g}], found '{}'", largest, words[i]));
      if (i > 0) profile_.columns[i - 1].value.push_back(*number);
      if (i > 0) continue;
      if (profile_.isFraction && *number > 1.0)
        refuse(fmt::format("expected a fraction in [0, 1], found '{}'", words[i]));
      if (!profile_.distance.empty() && *number <= profile_.distance.back())
        refuse(fmt::format("the distances must increase; found {} after {:.15g}", words[i],
                           profile_.distance.back()));
      profile_.distance.push_back(*number);
    }
  }

  const Source& file_;
  int line_ = 0;
  ProfileSource profile_;
};

}  // namespace

double ProfileSource::at(const Column& column, double x) const {
  const std::size_t above = std::upper_bound(distance.begin(), distance.end(), x) - distance.begin();
  if (above == 0) return column.value.front();
  if (above == distance.size()) return column.value.back();
  const double t = (x - distance[above - 1]) / (distance[above] - distance[above - 1]);
  return column.value[above - 1] + t * (column.value[above] - column.value[above - 1]);
}

const ProfileSource::Column* ProfileSource::columnOf(const std::string& species) const {
  for (const Column& column : columns)
    if (column.species == species) return &column;
  return nullptr;
}

ProfileSource readProfile(const Source& source) {
  return Reading(source)();
}

ProfileSource developedFlow(double tubeHematocrit, double diameter, const std::vector<std::string>& redCells,
                            const std::vector<std::string>& platelets) {
  const double layer = freeLayerOf(tubeHematocrit, diameter);
  ProfileSource profile;
  profile.source = fmt::format(
      "developed flow: cell-free layer {:.3g} µm by the Fåhraeus effect (Pries 1990, Sutera "
      "1970) in {:.4g} µm at hematocrit {:.3g}, platelets {:g} times as concentrated there",
      layer, diameter, tubeHematocrit, plateletsAtWall);
  profile.distance = {0.0, 0.5 * layer, layer, 1.5 * layer, 2.0 * layer};
  for (const std::string& name : redCells) profile.columns.push_back({name, {0.0, 0.0, 0.5, 1.0, 1.0}});
  constexpr double between = 0.5 * (1.0 + plateletsAtWall);
  for (const std::string& name : platelets)
    profile.columns.push_back({name, {plateletsAtWall, plateletsAtWall, plateletsAtWall, between, 1.0}});
  return profile;
}

}  // namespace packmesh::hemocell
