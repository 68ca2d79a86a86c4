#!/usr/bin/env python3
"""Ends with 0 if VTK reads a file with appended data that it has written itself: with a newer Expat, older versions do not."""
import os
import sys
import tempfile

from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

sphere, writer, reader = vtkSphereSource(), vtkXMLPolyDataWriter(), vtkXMLPolyDataReader()
sphere.SetThetaResolution(200)  # larger than the buffer of the reader
sphere.SetPhiResolution(200)
with tempfile.TemporaryDirectory() as folder:
    file = os.path.join(folder, "sphere.vtp")
    writer.SetInputConnection(sphere.GetOutputPort())
    writer.SetFileName(file)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.Write()
    reader.SetFileName(file)
    reader.Update()
sys.exit(reader.GetOutput().GetNumberOfPoints() != sphere.GetOutput().GetNumberOfPoints())
