// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/realisation_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <optional>
#include <sstream>

#include "hemocell_adapter/base/value.h"

namespace packmesh::hemocell {
namespace {

constexpr const char* head =
    "realisation,seed,outcome,cells,hematocrit,minimum_gap_um,minimum_wall_gap_um,sweeps,cpu_s,wall_s";
constexpr std::size_t columns = 10;

const char* outcomeOf(const Realisation& row) {
  if (!row.written()) return "failed";
  return row.figures.complete ? "certified" : "bestEffort";
}

/// Empty if there is no such gap.
std::string gapField(double gap) {
  return std::isfinite(gap) ? fmt::format("{}", gap) : "";
}

std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',')
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

/// A row of our table; empty if it is none.
std::optional<Realisation> rowOf(const std::string& line) {
  const std::vector<std::string> fields = fieldsOf(line);
  if (fields.size() != columns) return {};
  const auto number = [&](std::size_t i) {
    return fields[i].empty() ? std::numeric_limits<double>::infinity()
                             : toNumber(fields[i]).value_or(std::nan(""));
  };
  const double i = number(0);
  if (!(i >= 1.0 && i < 1e15)) return {};
  Realisation row;
  row.number = std::int64_t(i);
  std::istringstream(fields[1]) >> row.seed;
  RealisationFigures& f = row.figures;
  f.complete = fields[2] == "certified";
  if (!f.complete && fields[2] != "bestEffort") {
    row.code = ExitCode::outOfReach;
    return row;
  }
  f.hematocrit = number(4);
  f.minimumGap = number(5);
  f.minimumWallGap = number(6);
  f.cpuSeconds = number(8);
  f.wallSeconds = number(9);
  const double cells = number(3), sweeps = number(7);
  for (const double x : {f.hematocrit, f.cpuSeconds, f.wallSeconds, cells, sweeps})
    if (!(x >= 0.0 && x < 1e18)) return {};
  f.cells = std::int64_t(cells);
  f.sweeps = std::int64_t(sweeps);
  return row;
}

/// A line of the table: name, and mean, standard deviation, least and largest of the finite values.
std::string lineOf(const char* name, const char* number, std::vector<double> values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double x) { return !std::isfinite(x); }),
               values.end());
  std::string line = fmt::format("  {:<28}", name);
  if (values.empty()) return line + fmt::format("{:>12}", "-");
  const double n = double(values.size()), mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0.0;
  for (const double x : values) squares += (x - mean) * (x - mean);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  for (const double x : {mean, n > 1.0 ? std::sqrt(squares / (n - 1.0)) : 0.0, *least, *most})
    line += fmt::format("{:>12}", fmt::format(fmt::runtime(number), x));
  return line;
}

}  // namespace

std::string realisationsText(const std::vector<Realisation>& rows) {
  std::string text = fmt::format("{}\n", head);
  for (const Realisation& row : rows) {
    const RealisationFigures& f = row.figures;
    text += fmt::format("{},{},{},", row.number, row.seed, outcomeOf(row));
    if (row.written())
      text += fmt::format("{},{},{},{},{},{:.3f},{:.3f}\n", f.cells, f.hematocrit, gapField(f.minimumGap),
                          gapField(f.minimumWallGap), f.sweeps, f.cpuSeconds, f.wallSeconds);
    else
      text += ",,,,,,\n";
  }
  return text;
}

std::vector<Realisation> readRealisations(const std::filesystem::path& file, std::int64_t first,
                                          std::uint64_t seed) {
  std::vector<Realisation> rows;
  if (first <= 1) return rows;
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line) || line != head) return rows;
  while (std::getline(in, line)) {
    const auto row = rowOf(line);
    if (row && row->number < first && row->seed == seed + std::uint64_t(row->number - 1))
      rows.push_back(*row);
  }
  return rows;
}

std::vector<std::string> realisationLines(const std::vector<Realisation>& rows) {
  std::vector<RealisationFigures> all;
  for (const Realisation& row : rows)
    if (row.written()) all.push_back(row.figures);
  if (all.size() < 2) return {};
  const auto values = [&](const auto& figure) {
    std::vector<double> of;
    for (const RealisationFigures& f : all) of.push_back(figure(f));
    return of;
  };
  return {fmt::format("{:<30}{:>12}{:>12}{:>12}{:>12}", fmt::format("Of {} realisations:", all.size()),
                      "mean", "std. dev.", "least", "largest"),
          lineOf("hematocrit of the lumen", "{:.5f}", values([](const auto& f) { return f.hematocrit; })),
          lineOf("minimum gap [µm]", "{:.5f}", values([](const auto& f) { return f.minimumGap; })),
          lineOf("minimum gap to the wall [µm]", "{:.5f}",
                 values([](const auto& f) { return f.minimumWallGap; })),
          lineOf("sweeps", "{:.1f}", values([](const auto& f) { return double(f.sweeps); })),
          lineOf("CPU time [s]", "{:.3f}", values([](const auto& f) { return f.cpuSeconds; }))};
}

}  // namespace packmesh::hemocell
