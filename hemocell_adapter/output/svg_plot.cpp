// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace packmesh::hemocell {
namespace {

constexpr double width = 560, height = 300, left = 64, right = 16, top = 40, bottom = 52;  // [px]

/// A range and the positions of its tick marks.
struct Axis {
  double low, high, step;

  Axis(double least, double most, int ticks) : low(least), high(most > least ? most : least + 1.0) {
    const double rough = (high - low) / ticks, power = std::pow(10.0, std::floor(std::log10(rough)));
    step = 10.0 * power;
    for (const double nice : {1.0, 2.0, 5.0})
      if (nice * power >= rough * 0.999) {
        step = nice * power;
        break;
      }
  }
  void roundUp() { high = step * std::ceil(high / step - 1e-9); }  // up to rounding
  std::vector<double> ticks() const {
    std::vector<double> at;
    // Up to rounding.
    for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) at.push_back(i * step);
    return at;
  }
  double part(double v) const { return (v - low) / (high - low); }
};

std::string label(double v, double step) {
  // A rounding error near zero is zero.
  return std::abs(v) < 1e-9 * step ? "0" : fmt::format("{:.6g}", v);
}

class Drawing {
 public:
  explicit Drawing(const Plot& plot) : plot_(plot), x_(rangeX()), y_(rangeY()) { y_.roundUp(); }

  std::string operator()() {
    out_ = fmt::format(
        "<svg class=\"plot\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n<text x=\"{}\" y=\"20\" "
        "class=\"title\">{}</text>\n",
        width, height, escaped(plot_.title), left, escaped(plot_.title));
    grid();
    for (const Curve& curve : plot_.curves) curve.bars ? bars(curve) : line(curve);
    for (const Mark& mark : plot_.marks) markAt(mark);
    legend();
    return out_ + "</svg>\n";
  }

 private:
  Axis rangeX() const {
    double least = INFINITY, most = -INFINITY;
    for (const Curve& c : plot_.curves)
      for (std::size_t i = 0; i < c.x.size(); ++i) {
        const double half = c.bars && c.x.size() > 1 ? 0.5 * (c.x[1] - c.x[0]) : 0.0;
        least = std::min(least, c.x[i] - half);
        most = std::max(most, c.x[i] + half);
      }
    if (!(least <= most)) return {0.0, 1.0, 6};
    // From 0 if that is near; rounding must not leave a thin interval below it.
    if (least > 0.0 && least < 0.1 * most) least = 0.0;
    return {least, most, 6};
  }
  Axis rangeY() const {
    double most = 0.0;
    for (const Curve& c : plot_.curves)
      for (const double y : c.y) most = std::max(most, y);
    return {0.0, 1.04 * most, 5};
  }

  double atX(double v) const { return left + (width - left - right) * x_.part(v); }
  double atY(double v) const {
    return height - bottom - (height - top - bottom) * std::clamp(y_.part(v), 0.0, 1.0);
  }

  void grid() {
    for (const double v : y_.ticks()) {
      out_ += fmt::format(
          "<path class=\"grid\" d=\"M{} {:.1f}H{}\"/><text class=\"tick\" x=\"{}\" y=\"{:.1f}\" "
          "text-anchor=\"end\">{}</text>\n",
          left, atY(v), width - right, left - 8, atY(v) + 4, label(v, y_.step));
    }
    for (const double v : x_.ticks()) {
      out_ += fmt::format(
          "<path class=\"axis\" d=\"M{:.1f} {}v5\"/><text class=\"tick\" x=\"{:.1f}\" y=\"{}\" "
          "text-anchor=\"middle\">{}</text>\n",
          atX(v), height - bottom, atX(v), height - bottom + 19, label(v, x_.step));
    }
    out_ += fmt::format("<path class=\"axis\" d=\"M{} {}H{}\"/>\n", left, height - bottom, width - right);
    out_ += fmt::format("<text class=\"name\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                        0.5 * (left + width - right), height - 10, escaped(plot_.xLabel));
    out_ += fmt::format(
        "<text class=\"name\" transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
        0.5 * (top + height - bottom), escaped(plot_.yLabel));
  }

  void line(const Curve& c) {
    if (!c.spread.empty()) {
      std::string upper, lower;
      for (std::size_t i = 0; i < c.x.size(); ++i) {
        upper += fmt::format("{}{:.1f} {:.1f}", i ? "L" : "M", atX(c.x[i]), atY(c.y[i] + c.spread[i]));
        lower.insert(0, fmt::format("L{:.1f} {:.1f}", atX(c.x[i]), atY(c.y[i] - c.spread[i])));
      }
      out_ += fmt::format("<path d=\"{}{}Z\" fill=\"{}\" opacity=\"0.18\"/>\n", upper, lower, c.color);
    }
    std::string path;
    for (std::size_t i = 0; i < c.x.size(); ++i)
      path += fmt::format("{}{:.1f} {:.1f}", i ? "L" : "M", atX(c.x[i]), atY(c.y[i]));
    out_ += fmt::format("<path class=\"curve\" d=\"{}\" stroke=\"{}\"/>\n", path, c.color);
  }

  void bars(const Curve& c) {
    if (c.x.size() < 2) return;
    const double half = 0.5 * (c.x[1] - c.x[0]);
    std::string path;
    for (std::size_t i = 0; i < c.x.size(); ++i) {
      const double from = atX(c.x[i] - half), to = atX(c.x[i] + half), y = atY(c.y[i]);
      if (c.y[i] > 0.0)
        path += fmt::format("M{:.1f} {:.1f}H{:.1f}V{:.1f}H{:.1f}Z", from, y, to, atY(0.0), from);
    }
    out_ +=
        fmt::format("<path d=\"{}\" fill=\"{}\" fill-opacity=\"0.45\" stroke=\"{}\" stroke-width=\"0.8\"/>\n",
                    path, c.color, c.color);
  }

  void markAt(const Mark& mark) {
    if (mark.x < x_.low || mark.x > x_.high) return;
    const double x = atX(mark.x);
    const bool leftOf = x > 0.6 * width;
    out_ += fmt::format(
        "<path class=\"mark\" d=\"M{:.1f} {}V{}\"/><text class=\"tick\" x=\"{:.1f}\" y=\"{}\" "
        "text-anchor=\"{}\">{}</text>\n",
        x, top, height - bottom, x + (leftOf ? -6 : 6), top + 12, leftOf ? "end" : "start",
        escaped(mark.label));
  }

  void legend() {
    double x = width - right;
    for (auto c = plot_.curves.rbegin(); c != plot_.curves.rend(); ++c) {
      if (c->name.empty()) continue;
      x -= 7.0 * double(c->name.size()) + 4;
      out_ += fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"20\">{}</text>", x, escaped(c->name));
      x -= 16;
      out_ += fmt::format("<rect x=\"{:.1f}\" y=\"11\" width=\"11\" height=\"11\" rx=\"2\" fill=\"{}\"/>\n",
                          x, c->color);
      x -= 14;
    }
  }

  const Plot& plot_;
  Axis x_, y_;
  std::string out_;
};

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string svgOf(const Plot& plot) {
  return Drawing(plot)();
}

}  // namespace packmesh::hemocell
