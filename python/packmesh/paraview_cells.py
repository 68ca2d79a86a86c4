# SPDX-License-Identifier: AGPL-3.0-or-later
"""Shows the cells of a state file as meshes in ParaView (5.10 or later).

    python3 -m packmesh paraview-cells state.xdmf picture.png [colour]

renders a picture; colour: species (the default), gap, local_hematocrit, overlap, id, ... In ParaView itself: open the .xdmf file
with "XDMF Reader", press Apply, then run this file in View > Python Shell: it takes the active source. The
mesh of each species is drawn at its cells by the representation "3D Glyphs", so it is in memory only once.
"""
import sys

from paraview import servermanager
from paraview.simple import (ColorBy, ExtractBlock, ExtractSurface, GetActiveSource, GetActiveViewOrCreate, GetColorTransferFunction,
                             GetScalarBar, Hide, Render, ResetCamera, SaveScreenshot, Show, XDMFReader)
from vtkmodules.numpy_interface import dataset_adapter

TITLES = {"gap": "gap [µm]", "overlap": "overlap [µm]", "local_hematocrit": "local hematocrit"}
SIZE = [1200, 900]  # [pixels]
BLACK, WHITE = [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]
#: As in the report: RBC, PLT, WBC and others.
SPECIES_COLOURS = {"RBC": [0.70, 0.15, 0.12], "vRBC": [0.70, 0.15, 0.12], "PLT": [0.84, 0.62, 0.0], "WBC": [0.39, 0.45, 0.55]}
PALETTE = [[0.12, 0.37, 0.66], [0.18, 0.52, 0.35], [0.48, 0.26, 0.59], [0.85, 0.45, 0.05], [0.07, 0.52, 0.55], [0.63, 0.32, 0.42]]


def colour_of(name, number):
    found = [colour for prefix, colour in SPECIES_COLOURS.items() if name.startswith(prefix)]
    return found[0] if found else PALETTE[number % len(PALETTE)]


def name_species(names):
    """The colours of species have names instead of numbers."""
    scale = GetColorTransferFunction("species")
    scale.InterpretValuesAsCategories = 1
    scale.Annotations = [text for number, name in enumerate(names) for text in (str(number), name)]
    scale.IndexedColors = [x for number, name in enumerate(names) for x in colour_of(name, number)]


def spread_gaps(cells):
    """Nine of ten cells have a colour of their own; those with larger gaps have the last one. States of unfinished runs have none."""
    blocks = dataset_adapter.WrapDataObject(servermanager.Fetch(cells)).PointData["gap"].Arrays
    gaps = sorted(gap for block in blocks for gap in block if gap == gap)
    if gaps:
        GetColorTransferFunction("gap").RescaleTransferFunction(0.0, max(0.02, gaps[9 * len(gaps) // 10]))


def style_bar(colour, view):
    bar = GetScalarBar(GetColorTransferFunction(colour), view)
    bar.Title, bar.ComponentTitle = TITLES.get(colour, colour), ""
    bar.TitleFontSize, bar.LabelFontSize = 20, 18
    bar.ScalarBarThickness, bar.ScalarBarLength = 16, 0.3
    bar.WindowLocation = "Lower Right Corner"
    bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, "%.3g", "%.3g"
    bar.TitleColor = bar.LabelColor = BLACK


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
    if colour == "species":
        name_species([name[:-len("_mesh")] for name in names[1:]])
    elif colour == "gap":
        spread_gaps(cells)
    else:
        display.RescaleTransferFunctionToDataRange(True)
    display.SetScalarBarVisibility(view, True)
    style_bar(colour, view)


def main():
    arguments = sys.argv[1:]
    source = XDMFReader(FileNames=[arguments[0]]) if arguments else GetActiveSource()
    view = GetActiveViewOrCreate("RenderView")
    view.UseColorPaletteForBackground, view.Background = 0, WHITE
    view.OrientationAxesLabelColor = BLACK
    if len(arguments) > 1:
        view.ViewSize = SIZE
    show(source, view, arguments[2] if len(arguments) > 2 else "species")
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [3, -2, 2], [0, 0, 0], [0, 0, 1]
    ResetCamera(view)
    view.CameraViewAngle = 21  # of 30: the sphere around the cells is larger than what is seen of them
    Render(view)
    if len(arguments) > 1:
        SaveScreenshot(arguments[1], view, ImageResolution=SIZE)


main()
