"""Origami as bars and hinges, written independently in NumPy: a second method that shares no code with
Kirireel.

Use: bar_and_hinge.py make miura|kresling FOLDER   writes model.fold and scene.toml
     bar_and_hinge.py check miura|kresling FOLDER RUN
prints by how much the forces and energies of a run miss those of this script at the same
displacements (parts of the largest), the least stiffness on the way, and the force's largest size.

The geometry is that of MERLIN's examples (Liu and Paulino 2017): a Miura sheet with panels of 60
degrees and sides of 2, pulled at one side; a storey of a Kresling tower on an octagon of radius 1,
1 high and turned by 45 degrees, pressed from above. Quads are cut along their shorter diagonal.
Gradients come from complex steps of the energy, second derivatives from differences of those.
"""
import csv
import json
import sys

import numpy as np

CASES = {
    "miura": {"E": 1e7, "nu": 0.3, "t": 0.01, "k": 0.1, "move": 0.8},
    "kresling": {"E": 1e6, "nu": 0.3, "t": 0.005, "k": 2e-3, "move": -0.8},
}


def miura(cells=3, theta=np.pi / 3, a=2, b=2, gamma=np.pi / 4):
    """Nodes, faces, and which nodes are held and guided along which axis."""
    count = 2 * cells
    h, tan = a * np.sin(theta) * np.sin(gamma), np.cos(gamma) * np.tan(theta)
    s, v = b * tan / np.sqrt(1 + tan**2), b / np.sqrt(1 + tan**2)
    l = a * np.sqrt(1 - (np.sin(gamma) * np.sin(theta))**2)
    node = lambda i, j: i * (count + 1) + j
    points = [(s * i, l * j + v * (i % 2), h * (j % 2))
              for i in range(count + 1) for j in range(count + 1)]
    faces = [[node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]
             for j in range(count) for i in range(count)]
    left = [node(0, j) for j in range(count + 1)]
    right = [node(count, j) for j in range(count + 1)]
    held = [(n, 0) for n in left] + [(n, 2) for n in left[::2] + right[::2]] + [(0, 1)]
    return np.array(points), faces, held, [(n, 0) for n in right]


def kresling(sides=8, height=1, turn=np.pi / 4):
    ring = lambda z, turn: [(np.cos(turn + 2 * np.pi * k / sides), np.sin(turn + 2 * np.pi * k / sides), z)
                            for k in range(sides)]
    faces = []
    for k in range(sides):
        n = (k + 1) % sides
        faces += [[k, n, sides + k], [sides + k, n, sides + n]]
    points = np.array(ring(0, 0) + ring(height, turn))
    held = [(n, axis) for n in range(sides) for axis in range(3)]
    return points, faces, held, [(sides + k, 2) for k in range(sides)]


GEOMETRIES = {"miura": miura, "kresling": kresling}


def make(case, folder):
    points, faces, held, guided = GEOMETRIES[case]()
    values = CASES[case]
    with open(f"{folder}/model.fold", "w") as file:
        json.dump({"file_spec": 1.2, "vertices_coords": points.tolist(), "faces_vertices": faces}, file)
    place = {n: (f, face.index(n)) for f, face in enumerate(faces) for n in face}
    with open(f"{folder}/scene.toml", "w") as file:
        file.write(f"""[model]
thickness = {values["t"]}
hinge_stiffness = {values["k"]}
panels = "{values["E"]},{values["nu"]}"
""")
        for n, axis in held:
            tile, vertex = place[n]
            file.write(f"[[grip]]\ntile = {tile}\nvertex = {vertex}\nmove = {{{'xyz'[axis]} = 0}}\n")
        # All guided nodes are one grip, whose force is the sum.
        file.write(f"[[grip]]\ntiles = {[place[n][0] for n, _ in guided]}\n"
                   f"vertex = {[place[n][1] for n, _ in guided]}\n"
                   f"move = {{{'xyz'[guided[0][1]]} = {values['move']}}}\n")


def triangles_of(points, faces):
    """Triangles, each with the number of its face."""
    found = []
    for f, face in enumerate(faces):
        if len(face) == 3:
            found.append((f, face))
            continue
        a, b, c, d = face
        if np.linalg.norm(points[a] - points[c]) <= np.linalg.norm(points[b] - points[d]):
            found += [(f, [a, b, c]), (f, [a, c, d])]
        else:
            found += [(f, [b, c, d]), (f, [b, d, a])]
    return found


def angles(x):
    """Angles of folds at positions (fold, node, axis), which may be complex."""
    p, q, r, s = (x[:, k] for k in range(4))
    e = q - p
    n, m = np.cross(e, r - p), np.cross(s - p, e)
    dot = lambda u, v: (u * v).sum(axis=-1)
    sine, cosine = dot(e, np.cross(m, n)) / np.sqrt(dot(e, e)), dot(n, m)
    return 2 * np.arctan(sine / (cosine + np.sqrt(cosine**2 + sine**2)))


def coordinates(nodes):
    return (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), -1)


def slopes(energies, places):
    """The derivatives of element energies by their own coordinates, by complex steps."""
    columns = []
    for k in range(places[0].size):
        step = np.zeros(places[0].size, complex)
        step[k] = 1e-30j
        columns.append(energies(places + step.reshape(places[0].shape)).imag / 1e-30)
    return np.stack(columns, axis=1)


class Sheet:
    def __init__(self, points, faces, E, nu, t, k, move):
        self.start = points
        plate = E * t**3 / (12 * (1 - nu**2))
        edges = {}
        for f, (a, b, c) in triangles_of(points, faces):
            sides = [np.linalg.norm(points[p] - points[q]) for p, q in ((a, b), (b, c), (c, a))]
            half = sum(sides) / 2
            area = np.sqrt(half * np.prod([half - s for s in sides]))  # Heron
            for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
                edges.setdefault(frozenset((p, q)), []).append((f, p, q, r, area * t / ((1 - nu) * half)))
        self.bars, self.folds = [], []
        for edge, users in edges.items():
            p, q = sorted(edge)
            length = np.linalg.norm(points[p] - points[q])
            self.bars.append((p, q, length, E * sum(user[4] for user in users) / length))
            if len(users) < 2:
                continue
            (f, p, q, r, _), (g, _, _, s, _) = users
            stiffness = k
            if f == g:
                corners = [points[n] for n in (p, s, q, r)]
                skew = 0
                for i in range(4):
                    u, w = corners[(i + 1) % 4] - corners[i], corners[i - 1] - corners[i]
                    skew += abs(np.arccos(u @ w / np.sqrt((u @ u) * (w @ w))) - np.pi / 2)
                stiffness = (0.55 - 0.42 * skew / np.pi) * plate * (length / t)**(1 / 3)
            self.folds.append((p, q, r, s, stiffness))
        self.b = np.array([bar[:2] for bar in self.bars])
        self.l0, self.kb = np.array([bar[2:] for bar in self.bars]).T
        self.f = np.array([fold[:4] for fold in self.folds])
        self.kf = np.array([fold[4] for fold in self.folds])
        self.rest = angles(points[self.f])

    def parts(self):
        """The nodes of elements, and their energies at their positions (element, node, axis)."""
        def of_bars(x):
            d = x[:, 1] - x[:, 0]
            return 0.5 * self.kb * (np.sqrt((d * d).sum(axis=-1)) - self.l0)**2
        return ((self.b, of_bars), (self.f, lambda x: 0.5 * self.kf * (angles(x) - self.rest)**2))

    def energy(self, x):
        return sum(energies(x[nodes]).sum() for nodes, energies in self.parts())

    def gradient(self, x):
        total = np.zeros(x.size)
        for nodes, energies in self.parts():
            np.add.at(total, coordinates(nodes), slopes(energies, x[nodes]))
        return total

    def hessian(self, x):
        h, total = 1e-6, np.zeros((x.size, x.size))
        for nodes, energies in self.parts():
            places = x[nodes]
            for k in range(places[0].size):
                step = np.zeros(places[0].size)
                step[k] = h
                step = step.reshape(places[0].shape)
                change = (slopes(energies, places + step) - slopes(energies, places - step)) / (2 * h)
                np.add.at(total, (coordinates(nodes)[:, k, None], coordinates(nodes)), change)
        return (total + total.T) / 2

    def balance(self, x, free, is_singular):
        """The equilibrium near a state, by Newton's method on the free coordinates, until it gains
        no more digits. In a singular state, motions without stiffness get no step."""
        least = np.inf
        for _ in range(200):
            slope = self.gradient(x)[free]
            size = np.abs(slope).max()
            if size < 1e-8 and size > 0.5 * least:
                return x
            least = min(least, size)
            stiffness = self.hessian(x)[free][:, free]
            step = (np.linalg.lstsq(stiffness, slope, rcond=1e-7)[0] if is_singular
                    else np.linalg.solve(stiffness, slope))
            x = x.copy()
            x.flat[free] -= min(1, 0.2 / np.abs(step).max()) * step
        raise SystemExit("no equilibrium was found")


def check(case, run):
    points, faces, held, guided = GEOMETRIES[case]()
    sheet = Sheet(points, faces, **CASES[case])
    rows = list(csv.DictReader(open(f"{run}/load_curve.csv")))
    grip = f"grip_{len(held) + 1}_{'xyz'[guided[0][1]]}"
    moved = [3 * n + a for n, a in guided]
    fixed = set(moved) | {3 * n + a for n, a in held}
    free = np.array([k for k in range(points.size) if k not in fixed])
    x, before, forces, energies = points.astype(float), None, [], []
    for row in rows:
        guess = x.copy() if before is None else 2 * x - before
        guess.flat[moved] = points.flat[moved] + float(row[f"{grip}_m"])
        before, x = x, sheet.balance(guess, free, row["turning"] == "bifurcation")
        forces.append(sheet.gradient(x)[moved].sum())
        energies.append(sheet.energy(x))
    own = np.array([float(row[f"{grip}_force_N"]) for row in rows])
    forces, energies = np.array(forces), np.array(energies)
    print(abs(own - forces).max() / abs(forces).max())
    print(abs(np.array([float(row["energy_J"]) for row in rows]) - energies).max() / energies.max())
    print(min(float(row[f"{grip}_stiffness_N_per_m"]) for row in rows))
    print(abs(forces).max())


if __name__ == "__main__":
    if sys.argv[1] == "make":
        make(sys.argv[2], sys.argv[3])
    else:
        check(sys.argv[2], sys.argv[4])
