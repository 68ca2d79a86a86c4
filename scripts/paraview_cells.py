#!/usr/bin/env pvpython
"""Shows the cells of a state file as meshes in ParaView.

pvpython paraview_cells.py state.xdmf [picture.png]   or   Tools > Python Shell > Run Script, which asks for no file:
then the active source is taken. Each species' template mesh is drawn once per cell by "3D Glyphs" (ParaView 5.10).
"""
import sys

from paraview.simple import (ColorBy, CreateRenderView, ExtractBlock, GetActiveSource, GetActiveViewOrCreate, Render,
                             ResetCamera, SaveScreenshot, Show, XDMFReader)


def names_of(source):
    information = source.GetDataInformation().DataInformation
    hierarchy = information.GetHierarchy()
    return [hierarchy.GetNodeName(node) for node in hierarchy.GetChildNodes(0)]


def show(source, view):
    names = names_of(source)
    for number, name in enumerate(names):
        if name.endswith("_mesh") or name.endswith(" mesh") or number + 1 >= len(names):
            continue
        cells = ExtractBlock(Input=source, Selectors=["/Root/" + name])
        mesh = ExtractBlock(Input=source, Selectors=["/Root/" + names[number + 1]])
        display = Show(cells, view)
        display.SetRepresentationType("3D Glyphs")
        display.GlyphType = "Pipeline Connection"
        display.GlyphType.Input = mesh
        display.Orient = 1
        display.OrientationMode = "Quaternion"
        display.SelectOrientationVectors = "orientation"
        display.Scaling = 1
        display.ScaleMode = "Magnitude"
        display.SelectScaleArray = "scale"
        ColorBy(display, ("POINTS", "species"))


def main():
    files = sys.argv[1:]
    source = XDMFReader(FileNames=[files[0]]) if files else GetActiveSource()
    source.UpdatePipeline()
    view = CreateRenderView() if files else GetActiveViewOrCreate("RenderView")
    show(source, view)
    ResetCamera(view)
    Render(view)
    if len(files) > 1:
        SaveScreenshot(files[1], view, ImageResolution=[1200, 900])


main()
