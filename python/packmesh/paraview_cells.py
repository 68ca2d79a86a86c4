# SPDX-License-Identifier: AGPL-3.0-or-later
"""Shows the cells of a state file as meshes in ParaView (5.10 or later).

    python3 -m packmesh paraview-cells state.xdmf picture.png [colour]

renders a picture; colour: species (the default), gap, local_hematocrit, id, ... In ParaView itself: open the .xdmf file
with "XDMF Reader", press Apply, then run this file in View > Python Shell: it takes the active source. The
mesh of each species is drawn at its cells by the representation "3D Glyphs", so it is in memory only once.
"""
import sys

from paraview.simple import (ColorBy, ExtractBlock, ExtractSurface, GetActiveSource, GetActiveViewOrCreate, Hide,
                             Render, ResetCamera, SaveScreenshot, Show, XDMFReader)


def show(source, view, colour):
    source.UpdatePipeline()
    hierarchy = source.GetDataInformation().DataInformation.GetHierarchy()
    names = [hierarchy.GetNodeName(node) for node in hierarchy.GetChildNodes(0)]
    cells = ExtractBlock(Input=source, Selectors=["/Root/" + names[0]])
    meshes = ExtractSurface(Input=ExtractBlock(Input=source, Selectors=["/Root/" + name for name in names[1:]]))
    Hide(source, view)
    display = Show(cells, view)
    display.SetRepresentationType("3D Glyphs")
    display.GlyphType = "Pipeline Connection"
    display.GlyphType.Input = meshes
    display.UseGlyphTable = display.UseCompositeGlyphTable = 1
    display.GlyphTableIndexArray = "species"
    display.Orient = 1
    display.OrientationMode = "Quaternion"
    display.SelectOrientationVectors = "orientation"
    display.Scaling = 1
    display.ScaleFactor = 1.0  # ParaView proposes one of its own
    display.ScaleMode = "Magnitude"
    display.SelectScaleArray = "scale"
    ColorBy(display, ("POINTS", colour))
    display.RescaleTransferFunctionToDataRange(True)
    display.SetScalarBarVisibility(view, True)


def main():
    arguments = sys.argv[1:]
    source = XDMFReader(FileNames=[arguments[0]]) if arguments else GetActiveSource()
    view = GetActiveViewOrCreate("RenderView")
    show(source, view, arguments[2] if len(arguments) > 2 else "species")
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [3, -2, 2], [0, 0, 0], [0, 0, 1]
    ResetCamera(view)
    Render(view)
    if len(arguments) > 1:
        SaveScreenshot(arguments[1], view, ImageResolution=[1200, 900])


main()
