#!/usr/bin/python3
"""An 80 mm sheet has 80 mm in every file, as measured by readers that are not ours.

    test_sizes.py quick|long

The same sheet is given in mm, in inches and in metres; the long test also places it upright.
Readers: meshio (STL, VTU, decks), Gmsh (MSH, STL, STEP), VTK (OBJ, PLY, GLB), librsvg (SVG), and
the declared units of a DXF, FOLD and text file. Returns 77 (skipped) without these packages.
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

try:
    import meshio
    import numpy as np
    from PIL import Image
    from vtkmodules.vtkIOGeometry import vtkGLTFReader, vtkOBJReader
    from vtkmodules.vtkIOPLY import vtkPLYReader
except ImportError as missing:
    print(f"skipped: {missing}; install python3-meshio, python3-pil, python3-vtk9")
    sys.exit(77)
for program in ("gmsh", "rsvg-convert"):
    if not shutil.which(program):
        print(f"skipped: no {program}")
        sys.exit(77)

PROGRAM = os.environ["KIRIREEL_PROGRAM"]
SIZE = 0.08  # metres, of the sheet as it is cut
UNITS = {"m": 1.0, "mm": 1e-3, "in": 0.0254, "cm": 1e-2, "um": 1e-6}
DXF_UNITS = {"1": 0.0254, "4": 1e-3, "5": 1e-2, "6": 1.0, "13": 1e-6}
# Relative: text and doubles, single precision, a picture's pixels.
TEXT, SINGLE, PIXEL = 1e-9, 2e-6, 2e-3


def run(*arguments):
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        raise SystemExit(f"{' '.join(arguments)}: {done.stderr}")


def widest(points):
    """The longest side of the box around points."""
    points = np.asarray(points, float)
    return float(np.ptp(points, axis=0).max())


def ofMesh(unit):
    return lambda file: widest(meshio.read(file).points) * unit


def ofGmsh(unit):
    def measure(file):
        script = file + ".geo"
        with open(script, "w") as text:
            text.write(f'Merge "{file}";\nBoundingBox;\nPrintf("box %.17g %.17g %.17g", General.MaxX - General.MinX, '
                       "General.MaxY - General.MinY, General.MaxZ - General.MinZ);\n")
        end = subprocess.run(["gmsh", script, "-0", "-v", "3"], capture_output=True, text=True)
        return max(map(float, re.search(r"box (\S+) (\S+) (\S+)", end.stdout + end.stderr).groups())) * unit
    return measure


def ofVtk(kind, unit):
    def measure(file):
        reader = kind()
        reader.SetFileName(file)
        reader.Update()
        return float(np.ptp(np.array(reader.GetOutput().GetBounds()).reshape(3, 2), axis=1).max()) * unit
    return measure


def ofGltf(file):
    reader = vtkGLTFReader()
    reader.SetFileName(file)
    reader.Update()
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    blocks = [reader.GetOutput()]
    while blocks:
        block = blocks.pop()
        if block is None:
            continue
        if hasattr(block, "GetNumberOfBlocks"):
            blocks += [block.GetBlock(k) for k in range(block.GetNumberOfBlocks())]
            continue
        bounds = np.array(block.GetBounds()).reshape(3, 2)
        low, high = np.minimum(low, bounds[:, 0]), np.maximum(high, bounds[:, 1])
    return float((high - low).max())


def ofSvg(file):
    """The width of the ink, drawn at 20 dots per millimetre."""
    picture = file + ".png"
    subprocess.run(["rsvg-convert", "--dpi-x", "508", "--dpi-y", "508", "--background-color", "white",
                    file, "-o", picture], check=True)
    ink = np.argwhere(np.asarray(Image.open(picture).convert("L")) < 200)
    return float(np.ptp(ink, axis=0).max()) / 20 * 1e-3


def ofDxf(file):
    words = [line.strip() for line in open(file)]
    unit = DXF_UNITS[words[words.index("$INSUNITS") + 2]]
    groups = list(zip(words[::2], words[1::2]))
    start = groups.index(("2", "ENTITIES"))
    across = [[float(value) for code, value in groups[start:] if code in codes] for codes in (("10", "11"), ("20", "21"))]
    return max(max(values) - min(values) for values in across) * unit


def ofFold(file):
    sheet = json.load(open(file))
    return widest(sheet["vertices_coords"]) * UNITS[sheet["frame_unit"]]


def ofText(unit):
    return lambda file: widest(np.concatenate(
        [np.array(line.split("#")[0].split(), float).reshape(-1, 3) for line in open(file) if line.strip()])) * unit


def write(folder, unit, upright):
    """16 squares of a rotating squares sheet, closed, four per side."""
    run("generate", "tessellation", folder, "--columns", "4", "--rows", "4")
    path = os.path.join(folder, "vertices.txt")
    tiles = [np.array(line.split("#")[0].split(), float).reshape(-1, 3) for line in open(path) if line.split("#")[0].split()]
    factor = SIZE / widest(np.concatenate(tiles)) / UNITS[unit]
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]) if upright else np.eye(3)
    for name in os.listdir(folder):
        if name != "constraints.txt":
            os.remove(os.path.join(folder, name))
    with open(path, "w") as file:
        for tile in tiles:
            file.write(" ".join(repr(float(x)) for x in (factor * tile @ turn.T).ravel()) + "\n")


def check(unit, upright, scratch):
    name = f"{unit}{' upright' if upright else ''}"
    folder, out = os.path.join(scratch, "sheet"), os.path.join(scratch, "out")
    write(folder, unit, upright)
    run("simulate", folder, "--unit", unit, "--out", out)
    own = UNITS[unit]
    thin = ["--elements-per-edge", "1", "--elements-through", "1"]
    formats = [("obj", ["--states", "0%"], [("VTK", ofVtk(vtkOBJReader, own), SINGLE)]),
               ("ply", ["--states", "0%"], [("VTK", ofVtk(vtkPLYReader, own), SINGLE)]),
               ("stl", ["--states", "0%"], [("meshio", ofMesh(1e-3), SINGLE), ("gmsh", ofGmsh(1e-3), SINGLE)]),
               ("vtu", ["--states", "0%"], [("meshio", ofMesh(own), TEXT)]),
               ("msh", ["--states", "0%", *thin], [("gmsh", ofGmsh(own), TEXT)]),
               ("inp", ["--states", "0%", *thin], [("meshio", ofMesh(1.0), SINGLE)]),
               ("inp", ["--states", "0%", *thin, "--deck-unit", "mm-N"], [("meshio", ofMesh(1e-3), SINGLE)]),
               ("vertices", ["--states", "0%"], [("text", ofText(own), TEXT)]),
               ("planar", ["--states", "0%"], [("VTK", ofVtk(vtkOBJReader, own), SINGLE)]),
               ("step", ["--states", "0%"], [("gmsh", ofGmsh(1e-3), SINGLE)]),
               ("glb", [], [("VTK", ofGltf, SINGLE)]),
               ("svg", [], [("librsvg", ofSvg, PIXEL)]),
               ("dxf", [], [("text", ofDxf, TEXT)]),
               ("fold", ["--states", "0%"], [("text", ofFold, TEXT)]),
               ("obj", ["--states", "0%", "--export-unit", "in"], [("VTK", ofVtk(vtkOBJReader, 0.0254), SINGLE)])]
    failed = 0
    for k, (form, options, readers) in enumerate(formats):
        to = os.path.join(scratch, f"{k}")
        run("export", out, "--format", form, *options, "--out", to)
        endings = {"vertices": ".txt", "planar": ".obj"}
        files = [n for n in sorted(os.listdir(to)) if n.endswith(endings.get(form, "." + form))]
        # The mesh of a deck, without its jobs.
        files = [n for n in files if form != "inp" or "*NODE," in open(os.path.join(to, n)).read()]
        for reader, measure, bound in readers:
            try:
                size = measure(os.path.join(to, files[0]))
            except Exception as error:  # of a reader, with the reason of the refusal
                failed += 1
                print(f"{name}, {form} by {reader}: {type(error).__name__} {error} FAILS")
                continue
            off = abs(size / SIZE - 1)
            good = off <= bound
            failed += not good
            print(f"{name}, {form} {' '.join(options[2:])} by {reader}: {1e3 * size:.9g} mm, off by {off:.1g}"
                  + ("" if good else " FAILS"))
    return failed


def main():
    cases = [("mm", False)]
    if sys.argv[1] == "long":
        cases += [("m", False), ("in", False), ("um", True), ("mm", True)]
    failed = 0
    for unit, upright in cases:
        with tempfile.TemporaryDirectory() as scratch:
            failed += check(unit, upright, scratch)
    print(f"{failed} failed" if failed else "80 mm each time")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
