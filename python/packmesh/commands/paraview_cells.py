# SPDX-License-Identifier: AGPL-3.0-or-later
"""Shows the cells of the VTK files in a folder as meshes in ParaView (5.10 or later).

    packMesh config.xml --vtp                (of a saved state: packmesh export state.h5 --format vtk)
    python3 -m packmesh paraview-cells . picture.png [colour]

renders a picture (without a display by xvfb-run, Debian: xvfb); colour: species (the default), gap, local_hematocrit or id. In ParaView's View > Python Shell this file shows the
cells of the working directory. The mesh of each species is drawn at its cells by the representation "3D Glyphs", so it is in memory
only once.
"""
import pathlib
import sys

from paraview import servermanager
from paraview.simple import (ColorBy, GetActiveViewOrCreate, GetColorTransferFunction, GetScalarBar, Hide, Render, ResetCamera,
                             SaveScreenshot, Show, XMLPolyDataReader)
from vtkmodules.numpy_interface import dataset_adapter

TITLES = {"gap": "gap [µm]", "local_hematocrit": "local hematocrit"}
SIZE = [1200, 900]  # [pixels]
BLACK, WHITE = [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]
#: As in the report: RBC, PLT, WBC and others.
SPECIES_COLOURS = {"RBC": [0.70, 0.15, 0.12], "vRBC": [0.70, 0.15, 0.12], "PLT": [0.84, 0.62, 0.0], "WBC": [0.39, 0.45, 0.55]}
PALETTE = [[0.12, 0.37, 0.66], [0.18, 0.52, 0.35], [0.48, 0.26, 0.59], [0.85, 0.45, 0.05], [0.07, 0.52, 0.55],
           [0.63, 0.32, 0.42]]


def colour_of(name, number):
    found = [colour for prefix, colour in SPECIES_COLOURS.items() if name.startswith(prefix)]
    return found[0] if found else PALETTE[number % len(PALETTE)]


def read(file):
    source = XMLPolyDataReader(FileName=[str(file)])
    source.UpdatePipeline()
    return source


def data_of(source, name):
    return dataset_adapter.WrapDataObject(servermanager.Fetch(source)).PointData[name]


def species_in(folder):
    """Name, cells and mesh of each species with cells, by its number."""
    found = {}
    for mesh in sorted(folder.glob("*_mesh.vtp")):
        name = mesh.name[:-len("_mesh.vtp")]
        if (folder / (name + ".vtp")).exists():
            cells = read(folder / (name + ".vtp"))
            found[int(data_of(cells, "species")[0])] = (name, cells, read(mesh))
    if not found:
        sys.exit(f"(packMesh) (Error) {folder}: has no VTK files of packMesh, such as RBC.vtp and RBC_mesh.vtp (--vtp)")
    return dict(sorted(found.items()))


def name_species(species):
    """The colours of species have names instead of numbers."""
    scale = GetColorTransferFunction("species")
    scale.InterpretValuesAsCategories = 1
    scale.Annotations = [text for number, (name, _, _) in species.items() for text in (str(number), name)]
    scale.IndexedColors = [x for number, (name, _, _) in species.items() for x in colour_of(name, number)]


def spread(colour, species):
    """All values have a colour; of gaps nine of ten, and those that are larger the last one."""
    values = sorted(x for _, cells, _ in species.values() for x in data_of(cells, colour) if x == x)
    if colour == "gap" and values:
        GetColorTransferFunction("gap").RescaleTransferFunction(0.0, max(0.02, values[9 * len(values) // 10]))
    elif values:
        GetColorTransferFunction(colour).RescaleTransferFunction(values[0], values[-1])


def style_bar(colour, view):
    bar = GetScalarBar(GetColorTransferFunction(colour), view)
    bar.Title, bar.ComponentTitle = TITLES.get(colour, colour), ""
    bar.TitleFontSize, bar.LabelFontSize = 20, 18
    bar.ScalarBarThickness, bar.ScalarBarLength = 16, 0.3
    bar.WindowLocation = "Lower Right Corner"
    bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, "%.3g", "%.3g"
    bar.TitleColor = bar.LabelColor = BLACK


def show(cells, mesh, view, colour):
    """The mesh at the cells of a species."""
    Hide(mesh, view)
    display = Show(cells, view)
    display.SetRepresentationType("3D Glyphs")
    display.GlyphType = "Pipeline Connection"
    display.GlyphType.Input = mesh
    display.Orient = 1
    display.OrientationMode = "Quaternion"
    display.SelectOrientationVectors = "orientation"
    display.Scaling = 0
    ColorBy(display, ("POINTS", colour))
    return display


def main():
    arguments = sys.argv[1:]
    colour = arguments[2] if len(arguments) > 2 else "species"
    species = species_in(pathlib.Path(arguments[0] if arguments else "."))
    view = GetActiveViewOrCreate("RenderView")
    view.UseColorPaletteForBackground, view.Background = 0, WHITE
    view.OrientationAxesLabelColor = BLACK
    if len(arguments) > 1:
        view.ViewSize = SIZE
    displays = [show(cells, mesh, view, colour) for _, cells, mesh in species.values()]
    if colour == "species":
        name_species(species)
    else:
        spread(colour, species)
    displays[0].SetScalarBarVisibility(view, True)
    style_bar(colour, view)
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [3, -2, 2], [0, 0, 0], [0, 0, 1]
    ResetCamera(view)
    view.CameraViewAngle = 21  # of 30: the sphere around the cells is larger than what is seen of them
    Render(view)
    if len(arguments) > 1:
        SaveScreenshot(arguments[1], view, ImageResolution=SIZE)


main()
