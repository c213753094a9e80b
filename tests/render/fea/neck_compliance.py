#!/usr/bin/env python3
"""The compliance of two tiles at the neck between them, by CalculiX, E = 1 GPa and nu = 0.3.

    neck_compliance.py MESH.inp WIDTH [MOMENT]    a deck of CPS8R: two tiles that lie left and
                                         right of x = 1 with an edge each from (1, 0) to (1, 1),
                                         joined by a neck at (1, 0), 0.002 m thick

A tile's motion is the mean of what its points do, weighed by area: a translation and a turn. Tiles
are loaded by what does work on these, forces spread over their areas that pull, shear and bend the
neck, one after the other. Prints what they give, without dimensions:

    bend      E t w^2 / k: the turn of a tile against the other per moment
    axis      the distance, over w, of the axis from the corner, about which a moment turns them
    stretch   E t times how far they part at the axis per force along x through it
    shear     E t times how far they slide along y at the corner per force along y

With a MOMENT in N m, above 0 if it closes the slit, instead ten of its parts, with large
displacements: the turn in radians, and the moment.
"""
import itertools
import math
import os
import subprocess
import sys
import tempfile

YOUNGS, THICKNESS, CORNER = 1e9, 0.002, (1.0, 0.0)
GAUSS = [(0.0, 8 / 9), (0.6 ** 0.5, 5 / 9), (-(0.6 ** 0.5), 5 / 9)]


def read(path):
    """The lines of the mesh, its nodes, and the elements of each set of elements."""
    lines = [line for line in open(path) if not line.startswith("**")]
    nodes, sets, section = {}, {}, ""
    for line in lines:
        if line.startswith("*"):
            section = line.replace(" ", "").strip()
            continue
        words = line.replace(" ", "").strip().strip(",").split(",")
        if section.startswith("*NODE,"):
            nodes[int(words[0])] = (float(words[1]), float(words[2]))
        elif section.startswith("*ELEMENT,"):
            sets.setdefault(section.split("ELSET=")[1], []).append([int(w) for w in words[1:]])
    return lines, nodes, sets


def shape(x, y):
    """The eight shape functions of a serendipity element."""
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    middles = [(0, -1), (1, 0), (0, 1), (-1, 0)]
    values = [(1 + a * x) * (1 + b * y) * (a * x + b * y - 1) / 4 for a, b in corners]
    return values + [(1 - x * x) * (1 + b * y) / 2 if a == 0 else (1 + a * x) * (1 - y * y) / 2
                     for a, b in middles]


def shares(nodes, elements):
    """The area of a tile that each of its nodes represents. Elements have straight sides."""
    found = {}
    for cell in elements:
        (x1, y1), (x2, y2), (x3, y3), (x4, y4) = (nodes[n] for n in cell[:4])
        for (x, wx), (y, wy) in itertools.product(GAUSS, GAUSS):
            ax = ((x2 - x1) * (1 - y) + (x3 - x4) * (1 + y)) / 4
            ay = ((y2 - y1) * (1 - y) + (y3 - y4) * (1 + y)) / 4
            bx = ((x4 - x1) * (1 - x) + (x3 - x2) * (1 + x)) / 4
            by = ((y4 - y1) * (1 - x) + (y3 - y2) * (1 + x)) / 4
            for node, value in zip(cell, shape(x, y)):
                found[node] = found.get(node, 0) + wx * wy * (ax * by - ay * bx) * value
    return found


def motion(nodes, area, sign):
    """Weights of the nodes in a tile's mean translation at the corner and its rotation: three rows."""
    whole = sum(area.values())
    middle = [sum(a * nodes[n][k] for n, a in area.items()) / whole for k in (0, 1)]
    arms = {n: (nodes[n][0] - middle[0], nodes[n][1] - middle[1]) for n in area}
    polar = sum(a * (arms[n][0] ** 2 + arms[n][1] ** 2) for n, a in area.items())
    rx, ry = CORNER[0] - middle[0], CORNER[1] - middle[1]
    rows = [{}, {}, {}]
    for n, a in area.items():
        turn = (-sign * a * arms[n][1] / polar, sign * a * arms[n][0] / polar)
        rows[0][n] = (sign * a / whole - ry * turn[0], -ry * turn[1])
        rows[1][n] = (rx * turn[0], sign * a / whole + rx * turn[1])
        rows[2][n] = turn
    return rows


def solve(lines, loads, held, step="*STEP\n*STATIC\n"):
    """The displacements of all nodes under each load."""
    text = "".join(lines) + f"*MATERIAL, NAME=SHEET\n*ELASTIC\n{YOUNGS}, 0.3\n"
    text += f"*SOLID SECTION, ELSET=EALL, MATERIAL=SHEET\n{THICKNESS}\n"
    text += f"*BOUNDARY\n{held[0]}, 1, 2\n{held[1]}, 2, 2\n"
    for load in loads:
        text += step + "*CLOAD, OP=NEW\n"
        for node, force in load.items():
            text += "".join(f"{node}, {k + 1}, {force[k]:.11g}\n" for k in (0, 1))
        text += "*NODE PRINT, NSET=NALL\nU\n*END STEP\n"
    with tempfile.TemporaryDirectory() as folder:
        with open(folder + "/job.inp", "w") as file:
            file.write(text)
        subprocess.run(["ccx", "-i", "job"], cwd=folder, capture_output=True, check=True,
                       env={**os.environ, "OMP_NUM_THREADS": "1"})
        results = open(folder + "/job.dat").read().split("displacements")[1:]
    return [{int(w[0]): (float(w[1]), float(w[2]))
             for w in map(str.split, result.split("\n")[1:]) if len(w) == 4} for result in results]


def main():
    lines, nodes, sets = read(sys.argv[1])
    width = float(sys.argv[2])
    tiles = [shares(nodes, cells) for name, cells in sorted(sets.items()) if name[:4] == "TILE"]
    rows = [{}, {}, {}]
    for area, sign in zip(tiles, (-1, 1)):
        for row, part in zip(rows, motion(nodes, area, sign)):
            for node, (x, y) in part.items():
                before = row.get(node, (0, 0))
                row[node] = (before[0] + x, before[1] + y)
    held = [min(nodes, key=lambda n: (nodes[n][0] - x) ** 2 + (nodes[n][1] - 1) ** 2)
            for x in (0, 2)]
    if len(sys.argv) > 3:
        moment = float(sys.argv[3])
        load = {n: (moment * x, moment * y) for n, (x, y) in rows[2].items()}
        states = solve(lines, [load], held, "*STEP, NLGEOM\n*STATIC, DIRECT\n0.1, 1.\n")
        for k, u in enumerate(states):
            # For a single tile the mean is the sine of its rotation. Loads keep their directions.
            half = math.asin(sum(f[0] * u[n][0] + f[1] * u[n][1] for n, f in rows[2].items()) / 2)
            print(2 * half, 0.1 * (k + 1) * moment * math.cos(half))
        return
    gives = [[sum(f[0] * u[n][0] + f[1] * u[n][1] for n, f in row.items()) for row in rows]
             for u in solve(lines, rows, held)]
    scale = YOUNGS * THICKNESS
    bend, across = gives[2][2], gives[2][0]
    print(scale * bend * width ** 2, abs(across) / bend / width,
          scale * (gives[0][0] - across ** 2 / bend), scale * gives[1][1])


if __name__ == "__main__":
    main()
