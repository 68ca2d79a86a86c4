// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/pov_camera.h"

#include <cmath>
#include <limits>

namespace packmesh::pov {
namespace {

/// Number of directions for which the outermost point is kept; the error is below a hundredth of the size of
/// the scene, which the margin of the frame covers.
constexpr int directions = 240;

/// Points such that a camera that shows all of them shows everything.
std::vector<Vec3> outlineOf(const std::vector<Extent>& extents) {
  constexpr double goldenAngle = 2.399963229728653;
  std::vector<Vec3> outline;
  for (int i = 0; i < directions; ++i) {
    const double z = 1.0 - (2 * i + 1.0) / directions, r = std::sqrt(1.0 - z * z);
    const Vec3 d(r * std::cos(goldenAngle * i), r * std::sin(goldenAngle * i), z);
    double most = -std::numeric_limits<double>::infinity();
    Vec3 farthest = Vec3::Zero();
    for (const Extent& e : extents)
      if (const double reach = e.center.dot(d) + e.radius; reach > most) {
        most = reach;
        farthest = e.center + e.radius * d;
      }
    outline.push_back(farthest);
  }
  return outline;
}

constexpr const char* look = R"(
#declare Aspect = image_width / image_height;
#declare Tall = 0.19;                 // tangent of half the vertical view angle
#declare Wide = Tall * Aspect;
#declare Frame = 0.95;                // fraction of the image used
#macro Look(A)                        // sets the directions of a camera at this azimuth
  #declare ToCamera = <cos(radians(Elevation)) * cos(radians(A)), cos(radians(Elevation)) * sin(radians(A)),
                       sin(radians(Elevation))>;
  #declare Right = vnormalize(vcross(z, ToCamera));
  #declare Up = vcross(ToCamera, Right);
#end)";

/// Removes the half towards the camera; the rest of the outline lies behind the plane.
constexpr const char* clip = R"(
#if (ClipAxis > 0)
  #declare ClipAlong = (ClipAxis = 1 ? x : ClipAxis = 2 ? y : z);
  Look(Azimuth)
  #declare ClipNormal = ClipAlong * (vdot(ToCamera, ClipAlong) < 0 ? -1 : 1);
  #declare ClipOffset = vdot(ClipNormal, Low + ClipAt * (High - Low));
  #for (I, 0, Points - 1)
    #declare Outline[I] = Outline[I] - max(0, vdot(ClipNormal, Outline[I]) - ClipOffset) * ClipNormal;
  #end
#end)";

constexpr const char* camera = R"(
#ifdef (Turn)                         // a distance at which every turn shows everything
  #declare Middle = 0;
  #for (I, 0, Points - 1) #declare Middle = Middle + Outline[I] / Points; #end
  #declare Away = 0;
  #for (K, 0, 35)
    Look(10 * K)
    #for (I, 0, Points - 1)
      #local P = Outline[I] - Middle;
      #declare Away = max(Away, vdot(P, ToCamera) + abs(vdot(P, Right)) / (Frame * Wide),
                          vdot(P, ToCamera) + abs(vdot(P, Up)) / (Frame * Tall));
    #end
  #end
  Look(Azimuth + Turn)
  #declare Eye = Middle + Away * ToCamera;
#else
  Look(Azimuth)
  #declare M = array[4] { -1e9, -1e9, -1e9, -1e9 }
  #for (I, 0, Points - 1)
    #local A = vdot(Outline[I], Right);
    #local B = vdot(Outline[I], Up);
    #local C = vdot(Outline[I], ToCamera);
    #declare M[0] = max(M[0], A + Frame * Wide * C);
    #declare M[1] = max(M[1], -A + Frame * Wide * C);
    #declare M[2] = max(M[2], B + Frame * Tall * C);
    #declare M[3] = max(M[3], -B + Frame * Tall * C);
  #end
  #declare Eye = (M[0] - M[1]) / 2 * Right + (M[2] - M[3]) / 2 * Up
    + max((M[0] + M[1]) / (2 * Frame * Wide), (M[2] + M[3]) / (2 * Frame * Tall)) * ToCamera;
#end
camera {
  location Eye
  direction -ToCamera
  up 2 * Tall * Up
  right 2 * Wide * Right
}
// A soft key light from the upper left, a weak fill light without shadow from the right.
light_source {
  Eye + Far * (-1.1 * Right + 1.5 * Up + 0.3 * ToCamera) rgb <1.0, 0.97, 0.93> * 1.05
  #if (Fine) area_light 0.9 * Far * Right, 0.9 * Far * Up, 4, 4 adaptive 0 jitter circular orient #end
}
light_source { Eye + Far * (1.6 * Right + 0.2 * Up) rgb <0.80, 0.88, 1.0> * 0.40 shadowless }
)";

}  // namespace

void writeCamera(SceneFile& out, const std::vector<Extent>& extents, const Vec3& size, const Box* clipped) {
  // From the front and above, with the longer horizontal axis across the image.
  const bool alongY = size.y() > size.x();
  out << "\n// Position of the camera [degrees]: azimuth 0 is +x, 90 is +y.\n" +
             defaultOf("Azimuth", alongY ? "22.8" : "-67.2") + defaultOf("Elevation", "20.2") +
             defaultOf("Fine", "0", "1: soft shadows");
  const std::vector<Vec3> outline = outlineOf(extents);
  out << "#declare Far = " + number(size.norm()) + ";\n#declare Points = " + std::to_string(outline.size()) +
             ";\n#declare Outline = array[Points] {";
  for (std::size_t i = 0; i < outline.size(); ++i)
    out << (i ? "," : "") + std::string(i % 4 ? " " : "\n  ") + vector(outline[i]);
  out << std::string("\n}\n") + look;
  if (clipped)
    out << "\n#declare Low = " + vector(clipped->lo) + ";\n#declare High = " + vector(clipped->hi) + ";" +
               clip;
  out << camera;
}

}  // namespace packmesh::pov
