// SPDX-License-Identifier: AGPL-3.0-or-later
#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
#include <OpenMesh/Core/IO/reader/OFFReader.hh>
#include <OpenMesh/Core/IO/reader/PLYReader.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <iostream>
#include <mutex>
#include <sstream>

#include "packMesh/error.h"
#include "packMesh/io/polygon_soup.h"

namespace packmesh {
namespace {

namespace om = OpenMesh;

/// Receives what OpenMesh reads as a soup of polygons. OpenMesh's own meshes drop every face that does not
/// fit a manifold; nothing is dropped here, and repairClosed decides later.
class SoupImporter : public om::IO::BaseImporter {
 public:
  PolygonSoup soup;

  om::VertexHandle add_vertex(const om::Vec3d& p) override {
    soup.vertices.emplace_back(p[0], p[1], p[2]);
    return om::VertexHandle(static_cast<int>(soup.vertices.size()) - 1);
  }
  om::VertexHandle add_vertex(const om::Vec3f& p) override { return add_vertex(om::Vec3d(p[0], p[1], p[2])); }
  om::VertexHandle add_vertex() override { return add_vertex(om::Vec3d(0.0, 0.0, 0.0)); }
  void set_point(om::VertexHandle v, const om::Vec3f& p) override {
    soup.vertices[v.idx()] = Vec3(p[0], p[1], p[2]);
  }
  om::FaceHandle add_face(const VHandles& corners) override {
    for (const om::VertexHandle& v : corners) soup.corners.push_back(v.idx());
    soup.ends.push_back(static_cast<int>(soup.corners.size()));
    return om::FaceHandle(static_cast<int>(soup.ends.size()) - 1);
  }
  std::size_t n_vertices() const override { return soup.vertices.size(); }
  std::size_t n_faces() const override { return soup.ends.size(); }
  std::size_t n_edges() const override { return 0; }

  // Connectivity, normals, colours, textures: of no interest.
  om::HalfedgeHandle add_edge(om::VertexHandle, om::VertexHandle) override { return om::HalfedgeHandle(); }
  om::FaceHandle add_face(om::HalfedgeHandle) override { return om::FaceHandle(); }
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec2f>&) override {}
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec3f>&) override {}
  void set_face_texindex(om::FaceHandle, int) override {}
  void set_halfedge(om::VertexHandle, om::HalfedgeHandle) override {}
  void set_normal(om::VertexHandle, const om::Vec3f&) override {}
  void set_normal(om::VertexHandle, const om::Vec3d&) override {}
  void set_normal(om::FaceHandle, const om::Vec3f&) override {}
  void set_normal(om::FaceHandle, const om::Vec3d&) override {}
  void set_color(om::VertexHandle, const om::Vec3uc&) override {}
  void set_color(om::VertexHandle, const om::Vec4uc&) override {}
  void set_color(om::VertexHandle, const om::Vec3f&) override {}
  void set_color(om::VertexHandle, const om::Vec4f&) override {}
  void set_color(om::EdgeHandle, const om::Vec3uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec4uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec3f&) override {}
  void set_color(om::EdgeHandle, const om::Vec4f&) override {}
  void set_color(om::FaceHandle, const om::Vec3uc&) override {}
  void set_color(om::FaceHandle, const om::Vec4uc&) override {}
  void set_color(om::FaceHandle, const om::Vec3f&) override {}
  void set_color(om::FaceHandle, const om::Vec4f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec2f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec3f&) override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec2f&) override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec3f&) override {}
  void set_status(om::VertexHandle, const om::Attributes::StatusInfo&) override {}
  void set_status(om::HalfedgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_status(om::EdgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_status(om::FaceHandle, const om::Attributes::StatusInfo&) override {}
  void set_next(om::HalfedgeHandle, om::HalfedgeHandle) override {}
  void set_face(om::HalfedgeHandle, om::FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void add_texture_information(int, std::string) override {}
};

/// While it lives, what OpenMesh would print goes to `text`. OpenMesh's streams are global: hence the lock.
class CapturedOutput {
 public:
  CapturedOutput() : lock_(mutex()) {
    omerr().disconnect(std::cerr);
    omerr().connect(text);
  }
  ~CapturedOutput() {
    omerr().disconnect(text);
    omerr().connect(std::cerr);
  }
  std::ostringstream text;

 private:
  static std::mutex& mutex() {
    static std::mutex only;
    return only;
  }
  std::lock_guard<std::mutex> lock_;
};

}  // namespace

PolygonSoup readByOpenMesh(const std::string& content, const std::string& kind,
                           const std::filesystem::path& file) {
  SoupImporter importer;
  om::IO::Options options;
  std::istringstream stream(content);
  CapturedOutput captured;
  om::IO::BaseReader& reader = kind == "ply" ? static_cast<om::IO::BaseReader&>(om::IO::PLYReader())
                                             : static_cast<om::IO::BaseReader&>(om::IO::OFFReader());
  if (kind == "off") options += om::IO::Options::Binary;
  if (!reader.read(stream, importer, options)) {
    std::string said = captured.text.str();
    while (!said.empty() && (said.back() == '\n' || said.back() == ' ')) said.pop_back();
    throw InputError(file.string() + ": expected a complete binary " + (kind == "ply" ? "PLY" : "OFF") +
                     " file; OpenMesh says: " + (said.empty() ? "not readable" : said));
  }
  for (const int corner : importer.soup.corners)
    if (corner < 0 || corner >= static_cast<int>(importer.soup.vertices.size()))
      throw InputError(file.string() + ": a face names vertex " + std::to_string(corner) +
                       ", expected 0 to " + std::to_string(importer.soup.vertices.size() - 1));
  return std::move(importer.soup);
}

}  // namespace packmesh
