# SPDX-License-Identifier: AGPL-3.0-or-later
"""Shows states of growth in ParaView (5.10 or later): membranes coloured by scale, in their translucent CAT cells.

    packMesh 20 20 20 --rbc 30 --method cat --growth-frames 4
    python3 -m packmesh paraview-growth growth_frames picture.png 0 3 11

draws the files with these numbers below each other, with the scales that cells have reached; without numbers, the first, the middle and
the last of growth.pvd. Without a display it needs xvfb-run (Debian: xvfb). In ParaView itself:
open growth.pvd and cat_cells.pvd, press Apply and Play.
"""
import pathlib
import re
import sys

from paraview import simple
from paraview.simple import (Clip, ColorBy, GetActiveViewOrCreate, GetColorTransferFunction, GetScalarBar, Render, ResetCamera,
                             SaveScreenshot, Show, Text, Transform, XMLPolyDataReader)

ACROSS = 700  # [pixels]
ABOVE, BELOW = 44, 76  # pixels of labels above each state, of the scale below all
BLACK = [0.0, 0.0, 0.0]


def read(file):
    source = XMLPolyDataReader(FileName=[str(file)])
    source.UpdatePipeline()
    return source


def moved(source, by):
    out = Transform(Input=source)
    out.Transform.Translate = by
    return out


def smooth(source):
    """With normals of its vertices; the filter has another name from ParaView 5.12 on."""
    normals = getattr(simple, "SurfaceNormals", None) or simple.GenerateSurfaceNormals
    return normals(Input=source, FeatureAngle=180.0, Splitting=0)


def label(number, most, top, view):
    """At the upper left. top: fraction of the picture's height"""
    shown = Show(Text(Text=f"state {number}: scales up to {most:.2f}"), view)
    shown.WindowLocation, shown.Position = "Any Location", [0.02, top]
    shown.FontSize, shown.Color, shown.Bold = 22, BLACK, 1


def style_scale(view):
    scale = GetColorTransferFunction("scale")
    scale.ApplyPreset("Viridis (matplotlib)", True)
    scale.RescaleTransferFunction(0.0, 1.0)
    bar = GetScalarBar(scale, view)
    bar.Title, bar.ComponentTitle, bar.Orientation, bar.WindowLocation = "scale", "", "Horizontal", "Lower Left Corner"
    bar.TitleFontSize, bar.LabelFontSize, bar.TitleColor, bar.LabelColor = 20, 18, BLACK, BLACK
    bar.ScalarBarThickness, bar.ScalarBarLength = 14, 0.3
    bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, "%.1f", "%.1f"


def show(folder, number, by, top, view):
    file = read(folder / f"membranes_{number:04}.vtp")
    membranes = Show(moved(smooth(file), by), view)
    ColorBy(membranes, ("CELLS", "scale"))
    membranes.SetScalarBarVisibility(view, True)
    label(number, file.CellData["scale"].GetRange()[1], top, view)
    file = folder / f"cat_cells_{number:04}.vtp"
    if not file.exists():
        return
    cells = read(file)
    low, high = cells.GetDataInformation().GetBounds()[4:]
    half = Clip(Input=cells, ClipType="Plane", Invert=0)  # the lower half
    half.ClipType.Origin, half.ClipType.Normal = [0.0, 0.0, 0.5 * (low + high)], [0.0, 0.0, -1.0]
    display = Show(moved(half, by), view)
    display.ColorArrayName = [None, ""]
    display.AmbientColor = display.DiffuseColor = [0.45, 0.6, 0.75]
    display.Opacity = 0.3


def main():
    folder = pathlib.Path(sys.argv[1])
    series = re.findall(r'file="membranes_(\d+)\.vtp"', (folder / "growth.pvd").read_text())
    last = int(series[-1])
    numbers = [int(word) for word in sys.argv[3:]] or [0, last // 2, last]
    for number in numbers:
        if not (folder / f"membranes_{number:04}.vtp").exists():
            sys.exit(f"(packMesh) (Error) {folder}: has no state {number}; expected one of 0 to {last}")
    view = GetActiveViewOrCreate("RenderView")
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    outer = folder / f"cat_cells_{last:04}.vtp"
    bounds = read(outer if outer.exists() else folder / f"membranes_{last:04}.vtp").GetDataInformation().GetBounds()
    width = bounds[1] - bounds[0]
    above, below = ABOVE * width / ACROSS, BELOW * width / ACROSS
    seen = 2 / 4.25**0.5  # of a length along y, by the camera below
    height = bounds[3] - bounds[2] + above / seen
    whole = seen * len(numbers) * height + below
    for k, number in enumerate(numbers):
        show(folder, number, [0.0, -k * height, 0.0], 1 - (k * seen * height + 0.8 * above) / whole, view)
    style_scale(view)
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [0, -0.5, 2], [0, 0, 0], [0, 1, 0]
    view.CameraParallelProjection = 1
    ResetCamera(view)
    Render(view)
    for end in (view.CameraPosition, view.CameraFocalPoint):
        end[1] += 0.5 * (above - below)
    view.CameraParallelScale = 0.5 * whole
    size = [ACROSS, int(ACROSS * whole / width)]
    view.ViewSize = size
    SaveScreenshot(sys.argv[2], view, ImageResolution=size)


main()
