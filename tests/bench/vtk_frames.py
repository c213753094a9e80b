"""Prints the milliseconds of CPU that a frame costs VTK's off-screen window: a sheet of squares that open,
edges drawn, 4 samples a pixel, read back. Use: vtk_frames.py SQUARES_A_SIDE FRAMES WIDTH HEIGHT"""
import math
import sys
import time

import vtk
from vtk.util import numpy_support
import numpy

side, frames, width, height = map(int, sys.argv[1:])
half, thickness = 0.5, 0.1
corners = numpy.array([(x, y, z) for z in (0, thickness) for x, y in
                       ((-half, -half), (half, -half), (half, half), (-half, half))])
faces = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
column, row = numpy.divmod(numpy.arange(side * side), side)


def places(angle):
    """The corners of all squares, the sheet opened by an angle."""
    pitch = math.cos(angle / 2) + math.sin(angle / 2)
    turn = numpy.where((column + row) % 2 == 0, angle / 2, -angle / 2)
    c, s = numpy.cos(turn)[:, None], numpy.sin(turn)[:, None]
    x = corners[:, 0] * c - corners[:, 1] * s + pitch * column[:, None]
    y = corners[:, 0] * s + corners[:, 1] * c + pitch * row[:, None]
    return numpy.stack([x, y, numpy.broadcast_to(corners[:, 2], x.shape)], axis=2).reshape(-1, 3)


numbers = numpy.ascontiguousarray(places(0))
points = vtk.vtkPoints()
points.SetData(numpy_support.numpy_to_vtk(numbers))
cells = vtk.vtkCellArray()
for brick in range(side * side):
    for face in faces:
        cells.InsertNextCell(4, [8 * brick + corner for corner in face])
sheet = vtk.vtkPolyData()
sheet.SetPoints(points)
sheet.SetPolys(cells)
mapper = vtk.vtkPolyDataMapper()
mapper.SetInputData(sheet)
actor = vtk.vtkActor()
actor.SetMapper(mapper)
actor.GetProperty().SetInterpolationToFlat()
actor.GetProperty().EdgeVisibilityOn()
renderer = vtk.vtkRenderer()
renderer.SetBackground(1, 1, 1)
renderer.AddActor(actor)
window = vtk.vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetMultiSamples(4)
window.SetSize(width, height)
window.AddRenderer(renderer)
numbers[:] = places(math.pi / 4)
points.Modified()
renderer.ResetCamera()
renderer.GetActiveCamera().Elevation(-45)
renderer.ResetCamera()
window.Render()
pixels = vtk.vtkUnsignedCharArray()

start = time.process_time()
for k in range(frames):
    numbers[:] = places(math.pi / 2 * k / frames)
    points.Modified()
    window.Render()
    window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, pixels)
print(1e3 * (time.process_time() - start) / frames)
