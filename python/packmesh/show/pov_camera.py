# SPDX-License-Identifier: AGPL-3.0-or-later
"""Camera and lights of scenes for POV-Ray 3.7."""
import math

from packmesh.show import pov

#: Directions for which the outermost point is kept; the error is below a hundredth of the size of the scene, which the margin
#: of the frame covers.
DIRECTIONS = 240

LOOK = """
#declare Aspect = image_width / image_height;
#declare Tall = 0.19;                 // tangent of half the vertical view angle
#declare Wide = Tall * Aspect;
#declare Frame = 0.95;                // fraction of the image used
#ifdef (ColorBy) #if (ColorBy > 0) #declare Frame = 0.86; #end #end  // room for what the colours mean
#macro Look(A)                        // sets the directions of a camera at this azimuth
  #declare ToCamera = <cos(radians(Elevation)) * cos(radians(A)), cos(radians(Elevation)) * sin(radians(A)),
                       sin(radians(Elevation))>;
  #declare Right = vnormalize(vcross(z, ToCamera));
  #declare Up = vcross(ToCamera, Right);
#end
"""

#: Removes the half towards the camera; the rest of the outline lies behind the plane.
CLIP = """#if (ClipAxis > 0)
  #declare ClipAlong = (ClipAxis = 1 ? x : ClipAxis = 2 ? y : z);
  Look(Azimuth)
  #declare ClipNormal = ClipAlong * (vdot(ToCamera, ClipAlong) < 0 ? -1 : 1);
  #declare ClipOffset = vdot(ClipNormal, Low + ClipAt * (High - Low));
  #for (I, 0, Points - 1)
    #declare Outline[I] = Outline[I] - max(0, vdot(ClipNormal, Outline[I]) - ClipOffset) * ClipNormal;
  #end
#end
"""

CAMERA = """#ifdef (Turn)                         // a distance at which every turn shows everything
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
"""


def outline(extents):
    """Points such that a camera that shows all of them shows everything. `extents`: centres and radii"""
    golden_angle, points = math.pi * (3 - math.sqrt(5)), []
    for i in range(DIRECTIONS):
        z = 1 - (2 * i + 1) / DIRECTIONS
        r = math.sqrt(1 - z * z)
        x, y = r * math.cos(golden_angle * i), r * math.sin(golden_angle * i)
        (a, b, c), radius = max(extents, key=lambda e: e[0][0] * x + e[0][1] * y + e[0][2] * z + e[1])
        points.append((a + radius * x, b + radius * y, c + radius * z))
    return points


def camera(extents, low, high, clipped=False):
    """Camera and lights. The camera shows every extent at any aspect ratio, from the position given by the declared Azimuth and
    Elevation [degrees]; Turn rotates it further about the vertical, and then the distance is such that all turns show everything.
    Declares ToCamera. From the front and above, with the longer horizontal axis across the image.

    low, high: corners of the box around everything
    clipped: the box is cut by the plane of ClipAxis and ClipAt; the part in front of it need not be shown. Declares ClipNormal and
        ClipOffset
    """
    size = pov.sub(high, low)
    points = outline(extents)
    return ("\n// Position of the camera [degrees]: azimuth 0 is +x, 90 is +y.\n"
            + pov.default("Azimuth", "22.8" if size[1] > size[0] else "-67.2") + pov.default("Elevation", "20.2")
            + pov.default("Fine", "0", "1: soft shadows")
            + f"#declare Far = {pov.number(pov.norm(size))};\n#declare Points = {len(points)};\n"
            + pov.listed("Outline", [pov.vector(p) for p in points]) + LOOK +
            (f"#declare Low = {pov.vector(low)};\n#declare High = {pov.vector(high)};\n{CLIP}" if clipped else "") + CAMERA)
