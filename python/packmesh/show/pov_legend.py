# SPDX-License-Identifier: AGPL-3.0-or-later
"""What the colours mean, at the lower edge of pictures by POV-Ray 3.7."""
from packmesh.show import pov

#: Of the axes, as on the page of reports (page/data.js): red, green, blue of the screen.
AXES = {"x": (0.702, 0.149, 0.118), "y": (0.184, 0.522, 0.353), "z": (0.122, 0.373, 0.659)}

#: A bar for gaps, squares for orientations. Uses what camera() declares, and OnScale. Positions are fractions of half the picture.
LEGEND = """
#if (ColorBy > 0)
  #declare Near = 0.1 * Far;            // in front of everything
  #declare Flat = finish { ambient 0 diffuse 0 emission 1 }
  #macro Put(Thing, U, V, W, H)
    object { Thing matrix <Right.x * W, Right.y * W, Right.z * W, Up.x * H, Up.y * H, Up.z * H,
                           -ToCamera.x * H, -ToCamera.y * H, -ToCamera.z * H, 0, 0, 0>
             translate Eye + Near * (U * Wide * Right + V * Tall * Up - ToCamera) no_shadow no_reflection }
  #end
  #declare Letter = 0.075 * Tall * Near;
  #macro Write(Text, U, V, Share)        // Share of its length is left of U
    #local Line = text { internal 2 Text 0.01, 0 pigment { srgb 0.12 } finish { Flat } }
    #local Size = max_extent(Line) - min_extent(Line);
    Put(object { Line translate -(min_extent(Line).x + Share * Size.x) * x - 0.33 * y }, U, V, Letter, Letter)
  #end
  #macro Square(Colour, U, W)            // from U on, W wide
    Put(box { <0, -0.5, 0>, <1, 0.5, 0.01> pigment { srgb Colour } finish { Flat } }, U, Row, W * Wide * Near, 0.05 * Tall * Near)
  #end
  #declare Row = -0.93;
#end
#if (ColorBy = 1)
  #for (I, 0, 99) Square(OnScale(I / 99), -0.3 + 0.006 * I, 0.0062) #end
  Write("gap  0", -0.33, Row, 1)
  Write(concat(str(GapMost, 0, 2), " micrometres and more"), 0.33, Row, 0)
#end
#if (ColorBy = 2)
  #declare Names = array[3] { "x", "y", "z" }
  #for (I, 0, 2)
    #declare At = (0.65 * I - 0.95) / Aspect;
    Square(AxisColours[I], At, 0.05 / Aspect)
    Write(concat("axis along ", Names[I]), At + 0.08 / Aspect, Row, 0)
  #end
#end
"""


def axis_colours():
    """The declaration of AxisColours."""
    return pov.listed("AxisColours", [pov.vector(colour) for colour in AXES.values()])
