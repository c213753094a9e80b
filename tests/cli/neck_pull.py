"""Pulls a flat sheet of necks by CalculiX, in its own plane and with large displacements.

Use: neck_pull.py DECK THICKNESS E NU HELD MOVED DISPLACEMENT INCREMENTS [RUN]
DECK is a mesh of plane stress elements with sets of tiles; HELD and MOVED are lists of tiles (0,1,2)
whose middles keep their x, or are moved along it; the first of HELD keeps its y. Prints the
displacement and the force in N after each increment, then the CPU seconds that CalculiX took. With
a RUN whose third grip moves in the same way, each line ends with that run's force at the displacement.
"""
import csv
import os
import resource
import subprocess
import sys
import tempfile


def read(path):
    """The lines of the mesh, its nodes, the nodes of each tile and the corners of its elements."""
    lines = [line for line in open(path) if not line.startswith("**")]
    nodes, tiles, cells, section = {}, {}, {}, ""
    for line in lines:
        if line.startswith("*"):
            section = line.strip()
            continue
        words = [word for word in line.replace(" ", "").strip().split(",") if word]
        if section.startswith("*NODE"):
            nodes[int(words[0])] = (float(words[1]), float(words[2]))
        elif section.startswith("*ELEMENT") and "ELSET=TILE_" in section:
            tile = int(section.split("ELSET=TILE_")[1])
            cells.setdefault(tile, []).append([int(word) for word in words[1:5]])
        elif section.startswith("*NSET, NSET=TILE_") and section.endswith("_N"):
            tile = int(section.split("TILE_")[1].split("_")[0])
            tiles.setdefault(tile, []).extend(map(int, words))
    return lines, nodes, tiles, cells


def middle(nodes, members, cells):
    """The node next to a tile's centre of mass, that of its elements."""
    area, x, y = 0, 0, 0
    for cell in cells:
        corners = [nodes[n] for n in cell]
        for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
            part = ax * by - ay * bx
            area, x, y = area + part / 2, x + (ax + bx) * part / 6, y + (ay + by) * part / 6
    return min(members,
               key=lambda n: (nodes[n][0] - x / area) ** 2 + (nodes[n][1] - y / area) ** 2)


def force_of(run, displacement):
    """A run's force between two of its states."""
    rows = [(abs(float(row["grip_3_x_m"])), float(row["grip_3_x_force_N"]))
            for row in csv.DictReader(open(f"{run}/load_curve.csv"))]
    for (a, below), (b, above) in zip(rows, rows[1:]):
        if b >= abs(displacement) - 1e-12:
            return below + (above - below) * (abs(displacement) - a) / (b - a)
    raise SystemExit(f"{run} ends before {displacement} m")


def main():
    deck, thickness, youngs, poisson, held, moved, displacement, increments, *runs = sys.argv[1:]
    lines, nodes, tiles, cells = read(deck)
    middles = {tile: middle(nodes, members, cells[tile]) for tile, members in tiles.items()}
    held, moved = ([middles[int(k)] for k in words.split(",")] for words in (held, moved))
    step = 1 / int(increments)
    text = "".join(lines) + f"""*MATERIAL, NAME=SHEET
*ELASTIC
{youngs}, {poisson}
*SOLID SECTION, ELSET=EALL, MATERIAL=SHEET
{thickness}
*NSET, NSET=MOVED
{chr(10).join(f"{n}," for n in moved)}
*BOUNDARY
{held[0]}, 2, 2
{chr(10).join(f"{n}, 1, 1" for n in held)}
*STEP, NLGEOM, INC=100000
*STATIC, DIRECT
{step}, 1.
*BOUNDARY
{chr(10).join(f"{n}, 1, 1, {displacement}" for n in moved)}
*NODE PRINT, NSET=MOVED, TOTALS=ONLY
RF
*END STEP
"""
    with tempfile.TemporaryDirectory() as folder:
        with open(folder + "/job.inp", "w") as file:
            file.write(text)
        done = subprocess.run(["ccx", "-i", "job"], cwd=folder, capture_output=True, text=True,
                              env={**os.environ, "OMP_NUM_THREADS": "1"})
        if "Job finished" not in done.stdout:
            raise SystemExit("ccx failed: " + done.stdout[-300:])
        words = open(folder + "/job.dat").read().split("\n")
    rows = [line.split() for line in words if line.strip()]
    times = [float(row[-1]) for row in rows if row[0] == "total"]
    forces = [float(row[0]) for row in rows if row[0] not in ("total", "forces")]
    for time, force in zip(times, forces):
        place = time * float(displacement)
        print(place, force, *(force_of(run, place) for run in runs))
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(used.ru_utime + used.ru_stime)


if __name__ == "__main__":
    main()
