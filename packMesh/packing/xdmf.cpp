// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/xdmf.h"

#include <tinyxml2.h>

#include "packMesh/io/atomic_files.h"

namespace packmesh {
namespace {

/// Type and size of numbers in a state file, in the terms of XDMF.
struct Numbers {
  const char *type, *bytes;
};
constexpr Numbers real{"Float", "8"}, wide{"Int", "8"}, whole{"Int", "4"};

class Writer {
 public:
  explicit Writer(std::string stateFile) : stateFile_(std::move(stateFile)) {}

  std::string text(std::int64_t cells, const std::vector<Species>& species) {
    xml_.PushHeader(false, true);
    xml_.OpenElement("Xdmf");
    xml_.PushAttribute("Version", "3.0");
    xml_.OpenElement("Domain");
    if (cells > 0) writeCells(cells);
    for (std::size_t s = 0; s < species.size(); ++s)
      writeMesh(species[s].name + "_mesh", "/species/" + std::to_string(s), species[s].shape->mesh());
    xml_.CloseElement();
    xml_.CloseElement();
    return xml_.CStr();
  }

 private:
  void openGrid(const std::string& name, const char* topology, std::int64_t elements) {
    xml_.OpenElement("Grid");
    xml_.PushAttribute("Name", name.c_str());
    xml_.PushAttribute("GridType", "Uniform");
    xml_.OpenElement("Topology");
    xml_.PushAttribute("TopologyType", topology);
    xml_.PushAttribute("NumberOfElements", elements);
  }
  void openGeometry() {
    xml_.OpenElement("Geometry");
    xml_.PushAttribute("GeometryType", "XYZ");
  }
  void table(const std::string& path, const Numbers& numbers, std::int64_t rows, int columns) {
    const std::string size = std::to_string(rows) + (columns > 1 ? " " + std::to_string(columns) : "");
    xml_.OpenElement("DataItem");
    xml_.PushAttribute("Dimensions", size.c_str());
    xml_.PushAttribute("NumberType", numbers.type);
    xml_.PushAttribute("Precision", numbers.bytes);
    xml_.PushAttribute("Format", "HDF");
    xml_.PushText((stateFile_ + ":" + path).c_str());
    xml_.CloseElement();
  }

  void writeCells(std::int64_t cells) {
    openGrid("cells", "Polyvertex", cells);
    xml_.CloseElement();
    openGeometry();
    table("/cells/position", real, cells, 3);
    xml_.CloseElement();
    const auto attribute = [&](const char* name, const char* kind, const Numbers& numbers, int columns) {
      xml_.OpenElement("Attribute");
      xml_.PushAttribute("Name", name);
      xml_.PushAttribute("AttributeType", kind);
      xml_.PushAttribute("Center", "Node");
      table(std::string("/cells/") + name, numbers, cells, columns);
      xml_.CloseElement();
    };
    attribute("id", "Scalar", wide, 1);
    attribute("species", "Scalar", whole, 1);
    attribute("orientation", "Matrix", real, 4);
    for (const char* name : {"scale", "overlap", "gap", "local_hematocrit"})
      attribute(name, "Scalar", real, 1);
    xml_.CloseElement();
  }

  void writeMesh(const std::string& name, const std::string& path, const TriangleMesh& mesh) {
    const auto triangles = static_cast<std::int64_t>(mesh.triangles.size());
    openGrid(name, "Triangle", triangles);
    table(path + "/triangles", whole, triangles, 3);
    xml_.CloseElement();
    openGeometry();
    table(path + "/vertices", real, static_cast<std::int64_t>(mesh.vertices.size()), 3);
    xml_.CloseElement();
    xml_.CloseElement();
  }

  tinyxml2::XMLPrinter xml_;
  std::string stateFile_;
};

}  // namespace

void writeXdmf(const std::filesystem::path& file, const std::filesystem::path& stateFile, std::int64_t cells,
               const std::vector<Species>& species) {
  AtomicFiles files;
  files.add(file, Writer(stateFile.filename().string()).text(cells, species));
  files.commit();
}

}  // namespace packmesh
