// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/xdmf.h"

#include <fstream>
#include <numeric>
#include <sstream>

#include "packMesh/error.h"

namespace packmesh {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
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
  return out;
}

/// A table of a state file, or rows of one.
struct Table {
  const char* numbers;  ///< kind and size of them, as XDMF tells
  std::string path;
  int columns;
};

constexpr char real[] = "NumberType=\"Float\" Precision=\"8\"";
constexpr char wholeLong[] = "NumberType=\"Int\" Precision=\"8\"";
constexpr char whole[] = "NumberType=\"Int\" Precision=\"4\"";

class Xdmf {
 public:
  explicit Xdmf(std::string heavy) : heavy_(std::move(heavy)) {}

  std::string all(const Table& table, std::int64_t rows) const {
    std::ostringstream out;
    out << "<DataItem Dimensions=\"" << size(rows, table.columns) << "\" " << table.numbers << " Format=\"HDF\">"
        << escaped(heavy_) << ":" << table.path << "</DataItem>";
    return out.str();
  }
  std::string rows(const Table& table, std::int64_t first, std::int64_t count, std::int64_t of) const {
    const int rank = table.columns == 1 ? 1 : 2;
    std::ostringstream out;
    out << "<DataItem ItemType=\"HyperSlab\" Dimensions=\"" << size(count, table.columns) << "\" "
        << table.numbers << "><DataItem Dimensions=\"3 " << rank << "\" Format=\"XML\">";
    if (rank == 1)
      out << first << " 1 " << count;
    else
      out << first << " 0 1 1 " << count << " " << table.columns;
    out << "</DataItem>" << all(table, of) << "</DataItem>";
    return out.str();
  }

 private:
  static std::string size(std::int64_t rows, int columns) {
    return std::to_string(rows) + (columns == 1 ? "" : " " + std::to_string(columns));
  }
  std::string heavy_;
};

}  // namespace

void writeXdmf(const std::filesystem::path& file, const std::filesystem::path& stateFile,
               const std::vector<XdmfSpecies>& species) {
  const Xdmf xdmf(stateFile.filename().string());
  const std::int64_t all = std::accumulate(species.begin(), species.end(), std::int64_t(0),
                                           [](std::int64_t n, const XdmfSpecies& s) { return n + s.cells; });
  std::ofstream out(file, std::ios::binary);
  out << "<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf Version=\"3.0\">\n<Domain>\n";
  std::int64_t first = 0;
  for (std::size_t s = 0; s < species.size(); ++s) {
    const XdmfSpecies& of = species[s];
    if (of.cells == 0) continue;
    out << "<Grid Name=\"" << escaped(of.name) << "\" GridType=\"Uniform\">\n"
        << "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"" << of.cells << "\"/>\n"
        << "<Geometry GeometryType=\"XYZ\">" << xdmf.rows({real, "/cells/position", 3}, first, of.cells, all)
        << "</Geometry>\n";
    const auto attribute = [&](const char* name, const char* kind, const Table& table) {
      out << "<Attribute Name=\"" << name << "\" AttributeType=\"" << kind << "\" Center=\"Node\">"
          << xdmf.rows(table, first, of.cells, all) << "</Attribute>\n";
    };
    attribute("id", "Scalar", {wholeLong, "/cells/id", 1});
    attribute("species", "Scalar", {whole, "/cells/species", 1});
    attribute("orientation", "Matrix", {real, "/cells/orientation", 4});
    attribute("scale", "Scalar", {real, "/cells/scale", 1});
    attribute("overlap", "Scalar", {real, "/cells/overlap", 1});
    out << "</Grid>\n";
    const std::string path = "/species/" + std::to_string(s);
    out << "<Grid Name=\"" << escaped(of.name) << " mesh\" GridType=\"Uniform\">\n"
        << "<Topology TopologyType=\"Triangle\" NumberOfElements=\"" << of.triangles << "\">"
        << xdmf.all({whole, path + "/triangles", 3}, of.triangles) << "</Topology>\n"
        << "<Geometry GeometryType=\"XYZ\">" << xdmf.all({real, path + "/vertices", 3}, of.vertices)
        << "</Geometry>\n</Grid>\n";
    first += of.cells;
  }
  out << "</Domain>\n</Xdmf>\n";
  if (!out.flush()) throw InputError(file.string() + ": cannot be written");
}

}  // namespace packmesh
