// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Plots as SVG, for reports.
#pragma once

#include <string>
#include <vector>

namespace packmesh::hemocell {

struct Curve {
  std::string name;   ///< in the legend; empty: not there
  std::string color;  ///< of CSS
  std::vector<double> x, y;
  std::vector<double> spread;  ///< a band of this half width around y; empty: none
  bool bars = false;           ///< columns around x instead of a line
};

/// A dashed vertical line and its label.
struct Mark {
  double x;
  std::string label;
};

struct Plot {
  std::string title, xLabel, yLabel;
  std::vector<Curve> curves;
  std::vector<Mark> marks;
};

/// An <svg> element that scales with its container. Axes begin at 0 or at the least x; all text is escaped.
std::string svgOf(const Plot& plot);

/// `text` escaped for HTML and XML.
std::string escaped(const std::string& text);

}  // namespace packmesh::hemocell
