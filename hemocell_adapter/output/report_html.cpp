// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/report_html.h"
#include "hemocell_adapter/base/duration.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "hemocell_adapter/output/report_plots.h"

namespace packmesh::hemocell {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* style = R"(
:root { color-scheme: light; --ink: #1d2733; --soft: #5b6878; --line: #dde3ea; --red: #b3261e; }
* { box-sizing: border-box; }
body { margin: 0; background: #f3f5f8; color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", "DejaVu Sans", sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 28px 20px 48px; }
h1 { font-size: 26px; line-height: 1.25; margin: 0 0 4px; } h2 { font-size: 17px; margin: 0 0 12px; }
.sub { color: var(--soft); margin: 0 0 20px; overflow-wrap: anywhere; }
.card { background: #fff; border: 1px solid var(--line); border-radius: 10px; padding: 18px 20px; margin: 0 0 18px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(170px, 1fr)); gap: 14px; margin: 0 0 18px; }
.tile { background: #fff; border: 1px solid var(--line); border-radius: 10px; padding: 12px 16px; }
.tile b { display: block; font-size: 24px; line-height: 1.3; font-weight: 600; } .tile span { color: var(--soft); font-size: 13px; }
.good b { color: #1c7c43; } .bad b { color: var(--red); }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(430px, 1fr)); gap: 18px; margin: 0 0 18px; }
.plots .card { margin: 0; padding: 12px 14px; }
img.view { display: block; width: 100%; max-width: 1000px; margin: 0 auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th { text-align: left; color: var(--soft); font-weight: 500; font-size: 13px; }
th, td { padding: 5px 14px 5px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
tr:last-child td { border-bottom: 0; } td.n, th.n { text-align: right; } .scroll { overflow-x: auto; }
pre { background: #f3f5f8; border-radius: 6px; padding: 10px 12px; margin: 0; white-space: pre-wrap; overflow-wrap: anywhere; font-size: 13px; }
.note { color: var(--soft); font-size: 13px; margin: 10px 0 0; }
.settings { columns: 3 300px; column-gap: 32px; margin: 0; } .settings div { break-inside: avoid; display: flex; justify-content: space-between;
  gap: 12px; border-bottom: 1px solid var(--line); padding: 3px 0; font-size: 13.5px; }
.settings dt { color: var(--soft); } .settings dd { margin: 0; text-align: right; overflow-wrap: anywhere; }
svg.plot { display: block; width: 100%; height: auto; font-size: 12px; }
.plot .title { font-size: 14px; font-weight: 600; fill: #1d2733; } .plot .tick, .plot .name { fill: #5b6878; }
.plot .grid { stroke: #e6eaf0; } .plot .axis { stroke: #8793a3; fill: none; } .plot .mark { stroke: #1d2733; stroke-dasharray: 4 3; }
.plot .curve { fill: none; stroke-width: 1.8; stroke-linejoin: round; }
@media print { body { background: #fff; } .card, .tile { break-inside: avoid; } }
)";

std::string base64(const std::string& bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(bytes.size() / 3 * 4 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) {
      return k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0u;
    };
    const unsigned three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (int k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[three >> (18 - 6 * k) & 63];
  }
  return out;
}

/// Quoted so that a shell takes it as one word.
std::string quoted(const std::string& word) {
  const bool plain = !word.empty() && word.find_first_not_of(
                                          "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                          "0123456789_-+=.,:/@%") == std::string::npos;
  if (plain) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// For readers: no quotes around text, few digits.
std::string shown(const Json& value, int digits = 6) {
  if (value.is_null()) return "–";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.{}g}", value.get<double>(), digits);
  if (value.is_array()) {
    std::string text;
    for (const Json& one : value) text += (text.empty() ? "" : " ") + shown(one, digits);
    return text;
  }
  if (value.is_object()) {
    std::string text;
    for (const auto& [key, one] : value.items())
      if (!one.is_null()) text += (text.empty() ? "" : ", ") + key + " " + shown(one, digits);
    return text;
  }
  return value.dump();
}

std::string gap(const Json& value, const Json& most) {
  return value.is_null() ? "more than " + shown(most) + " µm" : fmt::format("{:.4f} µm", value.get<double>());
}

class Table {
 public:
  /// @param heads those that begin with '#' denote numeric columns
  explicit Table(const std::vector<const char*>& heads) {
    for (const std::string head : heads) {
      numbers_.push_back(head[0] == '#');
      out_ += fmt::format("<th{}>{}</th>", numbers_.back() ? " class=\"n\"" : "",
                          escaped(head.substr(numbers_.back() ? 1 : 0)));
    }
    out_ = "<div class=\"scroll\"><table><tr>" + out_ + "</tr>\n";
  }
  void row(const std::vector<std::string>& cells) {
    out_ += "<tr>";
    for (std::size_t i = 0; i < cells.size(); ++i)
      out_ += fmt::format("<td{}>{}</td>", numbers_[i] ? " class=\"n\"" : "", escaped(cells[i]));
    out_ += "</tr>\n";
  }
  std::string str() const { return out_ + "</table></div>\n"; }

 private:
  std::vector<bool> numbers_;
  std::string out_;
};

std::string tile(const std::string& value, const std::string& what, const char* kind = "") {
  return fmt::format("<div class=\"tile {}\"><b>{}</b><span>{}</span></div>\n", kind, escaped(value),
                     escaped(what));
}

std::string card(const std::string& title, const std::string& body) {
  return fmt::format("<section class=\"card\"><h2>{}</h2>\n{}</section>\n", escaped(title), body);
}

std::string note(const std::string& text) {
  return "<p class=\"note\">" + escaped(text) + "</p>\n";
}

class Page {
 public:
  explicit Page(const Json& report) : r_(report) {}

  std::string operator()(const Picture& picture) const {
    const std::string title = "Packing of a " + shown(r_["lumen"]["description"]);
    std::string out = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
        "content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n<style>{1}</style>\n</head>\n"
        "<body>\n<main>\n<h1>{0}</h1>\n",
        escaped(title), style);
    out += fmt::format("<p class=\"sub\">packMesh {} ({}){}</p>\n", escaped(shown(r_["program"]["version"])),
                       escaped(shown(r_["program"]["commit"])), escaped(caseText()));
    out += tiles() + pictureCard(picture) + plots();
    out += card("Cells", species()) + card("Hematocrit", hematocrit()) + card("Certificate", certificate());
    out += card("Gaps and orientation", order());
    out += card("Settings", settings());
    out += card("To reproduce", command());
    return out + "</main>\n</body>\n</html>\n";
  }

 private:
  std::string caseText() const {
    const Json& config = r_["configuration"]["config"];
    return (config.is_null() ? "" : ", case " + shown(config)) + ", seed " +
           shown(r_["configuration"]["seed"]);
  }

  std::string tiles() const {
    std::int64_t cells = 0, asked = 0;
    for (const Json& one : r_["species"]) {
      cells += one["placed"].get<std::int64_t>();
      asked += one["asked"].get<std::int64_t>();
    }
    const Json& certificate = r_["certificate"];
    const bool clean = certificate["clean"];
    std::string out = "<div class=\"tiles\">\n";
    out +=
        tile(fmt::format("{:.4f}", r_["hematocrit"][0]["ofLumen"].get<double>()), "hematocrit of the lumen");
    out +=
        tile(std::to_string(cells), cells < asked ? fmt::format("cells, of {} requested", asked) : "cells");
    out += tile(clean ? "clean" : "NOT CLEAN", "certificate: no overlap, all inside", clean ? "good" : "bad");
    out += tile(gap(certificate["minimumGap"], certificate["gapsMeasuredUpTo"]), "smallest gap");
    if (!r_["measures"]["wall"].is_null()) {
      const Json& layer = r_["measures"]["wall"]["cellFreeLayer"][0]["thickness"];
      if (!layer.is_null()) out += tile(fmt::format("{:.2f} µm", layer.get<double>()), "cell-free layer");
    }
    if (!r_["hemocell"].is_null())
      out += tile(shown(r_["hemocell"]["kept"]), "cells that HemoCell keeps",
                  r_["hemocell"]["dropped"] == 0 ? "good" : "");
    return out + "</div>\n";
  }

  static std::string pictureCard(const Picture& picture) {
    if (picture.png.empty()) return card("Picture", note(picture.note));
    return "<section class=\"card\"><img class=\"view\" alt=\"The packed cells in their lumen\" "
           "src=\"data:image/png;base64," +
           base64(picture.png) + "\"></section>\n";
  }

  std::string plots() const {
    std::string out = "<div class=\"plots\">\n";
    for (const Plot& plot : plotsOf(r_)) out += "<section class=\"card\">" + svgOf(plot) + "</section>\n";
    return out + "</div>\n";
  }

  std::string species() const {
    Table table({"cell", "origin", "#requested", "#placed", "specified as", "#mesh volume [µm³]", "#vertices",
                 "#volume fraction", "#HemoCell keeps"});
    for (const Json& one : r_["species"])
      table.row({shown(one["name"]), shown(one["origin"]), shown(one["asked"]), shown(one["placed"]),
                 shown(one["request"]), shown(one["meshVolume"], 4), shown(one["vertices"]),
                 fmt::format("{:.5f}", one["volumeFraction"].get<double>()), shown(one["keptByHemoCell"])});
    const Json& lumen = r_["lumen"];
    std::string text = "Lumen: " + shown(lumen["description"]) + ", " + shown(lumen["volume"]) + " µm³";
    if (!shown(lumen["note"]).empty()) text += "; " + shown(lumen["note"]);
    if (const Json& lattice = lumen["lattice"]; !lattice.is_null())
      text += fmt::format("; {} fluid nodes at dx {} µm: {} µm³", shown(lattice["fluidNodes"]),
                          shown(lattice["dx"]), shown(lattice["fluidVolume"]));
    return table.str() + note(text);
  }

  std::string hematocrit() const {
    const bool fluid = !r_["lumen"]["lattice"].is_null();
    Table table(fluid
                    ? std::vector<const char*>{"red cells counted by", "#of the lumen", "#of the fluid nodes"}
                    : std::vector<const char*>{"red cells counted by", "#of the lumen"});
    for (const Json& one : r_["hematocrit"]) {
      std::vector<std::string> row = {shown(one["text"]),
                                      fmt::format("{:.4f}", one["ofLumen"].get<double>())};
      if (fluid) row.push_back(fmt::format("{:.4f}", one["ofFluidNodes"].get<double>()));
      table.row(row);
    }
    return table.str();
  }

  std::string certificate() const {
    const Json& c = r_["certificate"];
    Table table({"", ""});
    table.row({"verdict",
               c["clean"] ? "clean: no two meshes share a point, all are inside the lumen" : "NOT CLEAN"});
    table.row({"cells examined", shown(c["cells"])});
    table.row({"pairs proved apart", shown(c["pairs"])});
    table.row({"smallest gap between cells", gap(c["minimumGap"], c["gapsMeasuredUpTo"])});
    if (r_["lumen"]["wall"])
      table.row({"smallest gap to the wall", gap(c["minimumWallGap"], c["gapsMeasuredUpTo"])});
    if (const Json& kept = r_["hemocell"]; !kept.is_null()) {
      table.row(
          {"HemoCell keeps", fmt::format("{} cells, drops {}", shown(kept["kept"]), shown(kept["dropped"]))});
      for (const Json& one : kept["reasons"])
        table.row({"dropped by HemoCell", shown(one["cells"]) + ": " + shown(one["reason"])});
    }
    return table.str() +
           note(
               "Decided by exact arithmetic on the meshes that HemoCell builds, at the positions in the .pos "
               "files.");
  }

  std::string order() const {
    Table table({"cell", "#smallest gap [µm]", "#median [µm]", "#mean [µm]", "#farther than 1 µm", "#order S",
                 "#eigenvalues of the order tensor", "#director"});
    for (std::size_t s = 0; s < r_["species"].size(); ++s) {
      const Json &gaps = r_["measures"]["gaps"][s], &order = r_["measures"]["orientation"][s];
      table.row({shown(gaps["name"]), shown(gaps["minimum"], 3), shown(gaps["median"], 3),
                 shown(gaps["mean"], 3), shown(gaps["beyond"]), shown(order["nematic"], 3),
                 shown(order["eigenvalues"], 2), shown(order["director"], 2)});
    }
    return table.str() + note(
                             "Gaps: smallest distance of each cell, from sample points on one membrane to "
                             "the smooth surface of "
                             "the other; up to some hundredths of a micrometre larger than the exact gap in "
                             "the certificate. "
                             "Order of the symmetry axes: S = 1 if all are parallel, about 1/√cells if "
                             "random. Bands of the "
                             "profiles: one standard error.");
  }

  std::string settings() const {
    std::string out = "<dl class=\"settings\">\n";
    for (const auto& [name, value] : r_["configuration"].items())
      out += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", escaped(name), escaped(shown(value)));
    return out + "</dl>\n" + note("Names are those of packMesh --reference and --help; – stands for none.");
  }

  std::string command() const {
    std::string words;
    for (const Json& word : r_["command"]) words += (words.empty() ? "" : " ") + quoted(word);
    const Json &times = r_["times"], &statistics = r_["statistics"];
    const Json& growth = statistics["growth"];
    const auto effort = (growth.is_null() ? statistics["sweeps"] : growth["iterations"]).get<std::int64_t>() +
                        statistics["search"].get<std::int64_t>();
    return "<pre>" + escaped(words) + "</pre>\n" +
           note(fmt::format("Run time {} on {} rank{}; {} {}, {} rounds of repair. The same command and "
                            "version write the same .pos files, on any number of ranks.",
                            durationText(times["wall"].get<double>()), shown(times["ranks"]),
                            times["ranks"] == 1 ? "" : "s", effort,
                            growth.is_null() ? "sweeps" : "iterations of growth",
                            shown(statistics["repairs"])));
  }

  const Json& r_;
};

}  // namespace

std::string htmlText(const Json& report, const Picture& picture) {
  // The values come from the JSON text, in which everything is valid UTF-8.
  return Page(Json::parse(report.dump(-1, ' ', false, Json::error_handler_t::replace)))(picture);
}

}  // namespace packmesh::hemocell
