# SPDX-License-Identifier: AGPL-3.0-or-later
"""Shows states of growth in ParaView (5.10 or later): membranes coloured by scale, in their translucent CAT cells.

    packMesh 20 20 20 --rbc 30 --method cat --growth-frames 4
    python3 -m packmesh paraview-growth growth_frames picture.png 0 3 11

draws the files with these numbers below each other; without numbers, the first, the middle and the last of growth.pvd. In ParaView itself:
open growth.pvd and cat_cells.pvd, press Apply and Play.
"""
import pathlib
import re
import sys

from paraview.simple import (Clip, ColorBy, GetActiveViewOrCreate, GetColorTransferFunction, Render, ResetCamera, SaveScreenshot,
                             Show, Transform, XMLPolyDataReader)


def read(file):
    source = XMLPolyDataReader(FileName=[str(file)])
    source.UpdatePipeline()
    return source


def moved(source, by):
    out = Transform(Input=source)
    out.Transform.Translate = by
    return out


def show(folder, number, by, view):
    membranes = Show(moved(read(folder / f"membranes_{number:04}.vtp"), by), view)
    ColorBy(membranes, ("CELLS", "scale"))
    GetColorTransferFunction("scale").RescaleTransferFunction(0.1, 1.0)
    membranes.SetScalarBarVisibility(view, False)
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
    view = GetActiveViewOrCreate("RenderView")
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    outer = folder / f"cat_cells_{last:04}.vtp"
    bounds = read(outer if outer.exists() else folder / f"membranes_{last:04}.vtp").GetDataInformation().GetBounds()
    width, height = bounds[1] - bounds[0], 1.05 * (bounds[3] - bounds[2])
    for k, number in enumerate(numbers):
        show(folder, number, [0.0, -k * height, 0.0], view)
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [0, -0.5, 2], [0, 0, 0], [0, 1, 0]
    view.CameraParallelProjection = 1
    ResetCamera(view)
    Render(view)
    view.CameraParallelScale = 0.5 * height * len(numbers)
    across = 700
    SaveScreenshot(sys.argv[2], view, ImageResolution=[across, int(across * height * len(numbers) / width)])


main()
