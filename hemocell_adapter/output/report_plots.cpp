// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/report_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace packmesh::hemocell {
namespace {

using Json = nlohmann::ordered_json;

std::string colorOf(const std::string& name, std::size_t species) {
  constexpr std::array<const char*, 6> palette = {"#1f5fa8", "#2f855a", "#7b4397",
                                                  "#d9730d", "#12848c", "#a0516b"};
  for (const auto& [prefix, color] :
       {std::pair{"RBC", "#b3261e"}, {"vRBC", "#b3261e"}, {"PLT", "#d69e00"}, {"WBC", "#64748b"}})
    if (name.rfind(prefix, 0) == 0) return color;
  return palette[species % palette.size()];
}

std::vector<double> middles(double begin, double width, std::size_t count) {
  std::vector<double> x;
  for (std::size_t i = 0; i < count; ++i) x.push_back(begin + (double(i) + 0.5) * width);
  return x;
}

bool anyIn(const std::vector<double>& values) {
  for (const double v : values)
    if (v != 0.0) return true;
  return false;
}

Plot wallPlot(const Json& wall) {
  Plot plot{"Volume fraction over the distance to the wall",
            "distance to the wall [µm]",
            "volume fraction",
            {},
            {}};
  std::size_t s = 0;
  for (const Json& species : wall["species"]) {
    Curve curve{species["name"], colorOf(species["name"], s++), {}, species["fraction"], species["error"]};
    curve.x = middles(wall["begin"], wall["width"], curve.y.size());
    if (anyIn(curve.y)) plot.curves.push_back(std::move(curve));
  }
  const Json& layer = wall["cellFreeLayer"][0];
  if (!layer["thickness"].is_null())
    plot.marks.push_back(
        {layer["thickness"], fmt::format("cell-free layer {:.2f} µm", layer["thickness"].get<double>())});
  return plot;
}

Plot axialPlot(const Json& axial) {
  Plot plot{"Hematocrit along the axes", "position [µm]", "hematocrit of the slice", {}, {}};
  constexpr std::array<const char*, 3> colors = {"#b3261e", "#2f855a", "#1f5fa8"};
  std::size_t k = 0;
  for (const auto& [axis, profile] : axial.items()) {
    Curve curve{axis, colors[k++], {}, profile["red"], {}};
    curve.x = middles(profile["begin"], profile["width"], curve.y.size());
    plot.curves.push_back(std::move(curve));
  }
  return plot;
}

Plot gapPlot(const Json& gaps) {
  Plot plot{"Gap to the nearest other cell", "gap [µm]", "share of the cells", {}, {}};
  std::size_t s = 0;
  for (const Json& species : gaps) {
    const std::string color = colorOf(species["name"], s++);
    Curve curve{species["name"], color, {}, species["counts"], {}, true};
    double cells = species["beyond"];
    for (const double n : curve.y) cells += n;
    if (cells == 0.0) continue;
    for (double& n : curve.y) n /= cells;
    curve.x = middles(0.0, species["width"], curve.y.size());
    plot.curves.push_back(std::move(curve));
  }
  // Up to the value below which most of them lie.
  std::size_t shown = 10;
  for (const Curve& curve : plot.curves)
    for (std::size_t i = 0; i < curve.y.size(); ++i)
      if (curve.y[i] >= 0.01) shown = std::max(shown, i + 2);
  for (Curve& curve : plot.curves) {
    curve.x.resize(std::min(shown, curve.x.size()));
    curve.y.resize(curve.x.size());
  }
  return plot;
}

/// Of the species with the most cells.
Plot orientationPlot(const Json& orientation) {
  const Json* most = &orientation[0];
  for (const Json& species : orientation)
    if (species["cells"] > (*most)["cells"]) most = &species;
  const std::string name = (*most)["name"];
  Plot plot{name + ": direction of the symmetry axis n",
            "|cosine| between n and an axis",
            "density (1: no order)",
            {},
            {}};
  constexpr std::array<const char*, 3> colors = {"#b3261e", "#2f855a", "#1f5fa8"};
  for (std::size_t k = 0; k < 3; ++k) {
    Curve curve{std::string(1, "xyz"[k]), colors[k], middles(0.0, 0.1, 10), (*most)["cosines"][k], {}};
    for (double& n : curve.y) n *= 10.0 / std::max(1.0, (*most)["cells"].get<double>());
    plot.curves.push_back(std::move(curve));
  }
  return plot;
}

}  // namespace

std::vector<Plot> plotsOf(const Json& report) {
  const Json& measures = report["measures"];
  std::vector<Plot> plots;
  if (!measures["wall"].is_null()) plots.push_back(wallPlot(measures["wall"]));
  plots.push_back(axialPlot(measures["axial"]));
  plots.push_back(gapPlot(measures["gaps"]));
  plots.push_back(orientationPlot(measures["orientation"]));
  return plots;
}

}  // namespace packmesh::hemocell
