#!/usr/bin/python3
"""Sheets of panels under grips: the group panels of their trajectory.h5 against NumPy.

    test_panels.py quick|long

Lengths, strains and fold angles are computed again from the nodes only, by other formulas than the
program's. Energies and moments follow from them, and must be those of load_curve and of
summary.json. Bars, folds and their stiffness must be those of bar_and_hinge.py. Four sheets, each also
in millimetres, with its axes permuted, mirrored, and with nodes and faces in another order: the
energies must be the same. Prints the largest difference of each check and its bound; returns 1 if one is above,
77 (skipped) without NumPy or h5py. The program is $KIRIREEL_PROGRAM.
"""
import json
import os
import random
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}; install python3-numpy and python3-h5py")
    sys.exit(77)

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import bar_and_hinge  # noqa: E402

PROGRAM = os.environ["KIRIREEL_PROGRAM"]
LAYOUT = {  # name: unit, shape
    "bar_nodes": (None, ("bars", 2)), "bar_length": ("m", ("bars",)), "bar_stiffness": ("N/m", ("bars",)),
    "bar_strain": ("1", ("states", "bars")), "fold_nodes": (None, ("folds", 4)),
    "fold_tiles": (None, ("folds", 2)), "fold_stiffness": ("N m/rad", ("folds",)), "fold_rest": ("rad", ("folds",)),
    "fold_angle": ("rad", ("states", "folds")), "nodes": ("m", ("states", "nodes", 3)), "time": ("s", ("states",)),
    "vertex_node": (None, ("vertices",))}


# ------------------------------------------------------------------------------------------------
# Sheets: nodes, faces, held coordinates, moved nodes, their move; E, nu, thickness, stiffness of hinges.

def miura():
    points, faces, held, led = bar_and_hinge.miura(cells=2)
    return points, faces, held, [n for n, _ in led], (0, 0.6), (1e7, 0.3, 0.01, 0.1)


def kresling():
    points, faces, held, led = bar_and_hinge.kresling(sides=6, turn=np.pi / 3)
    return points, faces, held, [n for n, _ in led], (2, -0.15), (1e6, 0.3, 0.005, 2e-3)


def waterbomb():
    """Eight triangles around a vertex that is pressed down."""
    rim = [(np.cos(k * np.pi / 4), np.sin(k * np.pi / 4), 0.12 if k % 2 == 0 else -0.12) for k in range(8)]
    points = np.array([(0, 0, 0.35)] + rim)
    faces = [[0, 1 + k, 1 + (k + 1) % 8] for k in range(8)]
    held = [(2, 2), (4, 2), (6, 2), (8, 2), (8, 1), (6, 0), (4, 0)]
    return points, faces, held, [0], (2, -0.2), (1e7, 0.3, 0.01, 0.1)


def hypar(size=4):
    """Nested rhombi with alternating folds; two opposite corners are raised, the others held. The diagonals
    of the faces are not equal: all forms bend about the same."""
    points, faces, node = [(0, 0, 0)], [], lambda ring, corner: 1 + 4 * (ring - 1) + corner % 4
    for ring in range(1, size + 1):
        points += [(ring * np.cos(k * np.pi / 2), 1.1 * ring * np.sin(k * np.pi / 2), 0.1 * ring * (-1)**k + 0.05 * (ring % 2))
                   for k in range(4)]
    for k in range(4):
        faces.append([0, node(1, k), node(1, k + 1)])
        for ring in range(1, size):
            faces.append([node(ring, k), node(ring + 1, k), node(ring + 1, k + 1), node(ring, k + 1)])
    held = [(node(size, 1), axis) for axis in range(3)] + [(node(size, 3), 2), (node(size, 3), 0)]
    held += [(node(size, 0), 1)]
    return np.array(points, float), faces, held, [node(size, 0), node(size, 2)], (2, 0.4), (2e7, 0.3, 0.02, 0.05)


SHEETS = {"miura": miura, "kresling": kresling, "waterbomb": waterbomb, "hypar": hypar}
FORMS = ["as it is", "millimetres", "permuted axes", "mirrored", "renumbered"]


def changed(sheet, form):
    """The sheet in another form."""
    points, faces, held, led, (axis, move), material = sheet
    if form == "permuted axes":  # x to y, y to z, z to x
        points, held = np.roll(points, 1, axis=1), [(n, (a + 1) % 3) for n, a in held]
        axis = (axis + 1) % 3
    if form == "mirrored":
        points, move = points * [-1, 1, 1], -move if axis == 0 else move
    if form == "renumbered":
        chance = random.Random(7)
        order = list(range(len(points)))
        chance.shuffle(order)
        place = {n: k for k, n in enumerate(order)}
        turned = [[place[n] for n in face] for face in faces]
        turned = [face[s:] + face[:s] for face in turned for s in [chance.randrange(len(face))]]
        chance.shuffle(turned)
        points, faces = points[order], turned
        held, led = [(place[n], a) for n, a in held], [place[n] for n in led]
    return points, faces, held, led, (axis, move), material


def write(sheet, form, folder):
    points, faces, held, led, (axis, move), (E, nu, t, k) = sheet
    length = 1000 if form == "millimetres" else 1
    with open(f"{folder}/model.fold", "w") as file:
        json.dump({"file_spec": 1.2, "vertices_coords": (length * points).tolist(), "faces_vertices": faces}, file)
    place = {n: (f, face.index(n)) for f, face in enumerate(faces) for n in face}
    unit = 'unit = "mm"\n' if length != 1 else ""
    with open(f"{folder}/scene.toml", "w") as file:
        file.write(f'[model]\nno_align = true\n{unit}thickness = {length * t}\nhinge_stiffness = {k}\npanels = "{E},{nu}"\n')
        for n, a in held:
            file.write(f"[[grip]]\ntile = {place[n][0]}\nvertex = {place[n][1]}\nmove = {{{'xyz'[a]} = 0}}\n")
        file.write(f"[[grip]]\ntiles = {[place[n][0] for n in led]}\nvertex = {[place[n][1] for n in led]}\n"
                   f"move = {{{'xyz'[axis]} = {length * move}}}\n")


# ------------------------------------------------------------------------------------------------

def angles(x):
    """Signed angles between the parts of the wings that are normal to the edge; 0 if flat. x: (states x
    folds x 4 x 3), in the order of fold_nodes."""
    edge = x[..., 1, :] - x[..., 0, :]
    edge = edge / np.linalg.norm(edge, axis=-1, keepdims=True)
    wings = x[..., 2:, :] - x[..., :1, :]
    wings = wings - (wings * edge[..., None, :]).sum(-1, keepdims=True) * edge[..., None, :]
    left, right = wings[..., 0, :], wings[..., 1, :]
    up = np.cross(edge, left)  # normal of the left triangle
    return np.arctan2((right * up).sum(-1) * np.linalg.norm(left, axis=-1),
                      -(right * left).sum(-1) * np.linalg.norm(up, axis=-1))


class Table:
    def __init__(self):
        self.rows = {}

    def put(self, name, miss, bound):
        before = self.rows.get(name, (0, bound))[0]
        self.rows[name] = (max(before, float(miss)), bound)


def check(run, sheet, table):
    """Returns the energy at the end."""
    points, faces, held, led, (axis, move), (E, nu, t, k) = sheet
    with h5py.File(f"{run}/trajectory.h5") as file:
        panels = {name: file["panels"][name][()] for name in file["panels"]}
        units = {name: file["panels"][name].attrs.get("unit") for name in file["panels"]}
        curve = {name: file["load_curve"][name][()] for name in ("load", "energy", "displacement")}
        vertices, times = file["model/vertices"][()], file["time"][()]
    with open(f"{run}/summary.json") as file:
        elasticity = json.load(file)["elasticity"]
    assert set(panels) == set(LAYOUT), set(panels) ^ set(LAYOUT)
    sizes = {"states": len(curve["load"]), "bars": len(panels["bar_length"]), "folds": len(panels["fold_rest"]),
             "nodes": len(points), "vertices": len(vertices)}
    for name, (unit, shape) in LAYOUT.items():
        assert panels[name].shape == tuple(sizes.get(s, s) for s in shape), (name, panels[name].shape)
        assert (units[name].decode() if units[name] is not None else None) == unit, (name, units[name])

    nodes, a, b = panels["nodes"], panels["bar_nodes"][:, 0], panels["bar_nodes"][:, 1]
    size = np.ptp(points, axis=0).max()
    table.put("nodes at the start, of the size", abs(nodes[0][panels["vertex_node"]] - vertices).max() / size, 1e-12)
    table.put("moves of the grip, of the size", abs(
        (nodes[:, [np.argmin(abs(nodes[0] - points[n]).sum(1)) for n in led], axis]
         - nodes[0][[np.argmin(abs(nodes[0] - points[n]).sum(1)) for n in led], axis]).mean(1)
        - curve["displacement"][:, -1]).max() / size, 1e-12)
    table.put("time of the last state, s", abs(panels["time"][-1] - times[-1]), 1e-12)
    assert (np.diff(panels["time"]) >= 0).all() and panels["time"][0] == 0

    lengths = np.linalg.norm(nodes[:, b] - nodes[:, a], axis=-1)
    strains = lengths / panels["bar_length"] - 1
    turned = angles(nodes[:, panels["fold_nodes"]])
    table.put("strains", abs(strains - panels["bar_strain"]).max(), 1e-14)
    table.put("fold angles, rad", abs(turned - panels["fold_angle"]).max(), 1e-13)

    def energy(strain, angle):
        return (0.5 * panels["bar_stiffness"] * (strain * panels["bar_length"])**2).sum(-1) + (
            0.5 * panels["fold_stiffness"] * (angle - panels["fold_rest"])**2).sum(-1)
    largest = curve["energy"].max()
    table.put("energy by the strains of the file, of the largest",
              abs(energy(panels["bar_strain"], panels["fold_angle"]) - curve["energy"]).max() / largest, 1e-12)
    # An error of 1e-15 in a strain, times the largest forces.
    table.put("energy by the nodes, of the largest", abs(energy(strains, turned) - curve["energy"]).max() / largest, 1e-9)
    table.put("energy at the end in the summary, relative", abs(elasticity["energy_end"] / curve["energy"][-1] - 1), 1e-12)
    table.put("energy at the start in the summary, of the largest", abs(elasticity["energy_start"]) / largest, 1e-12)
    moment = abs(panels["fold_stiffness"] * (turned[-1] - panels["fold_rest"])).max()
    table.put("moment at the end in the summary, relative", abs(elasticity["moment_end"] / moment - 1), 1e-9)
    assert (elasticity["bars"], elasticity["folds"]) == (sizes["bars"], sizes["folds"])

    # The same sheet from bar_and_hinge.py; its nodes are those of the FOLD file.
    other = bar_and_hinge.Sheet(points, faces, E, nu, t, k, move)
    number = [int(np.argmin(abs(points - node).sum(1))) for node in nodes[0]]
    bars = {frozenset((number[p], number[q])): row for row, (p, q) in enumerate(panels["bar_nodes"])}
    folds = {frozenset((number[f[0]], number[f[1]])): row for row, f in enumerate(panels["fold_nodes"])}
    assert len(bars) == len(other.b) and len(folds) == len(other.f)
    row = [bars[frozenset(map(int, bar))] for bar in other.b]
    table.put("stiffness of bars, relative", abs(panels["bar_stiffness"][row] / other.kb - 1).max(), 1e-12)
    row = [folds[frozenset(map(int, fold[:2]))] for fold in other.f]
    table.put("stiffness of folds, relative", abs(panels["fold_stiffness"][row] / other.kf - 1).max(), 1e-12)
    for tiles, fold in zip(panels["fold_tiles"], panels["fold_nodes"]):
        edge = {number[fold[0]], number[fold[1]]}
        for tile, wing in zip(tiles, fold[2:]):
            assert edge | {number[wing]} <= set(faces[tile]), (tile, fold)
    return curve["energy"][-1]


def main(extent):
    table, failed = Table(), False
    with tempfile.TemporaryDirectory() as folder:
        for count, (name, make) in enumerate(SHEETS.items()):
            energies = {}
            for form in FORMS if extent == "long" else [FORMS[0], FORMS[1 + count]]:
                sheet = changed(make(), form)
                write(sheet, form, folder)
                run = f"{folder}/run"
                ended = subprocess.run([PROGRAM, "simulate", f"{folder}/model.fold", "--scene", f"{folder}/scene.toml",
                                        "--out", run], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                if ended.returncode:
                    print(f"{name}, {form}: exit code {ended.returncode}: {ended.stderr.strip()}")
                    failed = True
                    continue
                energies[form] = check(run, sheet, table)
                if verified := subprocess.run([PROGRAM, "verify", run], capture_output=True, text=True).returncode:
                    print(f"{name}, {form}: verify ends with {verified}")
                    failed = True
            for energy in energies.values():
                table.put("energy at the end in other forms, relative", abs(energy / energies[FORMS[0]] - 1), 1e-9)
    for name, (miss, bound) in table.rows.items():
        print(f"{name}: {miss:.2g}, at most {bound:.2g}{'' if miss <= bound else '  FAILED'}")
        failed = failed or not miss <= bound
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
