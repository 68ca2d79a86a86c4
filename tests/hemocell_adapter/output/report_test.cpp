// SPDX-License-Identifier: AGPL-3.0-or-later
// Reports, VTK files and scenes, as users get them.
#include "hemocell_adapter/output/report.h"
#include "hemocell_adapter/settings/attribute_tables.h"

#include <nlohmann/json.hpp>
#include <set>

#include "hemocell_adapter/settings/settings_table.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
namespace fs = std::filesystem;

namespace {

Report reportIn(const fs::path& file) {
  return Report::parse(readText(file));
}

/// The JSON in an element of a page.
Report embedded(const std::string& html, const std::string& id) {
  const std::string begin = "<script type=\"application/json\" id=\"" + id + "\">";
  const std::size_t from = html.find(begin) + begin.size();
  return Report::parse(html.substr(from, html.find("</script>", from) - from));
}

double sum(const Report& numbers) {
  double all = 0.0;
  for (const double n : numbers) all += n;
  return all;
}

}  // namespace

TEST_CASE("A report describes the run in consistent numbers", "[executable]") {
  const SampleCase folder;
  ok(folder, "config.xml --hematocrit 0.3 --plt_ratio 0.2 --seed 3 --report out/report.json");
  CHECK_FALSE(fs::exists(folder / "out/report.html"));
  const Report report = reportIn(folder / "out/report.json");
  CHECK(report["schema"] == "packMesh-report");
  CHECK(report["schemaVersion"] == 1);
  CHECK(report["command"].back() == "out/report.json");
  CHECK(report["outcome"] == "certified");
  CHECK(report["certificate"]["clean"] == true);
  CHECK(report["configuration"]["seed"] == 3);
  CHECK(report["configuration"]["ends"] == "closed");
  CHECK(report["lumen"]["lattice"]["dx"] == 0.5);
  std::int64_t cells = 0;
  for (const Report& species : report["species"]) {
    std::ifstream pos(folder / species["file"].get<std::string>());
    std::int64_t n = -1;
    pos >> n;
    CHECK(species["placed"] == n);
    CHECK(species["keptByHemoCell"] == n);
    cells += n;
  }
  CHECK(report["certificate"]["cells"] == cells);
  CHECK(report["hemocell"]["kept"] == cells);
  CHECK(report["hematocrit"][0]["convention"] == "mesh");
  CHECK(report["hematocrit"][0]["ofLumen"].get<double>() == Approx(0.3).margin(0.01));

  // The profiles hold all cells; the lumen's volume is sampled.
  const double red = report["hematocrit"][0]["redVolume"];
  for (const auto& [axis, profile] : report["measures"]["axial"].items()) {
    double volume = 0.0;
    for (std::size_t i = 0; i < profile["red"].size(); ++i)
      volume += profile["red"][i].get<double>() * profile["lumen"][i].get<double>();
    CHECK(volume == Approx(red).epsilon(1e-3));
    CHECK(sum(profile["lumen"]) == Approx(report["lumen"]["volume"].get<double>()).epsilon(0.1));
  }
  const Report& layer = report["measures"]["wall"]["cellFreeLayer"][0];
  CHECK(layer["share"] == 0.05);
  CHECK(layer["thickness"] > 0.0);
  CHECK(layer["thickness"] < 1.5);
  for (const Report& gaps : report["measures"]["gaps"]) {
    const auto& species = report["species"][&gaps - &report["measures"]["gaps"][0]];
    CHECK(sum(gaps["counts"]) + gaps["beyond"].get<double>() == species["placed"].get<double>());
  }
}

TEST_CASE("The configuration in a report has every tag", "[report]") {
  Problem problem;
  problem.request.boxSize = Vec3(20, 20, 20);
  const Report all = configurationOf(problem, {}, {});
  for (const Setting& setting : settingsTable())
    if (!setting.tag.empty()) {
      INFO(setting.tag);
      CHECK(all.contains(setting.tag));
    }
  CHECK(all["walls"] == "none");
  CHECK(all["ends"] == "closed");
  for (const auto& parameter : catParameters()) {
    problem.request.method = Method::cat;
    INFO(parameter.name);
    CHECK(configurationOf(problem, {}, {})["growth"].contains(parameter.name));
  }
}

TEST_CASE("An HTML report is one file that holds the data as JSON", "[executable]") {
  const SampleCase folder;
  const Ran ran = ok(folder, "config.xml --hematocrit 0.1 --report 'my report.html'");
  CHECK_THAT(ran.out, Contains("Wrote my report.html") && Contains("Wrote my report.json"));
  const std::string html = readText(folder / "my report.html");
  CHECK(embedded(html, "report") == reportIn(folder / "my report.json"));
  const Report view = embedded(html, "cells");
  const std::size_t cells = view["cells"];
  CHECK(view["slice"].is_null());
  CHECK(view["numbers"].is_null());
  CHECK(view["positions"].get<std::string>().size() == (12 * cells + 2) / 3 * 4);
  CHECK(view["orientations"].get<std::string>().size() == (16 * cells + 2) / 3 * 4);
  CHECK(view["gaps"].get<std::string>().size() == (4 * cells + 2) / 3 * 4);
  CHECK(view["lumen"].contains("triangles"));
  CHECK_THAT(html, !Contains("src=\"http") && !Contains("@import") && !Contains("{{ ") && !Contains("{% "));
}

TEST_CASE("Text that looks like the end of a script stays data", "[executable]") {
  const SampleCase folder;
  const std::string name = "</script><!--<script>{{ cells }}";
  fs::create_directories(folder / name);
  ok(folder, "config.xml --rbc 1 --report report.html --output-dir '" + name + "'");
  const std::string html = readText(folder / "report.html");
  CHECK(html.find(name) == html.npos);
  CHECK(embedded(html, "report")["command"].back() == name);
}

TEST_CASE("Reports of one cell, and of species without cells, are complete", "[executable]") {
  const TemporaryFolder folder;
  ok(folder, "12 12 12 --rbc 1 --plt 0 --report report.html --vtp --pov");
  const Report report = reportIn(folder / "report.json");
  CHECK(report["measures"]["gaps"][0]["beyond"] == 1);
  CHECK(report["measures"]["gaps"][0]["minimum"].is_null());
  CHECK(report["measures"]["orientation"][0]["nematic"].get<double>() == Approx(1.0));
  CHECK(report["measures"]["wall"].is_null());
  CHECK(report["certificate"]["minimumGap"].is_null());
  CHECK_FALSE(fs::exists(folder / "PLT.vtp"));

  // Too many: what is left of the platelets may be none.
  const Ran fewer =
      ok(folder,
         "14 14 14 --hematocrit 0.72 --plt_ratio 0.05 --max-iterations 30 --best-effort --report fewer.json "
         "--vtp --pov");
  CHECK(reportIn(folder / "fewer.json")["outcome"] == "bestEffort");
}

TEST_CASE("Reports and VTK files show a lumen with obstacles", "[executable][long]") {
  const SampleCase folder;
  writeText(folder / "config.xml",
            configXml("<dx>5e-7</dx><nx>40</nx><ny>42</ny><nz>44</nz>",
                      "<packing><walls>yz</walls><container><obstacles>"
                      "<cylinder axis=\"z\" center=\"10 10 11\" radius=\"3\" length=\"30\"/>"
                      "<sphere center=\"3 16 16\" radius=\"2\"/>"
                      "<mesh file=\"tube.stl\" scale=\"0.5\" offset=\"16 4 4\"/>"
                      "</obstacles></container></packing>"));
  ok(folder, "config.xml --hematocrit 0.1 --report report.json --vtp");
  const Report container = reportIn(folder / "report.json")["configuration"]["container"];
  INFO(container.dump(2));
  CHECK(container["lumen"].is_null());
  CHECK(container["obstacles"].size() == 3);
  CHECK(container["obstacles"][0] == Report{{"kind", "cylinder"},
                                            {"axis", "z"},
                                            {"radius", 3.0},
                                            {"length", 30.0},
                                            {"center", {10.0, 10.0, 11.0}}});
  CHECK(container["obstacles"][1] ==
        Report{{"kind", "sphere"}, {"radius", 2.0}, {"center", {3.0, 16.0, 16.0}}});
  CHECK(container["obstacles"][2]["kind"] == "mesh");
  CHECK(container["obstacles"][2]["scale"] == 0.5);
  CHECK(fs::file_size(folder / "lumen.vtp") > 1000);
}

TEST_CASE("Errors of an output are reported before packing", "[executable][long]") {
  const SampleCase folder;
  const std::string box = "25 25 25 --rbc 3 ";
  const auto packing = [](const std::string& text) {
    return [=](const fs::path& in) {
      writeText(in / "config.xml", configXml(sampleDomain, "<packing>" + text + "</packing>"));
    };
  };
  requireRefused(
      folder,
      {{box + "--report report.txt", 1,
        "option '--report': expected a file that ends in .json or .html, found 'report.txt'"},
       {box + "--report", 1, "--report"},
       {box + "--report config.xml/report.json", 5, "is not a folder"},
       {box + "--report /proc/report.json", 5, "/proc: the folder is not writable"},
       {"config.xml --hematocrit 0.1", 2, "<vtp>", packing("<report>report.pdf</report><vtp>maybe</vtp>")},
       {"config.xml --hematocrit 0.1", 2, "<report>: expected a file that ends in",
        packing("<report>report.pdf</report>")}});
  for (const char* taken : {"report.json", "RBC.vtp", "RBC_mesh.vtp", "RBC_cells.vtp", "lumen.vtp"}) {
    fs::create_directory(folder / taken);
    requireRefused(folder, {{box + "--report report.html --vtp --vtp-meshes --pov", 5,
                             std::string(taken) + ": is not a regular file"}});
    fs::remove(folder / taken);
  }
}
