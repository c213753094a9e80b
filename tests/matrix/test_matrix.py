#!/usr/bin/python3
"""Transformed models give transformed results: a list of transformations, a list of commands, one loop.

    test_matrix.py quick|long [MODEL ...]

Prints one row for each transformation and one column for each command: the largest difference in
tiles, or "bits" if all numbers are the same to the last bit. Returns 1 if a difference is above its
bound, or if a known failure holds; 77 (skipped) without NumPy. The program is $KIRIREEL_PROGRAM.
"""
import csv
import json
import os
import re
import subprocess
import sys
import tempfile
import zlib

try:
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}; install python3-numpy")
    sys.exit(77)

PROGRAM = os.environ["KIRIREEL_PROGRAM"]
DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data")

# Bounds in tiles. A path is found to rounding; dynamics keeps its steps' tolerance.
BITS, KINEMATIC, DYNAMIC = 0.0, 1e-9, 1e-6
# For models after the first in the quick extent.
CORE = ("inspect", "path", "gravity", "grips", "glb", "inp")
# For files in single precision, and for decks, which have few digits.
SINGLE, DECK = 1e-6, 2e-6


class Model:
    """Tiles and target as lists of (n x 3) arrays, joints as rows of five integers."""

    def __init__(self, tiles, joints, target):
        self.tiles, self.joints, self.target = tiles, joints, target

    @staticmethod
    def read(folder):
        def states(name):
            path = os.path.join(folder, name)
            return readTiles(path) if os.path.exists(path) else None
        joints = []
        for line in open(os.path.join(folder, "constraints.txt")):
            row = [int(word) for word in line.split("#")[0].split()]
            if row:
                joints.append(row if len(row) == 5 else row + [1])
        return Model(states("vertices.txt"), joints, states("target.txt"))

    def write(self, folder):
        os.makedirs(folder)
        writeTiles(os.path.join(folder, "vertices.txt"), self.tiles)
        if self.target:
            writeTiles(os.path.join(folder, "target.txt"), self.target)
        with open(os.path.join(folder, "constraints.txt"), "w") as file:
            for row in self.joints:
                file.write(" ".join(map(str, row)) + "\n")

    def tileSize(self):
        edges = [np.linalg.norm(t - np.roll(t, -1, axis=0), axis=1) for t in self.tiles]
        return np.concatenate(edges).mean()

    def size(self):
        return np.linalg.norm(np.ptp(np.concatenate(self.tiles), axis=0))


def readTiles(path):
    rows = [line.split("#")[0].split() for line in open(path)]
    return [np.array(row, float).reshape(-1, 3) for row in rows if row]


def writeTiles(path, tiles):
    with open(path, "w") as file:
        for tile in tiles:
            file.write(" ".join(repr(float(x)) for x in tile.ravel()) + "\n")


# ---------------------------------------------------------------------------------------------------
# Transformations. Each defines how points and directions move, and how its results are put into the
# original order again.

class Transformation:
    def __init__(self, name, rotation=None, shift=0.0, scale=1.0, options=(), bound=None,
                 reorder=None, folder="m", form=None, isCore=False):
        self.isCore = isCore
        self.name, self.scale, self.options, self.bound = name, scale, list(options), bound
        self.rotation = np.eye(3) if rotation is None else rotation
        self.shift, self.reorder, self.folder, self.form = shift, reorder, folder, form

    def direction(self, vector):
        return vector @ self.rotation.T

    def points(self, points, model):
        """The transformed points, metres or the given unit."""
        moved = self.scale * self.direction(points)
        return moved + self.shift * model.size() * self.scale * np.array([1.0, 0.7, -0.4]) if self.shift else moved

    def isMirror(self):
        return np.linalg.det(self.rotation) < 0

    def apply(self, model):
        def state(tiles):
            moved = [self.points(tile, model) if self.moves() else tile for tile in tiles]
            return [tile[::-1] for tile in moved] if self.isMirror() else moved
        tiles, joints = state(model.tiles), [list(row) for row in model.joints]
        target = state(model.target) if model.target else None
        if self.isMirror():
            for row in joints:
                row[1] = len(tiles[row[0]]) - 1 - row[1]
                row[3] = len(tiles[row[2]]) - 1 - row[3]
        if self.reorder == "tiles":
            order = self.order(len(tiles))
            place = {int(old): new for new, old in enumerate(order)}
            tiles = [tiles[i] for i in order]
            target = [target[i] for i in order] if target else None
            joints = [[place[r[0]], r[1], place[r[2]], r[3], r[4]] for r in joints]
            joints = [joints[i] for i in np.random.default_rng(4).permutation(len(joints))]
        if self.reorder == "ends":
            joints = [[r[2], r[3], r[0], r[1], r[4]] for r in joints]
        return Model(tiles, joints, target)

    def moves(self):
        return self.scale != 1 or self.shift or not np.array_equal(self.rotation, np.eye(3))

    @staticmethod
    def order(count):
        return np.random.default_rng(3).permutation(count)

    def number(self, tile):
        """The number of a tile of the original."""
        return int(np.flatnonzero(self.order(len(PLAIN[0].tiles)) == tile)[0]) if self.reorder == "tiles" else tile

    def restore(self, tiles):
        """The tiles of a result, in the order and sense of the original."""
        if self.reorder == "tiles":
            found = [None] * len(tiles)
            for new, old in enumerate(self.order(len(tiles))):
                found[old] = tiles[new]
            tiles = found
        return [tile[::-1] for tile in tiles] if self.isMirror() else tiles


def rotationAbout(axis, angle):
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


QUARTER_X = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
QUARTER_Y = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
TRANSFORMATIONS = [
    Transformation("the same", bound=BITS),
    Transformation("quarter turn about x", QUARTER_X),
    Transformation("quarter turn about y", QUARTER_Y),
    Transformation("turned over about x", np.diag([1.0, -1, -1]) @ QUARTER_X),
    Transformation("turned about z", rotationAbout([0, 0, 1], 0.7)),
    Transformation("turned at random", rotationAbout([0.3, -1, 0.5], 2.1), isCore=True),
    Transformation("mirrored", np.diag([-1.0, 1, 1])),
    Transformation("moved by 1000 sizes", shift=1000),
    Transformation("8 times as large", scale=8.0, bound=BITS),
    Transformation("in mm", scale=1000.0, options=["--unit", "mm"], isCore=True),
    Transformation("tiles renumbered", reorder="tiles", isCore=True),
    Transformation("joint ends swapped", reorder="ends"),
    Transformation("named hull", folder="hull", bound=BITS),
    Transformation("named with a space", folder="my tiles", bound=BITS),
    Transformation("named in UTF-8", folder="Möbius 紙", bound=BITS),
    Transformation("as FOLD", form="m.fold", bound=BITS),
    Transformation("as an OBJ pair", form="m_contracted.obj", bound=BITS),
]

# ---------------------------------------------------------------------------------------------------
# Commands. Each gives lists of numbers by how they change: points (tiles), lengths, areas, and
# numbers that stay.

class Failure(Exception):
    pass


def run(*arguments, may=(0, 3)):
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    if done.returncode not in may:
        lines = (done.stderr or done.stdout).strip().splitlines()
        raise Failure(f"exit code {done.returncode}: {lines[-1] if lines else ''}")
    return done.stdout


def simulated(place, t, extra, out):
    run("simulate", place, *t.options, "--out", out, *extra)
    summary = json.load(open(os.path.join(out, "summary.json")))
    numbers = [summary["needs"]["contacts"]["on"], ["settled", "locked", "out_of_time"].index(summary["outcome"])]
    return {"points": readTiles(os.path.join(out, "final_vertices.txt")), "numbers": numbers}


RUNS = {}


def ofRun(place, t, out):
    """The folder of one default run of this model, which several commands read."""
    if place not in RUNS:
        simulated(place, t, [], out)
        RUNS[place] = out
    return RUNS[place]


def inspect(place, t, out):
    """Its lengths are in metres; "size" is the diagonal of a box along the axes and no measure of the sheet."""
    report = json.loads(run("inspect", place, *t.options, "--json"))
    numbers = []
    for state in ("start", "target"):
        if state not in report or report[state] is None:
            continue
        numbers.append(len(report[state]["overlaps"]))
        for space in ("plane", "space"):
            found = report[state]["mobility"].get(space)
            numbers += [-1] if not found else [found["degrees_of_freedom"], found["redundant"]]
    return {"numbers": numbers, "lengths": [report["tile_size"] * t.scale / metres(t)]}


def path(place, t, out):
    folder = ofRun(place, t, out)
    summary = json.load(open(os.path.join(folder, "summary.json")))
    needs, outcome = summary["needs"], summary["outcome"]
    numbers = [needs["contacts"]["on"], needs["planar"]["on"], ["settled", "locked", "out_of_time"].index(outcome)]
    return {"points": readTiles(os.path.join(folder, "final_vertices.txt")), "numbers": numbers}


def gravity(place, t, out):
    pull = metres(t) * t.direction(np.array([0.3, -0.2, -1.0]))
    return simulated(place, t, ["--gravity=" + ",".join(repr(float(x)) for x in pull), "--duration", "0.5"], out)


def circle(place, t, out):
    return simulated(place, t, ["--actuation", "boundary", "--duration", "0.5"], out)


def expansion(place, t, out):
    return simulated(place, t, ["--actuation", "expansion", "--duration", "0.5"], out)


def springs(place, t, out):
    stiffness = repr(0.5 * metres(t) ** 2)
    return simulated(place, t, ["--hinge-stiffness", stiffness, "--path", "dynamic", "--duration", "0.5"], out)


def scene(t, text, out):
    """A scene file; `text` has its tables."""
    os.makedirs(out + "s")
    with open(os.path.join(out + "s", "scene.toml"), "w") as file:
        file.write(text)
    return os.path.join(out + "s", "scene.toml")


def along(vector, factor=1.0):
    """Numbers of a grip, without those along axes in which the vector is 0."""
    named = [f"{axis} = {float(factor * x)!r}" for axis, x in zip("xyz", vector) if abs(x) > 1e-12]
    return "{" + ", ".join(named) + "}"


def grips(place, t, out):
    """The first tile is pinned, the last is moved and another pushed, in the plane of the sheet."""
    count = len(PLAIN[0].tiles)
    last, middle = t.number(count - 1), t.number(count // 2)
    move = t.direction(np.array([0.05, 0.03, 0]))
    push = t.direction(np.array([100.0, 200, 0]))
    # In the unit of the model, like all input; forces are newtons.
    text = (f"[[grip]]\ntile = {last}\nmove = {along(move, t.scale)}\n"
            f"[[grip]]\ntile = {middle}\nforce = {along(push, metres(t) ** 2)}\n")
    run("simulate", place, *t.options, "--scene", scene(t, text, out), "--pin", str(t.number(0)),
        "--hinge-neck", f"{0.05 * t.scale!r},0,1e6", "--out", out)
    rows = list(csv.DictReader(open(os.path.join(out, "load_curve.csv"))))
    force = np.zeros(3)
    for k, axis in enumerate("xyz"):
        for name, value in rows[-1].items():
            if name == f"grip_1_{axis}_force_N":
                force[k] = float(value)
    return {"points": readTiles(os.path.join(out, "final_vertices.txt")),
            "forces": list(t.rotation.T @ force / metres(t) ** 2 / 1e3)}


def curves(place, t, out):
    run("curves", ofRun(place, t, out), "--out", out + "c")
    row = list(csv.DictReader(open(os.path.join(out + "c", "curves.csv"))))[-1]
    unit = unitOf(t)
    at = lambda name: float(row[name] or "nan")
    return {"areas": [at(f"hull_area_{unit}2"), at(f"covered_area_{unit}2")],
            "lengths": [at(f"hull_perimeter_{unit}")],
            "numbers": [at("porosity"), at("opening_mean_deg")]}


def exported(form, measure, unit, *options):
    """`unit`: of the file, metres; None: the model's."""
    def command(place, t, out):
        folder = ofRun(place, t, out)
        states = [] if form in ("svg", "dxf", "glb") else ["--states", "0%"]
        run("export", folder, "--format", form, *options, *states, "--out", out + "e")
        files = [os.path.join(out + "e", n) for n in sorted(os.listdir(out + "e")) if n.endswith("." + form)]
        # The mesh of a deck, without its jobs.
        files = [f for f in files if form != "inp" or "*NODE," in open(f).read()]
        return {"lengths": [measure(files[0]) * (1 if unit is None else unit * t.scale / metres(t))]}
    command.__name__ = form
    return command


def spread(points):
    """The root mean square distance of all points from their mean."""
    points = np.asarray(points, float)
    return np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean())


def objSpread(file):
    return spread([line.split()[1:4] for line in open(file) if line.startswith("v ")])


def plySpread(file):
    text = open(file).read().split("end_header\n")
    count = int(re.search(r"element vertex (\d+)", text[0])[1])
    return spread([line.split()[:3] for line in text[1].splitlines()[:count]])


def stlSpread(file):
    data = np.frombuffer(open(file, "rb").read()[84:], np.dtype([("f", "<f4", 12), ("a", "<u2")]))
    return spread(data["f"][:, 3:].astype(float).reshape(-1, 3))


def glbSpread(file):
    """The middles of the bricks in the first key."""
    data = open(file, "rb").read()
    nodes = json.loads(data[20:20 + int.from_bytes(data[12:16], "little")])["nodes"]
    return spread([node["translation"] for node in nodes[1:]])


def deckSpread(file):
    points, isNode = [], False
    for line in open(file):
        if line.startswith("*"):
            isNode = line.upper().startswith("*NODE") and "PRINT" not in line.upper() and "FILE" not in line.upper()
        elif isNode:
            points.append(line.split(",")[1:4])
    return spread(points)


def svgLength(file):
    """The length of all lines: a drawing may be turned in its plane."""
    lines = [re.findall(r"[-0-9.e]+", path) for path in re.findall(r' d="([^"]*)"', open(file).read())]
    points = [np.array(line, float).reshape(-1, 2) for line in lines]
    return sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in points)


def dxfLength(file):
    """The same of the lines of a DXF file: groups 10, 20 to 11, 21."""
    words = [line.strip() for line in open(file)]
    groups, total, ends = list(zip(words[::2], words[1::2])), 0.0, {}
    for code, value in groups + [("0", "")]:
        if code == "0":
            if ends is not None and len(ends) == 4:
                total += np.hypot(ends["11"] - ends["10"], ends["21"] - ends["20"])
            ends = {} if value == "LINE" else None
        elif ends is not None and code in ("10", "20", "11", "21"):
            ends[code] = float(value)
    return total


def picture(place, t, out):
    """Bits of a picture. The screen uses z, so only pictures of renamed models are compared."""
    run("render", ofRun(place, t, out), "--no-video", "--size", "160x120", "--out", out + "r")
    names = sorted(n for n in os.listdir(out + "r") if n.endswith(".png"))
    data = b"".join(open(os.path.join(out + "r", n), "rb").read() for n in names)
    return {"numbers": [len(names), zlib.crc32(data) if t.bound == BITS and t.scale == 1 else None]}


def page(place, t, out):
    """Numbers of files and scripts. The size of packed data is not compared."""
    run("page", ofRun(place, t, out), "--out", out + "p")
    texts = [os.path.join(out + "p", n) for n in sorted(os.listdir(out + "p")) if n.endswith(".html")]
    text = open(texts[0]).read()
    return {"numbers": [len(texts), text.count("<script")]}


def converted(form):
    def command(place, t, out):
        os.makedirs(out)
        run("convert", place, *t.options, os.path.join(out, form))
        run("convert", os.path.join(out, form), *t.options, os.path.join(out, "back"))
        back = Model.read(os.path.join(out, "back"))
        return {"points": back.tiles, "numbers": [len(back.joints)]}
    command.__name__ = "to " + form.split(".")[-1]
    return command


def planar(place, t, out):
    os.makedirs(out)
    run("convert", place, *t.options, os.path.join(out, "p_vertices.txt"))
    report = json.loads(run("inspect", os.path.join(out, "p_vertices.txt"), *t.options, "--json"))
    tiles = [np.array(line.split(), float).reshape(-1, 2) for line in open(os.path.join(out, "p_vertices.txt"))
             if not line.startswith("#")]
    sides = [np.linalg.norm(tile - np.roll(tile, -1, axis=0), axis=1).sum() for tile in t.restore(tiles)]
    return {"lengths": sides, "numbers": [report["start"]["mobility"]["plane"]["degrees_of_freedom"]]}


# Of the program.
UNITS = {"m": 1.0, "mm": 1e-3, "in": 0.0254}


def unitOf(t):
    return t.options[t.options.index("--unit") + 1] if "--unit" in t.options else "m"


def metres(t):
    """The factor by which lengths in metres change."""
    return t.scale * UNITS[unitOf(t)]


COMMANDS = [
    (inspect, KINEMATIC), (path, KINEMATIC), (curves, KINEMATIC), (expansion, DYNAMIC), (gravity, DYNAMIC),
    (circle, DYNAMIC), (springs, DYNAMIC), (grips, DYNAMIC), (converted("c.fold"), KINEMATIC), (planar, KINEMATIC),
    (exported("obj", objSpread, None), KINEMATIC), (exported("ply", plySpread, None), KINEMATIC),
    (exported("stl", stlSpread, 1e-3), SINGLE), (exported("glb", glbSpread, 1.0), SINGLE),
    (exported("inp", deckSpread, 1.0, "--elements-per-edge", "1", "--elements-through", "1"), DECK),
    (exported("svg", svgLength, 1e-3), KINEMATIC), (exported("dxf", dxfLength, 1e-3), KINEMATIC),
    (picture, KINEMATIC), (page, KINEMATIC)]

# (transformation, command): why it fails. A case that passes is an error here.
KNOWN = {
    ("named hull", "picture"): "the picture shows the name",
    ("named with a space", "picture"): "the picture shows the name",
    ("named in UTF-8", "picture"): "the picture shows the name",
}
# The model that all others are transformed from.
PLAIN = [None]


def difference(found, expected, t, model):
    """The largest difference in tiles, 0 only if all bits agree."""
    tile = model.tileSize() * t.scale
    if "points" in expected:
        restored = t.restore(found["points"])
        moved = [t.points(p, model) if t.moves() else p for p in expected["points"]]
        if [len(p) for p in restored] != [len(p) for p in moved]:
            raise Failure("other tiles")
        found, expected = dict(found, points=np.concatenate(restored)), dict(expected, points=np.concatenate(moved))
    powers = {"points": (1, tile), "lengths": (t.scale, tile), "areas": (t.scale**2, tile**2), "numbers": (1, 1),
              "forces": (1, 1)}
    largest = 0.0
    for kind, (factor, size) in powers.items():
        if kind not in expected:
            continue
        pairs = [(x, y) for x, y in zip(found[kind], expected[kind]) if kind == "points" or None not in (x, y)]
        if len(found[kind]) != len(expected[kind]):
            raise Failure(f"{len(found[kind])} {kind} instead of {len(expected[kind])}")
        a, b = np.array([x for x, _ in pairs], float), factor * np.array([y for _, y in pairs], float)
        if a.shape != b.shape or not np.array_equal(np.isnan(a), np.isnan(b)):
            raise Failure(f"{kind} {a.tolist()} instead of {b.tolist()}")
        if kind == "numbers" and np.abs(a - b).max(initial=0) > 1e-6:
            raise Failure(f"{kind} {a.tolist()} instead of {b.tolist()}")
        largest = max(largest, np.nan_to_num(np.abs(a - b)).max(initial=0) / size)
    return largest


def put(model, t, folder):
    """Writes the transformed model and returns the arguments of the program."""
    place = os.path.join(folder, t.folder)
    t.apply(model).write(place)
    if t.form:
        run("convert", place, *t.options, os.path.join(folder, t.form))
        place = os.path.join(folder, t.form)
    return place


def check(name, model, transformations, commands):
    failed = held = 0
    PLAIN[0] = model
    RUNS.clear()
    with tempfile.TemporaryDirectory() as scratch:
        count = 0
        expected = {}
        plain = Transformation("plain", bound=BITS)
        os.makedirs(os.path.join(scratch, "plain"))
        place = put(model, plain, os.path.join(scratch, "plain"))
        for command, _ in commands:
            count += 1
            try:
                expected[command.__name__] = command(place, plain, os.path.join(scratch, str(count)))
            except Failure as failure:
                print(f"{name}: {command.__name__} is left out: {failure}")
        for t in transformations:
            count += 1
            folder = os.path.join(scratch, str(count))
            os.makedirs(folder)
            cells = []
            try:
                place = put(model, t, folder)
            except Failure as failure:
                print(f"{name}, {t.name}: left out: {failure}")
                continue
            for command, bound in commands:
                if command.__name__ not in expected:
                    continue
                count += 1
                allowed = bound if t.bound is None or bound == DECK else t.bound
                try:
                    d = difference(command(place, t, os.path.join(scratch, str(count))),
                                   expected[command.__name__], t, model)
                    cell, good = ("bits" if d == 0 else f"{d:.1g}"), d <= allowed
                except Failure as failure:
                    cell, good = str(failure), False
                known = KNOWN.get((t.name, command.__name__))
                held += good
                if good == (known is None):
                    cells.append(f"{command.__name__} {cell}" + (f" (known: {known})" if known else ""))
                else:
                    failed += 1
                    cells.append(f"{command.__name__} {cell} " + ("HOLDS BUT IS KNOWN TO FAIL" if known else "FAILS"))
            print(f"{name}, {t.name}: " + ", ".join(cells), flush=True)
    print(f"{name}: {held} of {len(expected) * len(transformations)} cells hold")
    return failed


def twoPieces(sheet):
    """The sheet, and a copy next to it, rotated in its plane. The copy has the copied target."""
    turn = rotationAbout([0, 0, 1], 2.2)
    def both(tiles):
        return tiles + [tile @ turn.T + np.array([1.7 * sheet.size(), 0.4, 0]) for tile in tiles]
    count = len(sheet.tiles)
    joints = sheet.joints + [[a + count, i, b + count, k, face] for a, i, b, k, face in sheet.joints]
    return Model(both(sheet.tiles), joints, None)


def main():
    extent, names = sys.argv[1], sys.argv[2:]
    failed = 0
    with tempfile.TemporaryDirectory() as scratch:
        if names:
            models = {name: os.path.join(DATA, name) for name in names}
        else:
            made = [("tessellation", ["--columns", "2", "--rows", "3", "--skew", "10"]),
                    ("cylinder", ["--half-columns", "2", "--rows", "2"])]
            if extent == "long":
                made += [("stars", []), ("hexagons", []), ("moebius", []), ("fan", []), ("quads", []), ("cap", [])]
            models = {}
            for family, options in made:
                models[family] = os.path.join(scratch, family)
                run("generate", family, models[family], *options)
        read = {name: Model.read(folder) for name, folder in models.items()}
        if not names:
            read["two pieces"] = twoPieces(read["tessellation"])
        for name, model in read.items():
            few = extent == "quick" and name != "tessellation"
            failed += check(name, model, [t for t in TRANSFORMATIONS if not few or t.isCore],
                            [c for c in COMMANDS if not few or c[0].__name__ in CORE])
    print(f"{failed} failed" if failed else "all hold")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
