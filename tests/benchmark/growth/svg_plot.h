// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Plots of a few lines as SVG files.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace packmesh::benchmark {

struct PlotLine {
  std::string name;
  std::vector<std::pair<double, double>> points;
};

/// Axes begin at 0 unless logarithmic. Pre: values positive on logarithmic axes
struct Plot {
  std::string title, xTitle, yTitle;
  bool logX = false, logY = false;
  std::vector<PlotLine> lines;

  void write(const std::filesystem::path& file) const {
    constexpr double width = 640.0, height = 420.0, left = 80.0, right = 20.0, top = 40.0, bottom = 55.0;
    double x0 = 0.0, x1 = 0.0, y0 = 0.0, y1 = 0.0;
    bool first = true;
    for (const PlotLine& line : lines)
      for (const auto& [x, y] : line.points) {
        x0 = logX ? (first ? x : std::min(x0, x)) : 0.0;
        y0 = logY ? (first ? y : std::min(y0, y)) : 0.0;
        x1 = first ? x : std::max(x1, x);
        y1 = first ? y : std::max(y1, y);
        first = false;
      }
    if (!logY) y1 *= 1.1;
    const auto scaled = [](double v, double lo, double hi, bool logarithmic) {
      return logarithmic ? std::log(v / lo) / std::max(std::log(hi / lo), 1e-9)
                         : (v - lo) / std::max(hi - lo, 1e-9);
    };
    const auto px = [&](double x) { return left + (width - left - right) * scaled(x, x0, x1, logX); };
    const auto py = [&](double y) {
      return height - bottom - (height - top - bottom) * scaled(y, y0, y1, logY);
    };
    std::ofstream out(file);
    out << fmt::format(
        "<svg xmlns='http://www.w3.org/2000/svg' width='{0}' height='{1}' font-family='sans-serif' "
        "font-size='13'>\n"
        "<rect width='{0}' height='{1}' fill='white'/>\n<text x='{2}' y='24' font-size='15'>{3}</text>\n",
        width, height, left, title);
    out << fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>\n", 0.5 * (left + width - right),
                       height - 12.0, xTitle);
    out << fmt::format("<text transform='translate(18 {}) rotate(-90)' text-anchor='middle'>{}</text>\n",
                       0.5 * (top + height - bottom), yTitle);
    const auto ticks = [](double lo, double hi, bool logarithmic) {
      std::vector<double> at;
      if (logarithmic) {
        for (double v = std::pow(2.0, std::ceil(std::log2(lo))); v <= hi * 1.0001; v *= 2.0) at.push_back(v);
      } else {
        double step = std::pow(10.0, std::floor(std::log10(hi - lo)));
        while ((hi - lo) / step < 4.0) step *= 0.5;
        for (int k = 0; lo + k * step <= hi * 1.0001; ++k) at.push_back(lo + k * step);
      }
      return at;
    };
    for (const double x : ticks(x0, x1, logX))
      out << fmt::format(
          "<path d='M{0:.1f} {1} V{2}' stroke='#ddd'/><text x='{0:.1f}' y='{3}' "
          "text-anchor='middle'>{4:.4g}</text>\n",
          px(x), top, height - bottom, height - bottom + 18.0, x);
    for (const double y : ticks(y0, y1, logY))
      out << fmt::format(
          "<path d='M{0} {1:.1f} H{2}' stroke='#ddd'/><text x='{3}' y='{4:.1f}' "
          "text-anchor='end'>{5:.4g}</text>\n",
          left, py(y), width - right, left - 6.0, py(y) + 4.0, y);
    static const char* colors[] = {"#b22222", "#1f5f9f", "#2e8b57", "#8a5a9f", "#d2691e", "#555555"};
    for (std::size_t i = 0; i < lines.size(); ++i) {
      std::string path, dots;
      const char* color = colors[i % 6];
      for (const auto& [x, y] : lines[i].points) {
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", px(x), py(y));
        dots += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>", px(x), py(y), color);
      }
      out << fmt::format("<path d='{}' fill='none' stroke='{}' stroke-width='1.6'/>{}\n", path, color, dots);
      out << fmt::format("<text x='{}' y='{}' fill='{}'>{}</text>\n", left + 12.0, top + 18.0 + 17.0 * i,
                         color, lines[i].name);
    }
    out << "</svg>\n";
  }
};

}  // namespace packmesh::benchmark
