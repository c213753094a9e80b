#!/usr/bin/env python3
"""The stiffness of flat sheets with E = 1 GPa and nu = 0.3, by CalculiX.

    sheet_stiffness.py pull MESH.inp            a deck of CPS8R, as it is
    sheet_stiffness.py pull PATTERN.dxf SIZE    a cut pattern, meshed here: triangles of SIZE at necks
    sheet_stiffness.py turn MESH.inp            two squares of 1 m side by side with a neck, a deck
    sheet_stiffness.py turn WIDTH LENGTH SIZE   the same, meshed here

pull: at the middles of the outer edges, one a metre, the left side stays and the right side moves by
4 mm; prints the force in N. turn: the left edge stays, a couple turns the right one; prints the
moment in Nm per radian. Both come from the strain energy. Then how many pieces the mesh has, and how
many elements. Shares no code with Kirireel: slits are lines of the layer "Slits", and elements on
both sides of one get nodes of their own.

Sheets are 0.02 m thick, for `turn` 0.002 m: CalculiX expands plane stress elements to solids whose
lines across the thickness stay straight, which makes a strip as narrow as it is thick 2.3% too stiff
in bending.
"""
import collections
import os
import re
import subprocess
import sys
import tempfile

MOVE = 0.004


def read_dxf(path):
    """Lines by layer: ((x, y), (x, y)), metres."""
    with open(path) as file:
        words = [line.strip() for line in file]
    metre = {"4": 1000, "6": 1}[words[words.index("$INSUNITS") + 2]]
    layers, entity = collections.defaultdict(list), None
    for code, value in zip(words[::2], words[1::2]):
        if code == "0":
            if entity and entity.get("0") == "LINE":
                ends = [float(entity[k]) / metre for k in ("10", "20", "11", "21")]
                layers[entity["8"].lower()].append((tuple(ends[:2]), tuple(ends[2:])))
            entity = {}
        if entity is not None:
            entity[code] = value
    return layers


def geometry(cuts, slits, size):
    """A Gmsh script: the box of the outline, slits as lines in it, fine at their ends."""
    xs = [p[0] for line in cuts for p in line]
    ys = [p[1] for line in cuts for p in line]
    text = ['SetFactory("OpenCASCADE");',
            f"Rectangle(1) = {{{min(xs)}, {min(ys)}, 0, {max(xs) - min(xs)}, {max(ys) - min(ys)}}};"]
    for k, (a, b) in enumerate(slits):
        text += [f"Point({1000 + 2 * k}) = {{{a[0]}, {a[1]}, 0}};",
                 f"Point({1001 + 2 * k}) = {{{b[0]}, {b[1]}, 0}};",
                 f"Line({1000 + k}) = {{{1000 + 2 * k}, {1001 + 2 * k}}};"]
    text += [f"BooleanFragments{{ Surface{{1}}; Delete; }}{{ Curve{{1000:{999 + len(slits)}}}; Delete; }}",
             "Physical Surface(1) = Surface{:};"]
    ends = sorted({p for line in slits for p in line})
    for k, (x, y) in enumerate(ends):
        text += [f"Field[{k + 1}] = Ball;", f"Field[{k + 1}].XCenter = {x};",
                 f"Field[{k + 1}].YCenter = {y};", f"Field[{k + 1}].Radius = {2 * size};",
                 f"Field[{k + 1}].VIn = {size};", f"Field[{k + 1}].VOut = 0.1;",
                 f"Field[{k + 1}].Thickness = 0.4;"]
    text += [f"Field[{len(ends) + 1}] = Min;",
             f"Field[{len(ends) + 1}].FieldsList = {{1:{len(ends)}}};",
             f"Background Field = {len(ends) + 1};", "Mesh.MeshSizeExtendFromBoundary = 0;",
             "Mesh.MeshSizeFromPoints = 0;", "Mesh.ElementOrder = 2;"]
    return "\n".join(text) + "\n"


def read_msh(path):
    """Points by number, and triangles of six nodes; format 2.2."""
    points, cells = {}, []
    with open(path) as file:
        section = None
        for line in file:
            words = line.split()
            if words[0].startswith("$"):
                section = words[0]
            elif section == "$Nodes" and len(words) == 4:
                points[int(words[0])] = tuple(map(float, words[1:3]))
            elif section == "$Elements" and len(words) > 1 and words[1] == "9":
                cells.append([int(word) for word in words[-6:]])
    return points, cells


def is_on(p, line, tiny=1e-9):
    (ax, ay), (bx, by) = line
    length = ((bx - ax) ** 2 + (by - ay) ** 2) ** 0.5
    across = abs((p[0] - ax) * (by - ay) - (p[1] - ay) * (bx - ax)) / length
    along = ((p[0] - ax) * (bx - ax) + (p[1] - ay) * (by - ay)) / length
    return across < tiny and -tiny < along < length + tiny


def open_slits(points, cells, slits):
    """Gives cells on different sides of slits separate nodes."""
    sides = collections.defaultdict(list)
    for c, cell in enumerate(cells):
        for k in range(3):
            sides[frozenset((cell[k], cell[(k + 1) % 3]))].append((c, k))
    for edge in list(sides):
        if any(all(is_on(points[n], line) for n in edge) for line in slits):
            del sides[edge]
    old = [list(cell) for cell in cells]
    around = collections.defaultdict(list)
    for c, cell in enumerate(cells):
        for k in range(6):
            around[cell[k]].append((c, k))
    # Cells around a node belong together if they share a side that is not a slit.
    for node, users in around.items():
        group = {c: c for c, _ in users}

        def root(c):
            while group[c] != c:
                c = group[c]
            return c
        for c, k in users:
            ends = [k, (k + 2) % 3] if k < 3 else [k - 3]
            for side in ends:
                edge = frozenset((old[c][side % 3], old[c][(side + 1) % 3]))
                for other, _ in sides.get(edge, []):
                    if other in group:
                        group[root(other)] = root(c)
        roots = sorted({root(c) for c, _ in users})
        for extra in roots[1:]:
            copy = len(points) + 1
            points[copy] = points[node]
            for c, k in users:
                if root(c) == extra:
                    cells[c][k] = copy


def read_inp(path):
    """The nodes and plane elements of a deck."""
    points, cells, section = {}, [], ""
    with open(path) as file:
        for line in file:
            if line.startswith("*"):
                section = line.upper() if not line.startswith("**") else section
            elif section.startswith("*NODE"):
                words = line.split(",")
                points[int(words[0])] = (float(words[1]), float(words[2]))
            elif section.startswith("*ELEMENT,") and "CPS" in section:
                cells.append([int(word) for word in line.split(",")[1:]])
    return points, cells


def pieces(cells):
    parent = {}

    def root(n):
        while parent.setdefault(n, n) != n:
            parent[n] = parent[parent[n]]
            n = parent[n]
        return n
    for cell in cells:
        for node in cell[1:]:
            parent[root(node)] = root(cell[0])
    return len({root(n) for n in list(parent)})


def at_edge_point(points, cells, x, y):
    """Nodes and weights that make the displacement at a point of an upright outer edge."""
    for cell in cells:
        corners = len(cell) // 2
        for k in range(corners):
            a, b, middle = cell[k], cell[(k + 1) % corners], cell[corners + k]
            if abs(points[a][0] - x) > 1e-9 or abs(points[b][0] - x) > 1e-9:
                continue
            s = (2 * y - points[a][1] - points[b][1]) / (points[b][1] - points[a][1])
            if abs(s) <= 1 + 1e-9:
                weights = [(a, s * (s - 1) / 2), (b, s * (s + 1) / 2), (middle, 1 - s * s)]
                return sorted(((n, w) for n, w in weights if abs(w) > 1e-9), key=lambda p: -abs(p[1]))
    raise SystemExit(f"no edge at {x}, {y}")


def two_squares(width, length, size):
    """A Gmsh script: squares on both sides of x = 1, a slit between them that ends at a neck below."""
    a, b = 1 - length / 2, 1 + length / 2
    # Around the left tile, the right tile; the slit's two sides are separate lines.
    corners = [(0, 0), (a, 0), (a, width), (a, 2 * width), (1, 2 * width), (1, 1), (0, 1),
               (2, 0), (2, 1), (1, 1), (1, 2 * width), (b, 2 * width), (b, width), (b, 0)]
    text = [f"Point({k + 1}) = {{{x}, {y}, 0}};" for k, (x, y) in enumerate(corners)]
    lines = {}

    def loop(number, nodes):
        signed = []
        for p, q in zip(nodes, nodes[1:] + nodes[:1]):
            if (min(p, q), max(p, q)) not in lines:
                lines[min(p, q), max(p, q)] = len(lines) + 1
                text.append(f"Line({len(lines)}) = {{{min(p, q)}, {max(p, q)}}};")
            line = lines[min(p, q), max(p, q)]
            signed.append(str(line if p < q else -line))
        text.extend([f"Curve Loop({number}) = {{{', '.join(signed)}}};",
                     f"Plane Surface({number}) = {{{number}}};"])
    loop(1, [1, 2, 3, 4, 5, 6, 7])
    loop(2, [8, 9, 10, 11, 12, 13, 14])
    loop(3, [2, 14, 13, 3])
    text += ["Physical Surface(1) = {1, 2, 3};"]
    for k, at in enumerate((2, 3, 13, 14)):
        x, y = corners[at - 1]
        text += [f"Field[{k + 1}] = Ball;", f"Field[{k + 1}].XCenter = {x};",
                 f"Field[{k + 1}].YCenter = {y};", f"Field[{k + 1}].Radius = {width};",
                 f"Field[{k + 1}].VIn = {size};", f"Field[{k + 1}].VOut = 0.1;",
                 f"Field[{k + 1}].Thickness = 0.4;"]
    text += ["Field[5] = Min;", "Field[5].FieldsList = {1:4};", "Background Field = 5;",
             "Mesh.MeshSizeExtendFromBoundary = 0;", "Mesh.MeshSizeFromPoints = 0;",
             "Mesh.ElementOrder = 2;"]
    return "\n".join(text) + "\n"


def model(points, cells, thickness):
    kind = {6: "CPS6", 8: "CPS8R"}[len(cells[0])]
    text = ["*NODE, NSET=NALL"] + [f"{n}, {x:.12g}, {y:.12g}, 0." for n, (x, y) in points.items()]
    text.append(f"*ELEMENT, TYPE={kind}, ELSET=EALL")
    text += [", ".join(map(str, [k + 1] + cell)) for k, cell in enumerate(cells)]
    return text + ["*MATERIAL, NAME=SHEET", "*ELASTIC", "1.e9, 0.3",
                   "*SOLID SECTION, ELSET=EALL, MATERIAL=SHEET", str(thickness)]


REQUEST = ["*EL PRINT, ELSET=EALL, TOTALS=ONLY", "ELSE", "*END STEP", ""]


def turn_job(points, cells):
    held = [n for n in points if points[n][0] < 1e-9]

    def nearest(x, y):
        return min(points, key=lambda n: (points[n][0] - x) ** 2 + (points[n][1] - y) ** 2)
    text = model(points, cells, 0.002) + ["*BOUNDARY"] + [f"{n}, 1, 2" for n in held]
    text += ["*STEP", "*STATIC", "*CLOAD", f"{nearest(2, 0)}, 1, 1.", f"{nearest(2, 1)}, 1, -1."]
    return "\n".join(text + REQUEST)


def pull_job(points, cells):
    text = model(points, cells, 0.02)
    left, right = min(p[0] for p in points.values()), max(p[0] for p in points.values())
    low, high = min(p[1] for p in points.values()), max(p[1] for p in points.values())
    held, moved = max(points) + 1, max(points) + 2
    text += ["*NODE", f"{held}, {left}, {low}, 0.", f"{moved}, {right}, {low}, 0."]
    for x, reference in ((left, held), (right, moved)):
        for k in range(round(high - low)):
            terms = at_edge_point(points, cells, x, low + k + 0.5) + [(reference, -1.0)]
            text += ["*EQUATION", str(len(terms))]
            text += [f"{n}, 1, {w:.12f}" for n, w in terms]
    corner = min(points, key=lambda n: (points[n][0] - left) ** 2 + (points[n][1] - low) ** 2)
    text += ["*BOUNDARY", f"{corner}, 2, 2", f"{held}, 1, 3", f"{moved}, 2, 3",
             "*STEP", "*STATIC", "*BOUNDARY", f"{moved}, 1, 1, {MOVE}"]
    return "\n".join(text + REQUEST)


def run(words, folder):
    done = subprocess.run(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
    if done.returncode != 0 or "ERROR" in done.stdout:
        raise SystemExit(f"{words[0]} failed: {done.stdout[-300:]}")


def meshed(script, folder):
    with open(folder + "/sheet.geo", "w") as file:
        file.write(script)
    run(["gmsh", "-2", "sheet.geo", "-format", "msh22", "-o", "sheet.msh", "-nt", "1"], folder)
    points, cells = read_msh(folder + "/sheet.msh")
    numbers = {n: k + 1 for k, n in enumerate(sorted({n for cell in cells for n in cell}))}
    return ({numbers[n]: p for n, p in points.items() if n in numbers},
            [[numbers[n] for n in cell] for cell in cells])


def main():
    what, *given = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        if given[0].endswith(".inp"):
            points, cells = read_inp(given[0])
        elif what == "turn":
            points, cells = meshed(two_squares(*map(float, given)), folder)
        else:
            layers = read_dxf(given[0])
            points, cells = meshed(geometry(layers["cuts"], layers["slits"], float(given[1])), folder)
            open_slits(points, cells, layers["slits"])
        with open(folder + "/job.inp", "w") as file:
            file.write((pull_job if what == "pull" else turn_job)(points, cells))
        run(["ccx", "-i", "job"], folder)
        with open(folder + "/job.dat") as file:
            energy = float(re.search(r"total internal energy.*\n\s*\n\s*(\S+)", file.read()).group(1))
    # The work of a force F is F s / 2, of a couple of 1 Nm 1 / (2 k).
    stiffness = 2 * energy / MOVE if what == "pull" else 1 / (2 * energy)
    print(f"{stiffness:.6g} {pieces(cells)} {len(cells)}")


if __name__ == "__main__":
    main()
