#!/usr/bin/python3
"""Cut patterns of planar models, drawn here and rewritten as editors do, are read as these models.

    test_drawings.py quick|long [MODEL ...]

A model's start is drawn with necks: lines (kerf 0) or closed outlines of slots. The drawing is then
turned, moved and rounded, in relative paths, polylines and transforms. The program must read the
same tiles, joints and motions. Joints move by at most 1e-6 of the sheet and twice the rounding, or
by the kerf if there is one. After the models of data/ come random members
of all planar families, with necks of 0.5 to 8% of a tile, but not thinner than 0.6 kerfs: less than
half a kerf counts as burnt. Returns 1 for a difference, 77 (skipped) without NumPy. The program is
$KIRIREEL_PROGRAM.
"""
import json
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}; install python3-numpy")
    sys.exit(77)

PROGRAM = os.environ["KIRIREEL_PROGRAM"]
DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data")
TILE = 20.0  # millimetres: the mean edge of a drawn tile


class Sheet:
    """Tiles as lists of (n x 2) arrays in millimetres, joints as rows of four integers."""

    def __init__(self, tiles, joints):
        edges = [np.linalg.norm(t - np.roll(t, -1, axis=0), axis=1) for t in tiles]
        scale = TILE / np.concatenate(edges).mean()
        corner = np.min(np.concatenate(tiles), axis=0)
        self.tiles = [scale * (tile - corner) for tile in tiles]
        # A joint may be listed for each face.
        self.joints = sorted({min(tuple(r[:4]), tuple(r[2:4] + r[:2])) for r in joints})
        self.size = np.linalg.norm(np.ptp(np.concatenate(self.tiles), axis=0))

    @staticmethod
    def read(folder):
        tiles = [np.array(line.split("#")[0].split(), float).reshape(-1, 3)
                 for line in open(os.path.join(folder, "vertices.txt")) if line.split("#")[0].strip()]
        rows = [[int(float(word)) for word in line.split("#")[0].split()]
                for line in open(os.path.join(folder, "constraints.txt"))]
        heights = np.concatenate(tiles)[:, 2]
        if np.ptp(heights) > 1e-9:
            return None
        return Sheet([tile[:, :2] for tile in tiles], [row for row in rows if row])

    def places(self):
        return np.array([self.tiles[a][i] for a, i, _, _ in self.joints])

    def least(self):
        return min(np.linalg.norm(t - np.roll(t, -1, axis=0), axis=1).min() for t in self.tiles)


class Lines:
    """The straight pieces between tiles: those of two tiles are cut inside, those of one outside."""

    def __init__(self, sheet):
        self.points, self.pieces = [], {}
        same = 1e-6 * TILE
        corners = np.concatenate(sheet.tiles)
        for number, tile in enumerate(sheet.tiles):
            for a, b in zip(tile, np.roll(tile, -1, axis=0)):
                along = (b - a) / np.linalg.norm(b - a)
                rest = corners - a
                far = rest @ along
                off = np.abs(rest @ [-along[1], along[0]])
                inside = (off < same) & (far > same) & (far < np.linalg.norm(b - a) - same)
                stops = [a, *corners[inside][np.argsort(far[inside])], b]
                for p, q in zip(stops, stops[1:]):
                    i, j = self.at(p), self.at(q)
                    if i != j:
                        self.pieces.setdefault((min(i, j), max(i, j)), []).append(number)

    def at(self, point):
        if self.points:
            near = np.linalg.norm(np.array(self.points) - point, axis=1)
            if near.min() < 1e-5 * TILE:
                return int(near.argmin())
        self.points.append(point)
        return len(self.points) - 1

    def isBorder(self, piece):
        return len(self.pieces[piece]) == 1

    def neckOf(self, joint, sheet):
        """The piece between both tiles that ends at their joint; None if the gap is open."""
        a, i, b, _ = joint
        place = self.at(sheet.tiles[a][i])
        found = [p for p, tiles in self.pieces.items() if place in p and sorted(tiles) == sorted([a, b])]
        return (found[0], place) if len(found) == 1 else None


def drawn(sheet, necks, kerf):
    """Paths as (points, isClosed): the sheet with necks of these widths, or nothing if gaps are open."""
    lines = Lines(sheet)
    short = {}
    for joint, width in zip(sheet.joints, necks):
        neck = lines.neckOf(joint, sheet)
        if neck is None:
            return None
        piece, place = neck
        # The neck of slots is the material between their borders.
        hasNeighbour = any(place in p and not lines.isBorder(p) and p != piece and (p, place) not in short
                     for p in lines.pieces)
        isAtBorder = any(place in p and lines.isBorder(p) for p in lines.pieces)
        gap = width + kerf / 2 + (kerf / 2 if hasNeighbour and not isAtBorder else 0)
        short[piece, place] = gap
    segments = []
    for piece in lines.pieces:
        if kerf > 0 and lines.isBorder(piece):
            continue
        a, b = (np.array(lines.points[k]) for k in piece)
        along = (b - a) / np.linalg.norm(b - a)
        from_, to = short.get((piece, piece[0]), 0), short.get((piece, piece[1]), 0)
        if from_ + to > 0.9 * np.linalg.norm(b - a):
            return None
        segments.append((a + from_ * along, b - to * along))
    paths = [(np.array(s), False) for s in joined(segments)]
    if kerf == 0:
        return paths
    return [(slot(p, kerf), True) for p, _ in paths] + [(r, True) for r in rings(lines)]


def joined(segments):
    """Pieces that continue straight, joined to one line."""
    ends = {}
    for k, segment in enumerate(segments):
        for side in (0, 1):
            ends.setdefault(tuple(np.round(segment[side], 6) + 0.0), []).append((k, side))
    partner = {}
    for found in ends.values():
        for i, (k, s) in enumerate(found):
            for m, t in found[i + 1:]:
                u, v = segments[k][s] - segments[k][1 - s], segments[m][1 - t] - segments[m][t]
                if u @ v > (1 - 1e-12) * np.linalg.norm(u) * np.linalg.norm(v):
                    partner[k, s], partner[m, t] = (m, t), (k, s)
    lines, taken = [], set()
    for start in range(len(segments)):
        for side in (0, 1):
            if start in taken or (start, side) in partner:
                continue
            k, s = start, side
            while True:
                taken.add(k)
                if (k, 1 - s) not in partner:
                    break
                k, s = partner[k, 1 - s]
            lines.append([segments[start][side], segments[k][1 - s]])
    return lines


def rings(lines):
    """Closed chains of the border's pieces, with the sharpest right turn at common corners."""
    ends = {}
    for piece in lines.pieces:
        if lines.isBorder(piece):
            for k in (0, 1):
                ends.setdefault(piece[k], []).append(piece)
    left, found = {p for p in lines.pieces if lines.isBorder(p)}, []
    while left:
        piece = min(left)
        ring, here, first = [], piece[0], piece[0]
        while True:
            left.discard(piece)
            ring.append(lines.points[here])
            there = piece[1] if piece[0] == here else piece[0]
            if there == first:
                break
            came = np.array(lines.points[there]) - lines.points[here]
            def turn(p):
                on = np.array(lines.points[p[1] if p[0] == there else p[0]]) - lines.points[there]
                return np.arctan2(came[0] * on[1] - came[1] * on[0], came @ on)
            piece, here = min((p for p in ends[there] if p in left), key=turn), there
        found.append(np.array(ring))
    return found


def slot(line, kerf, pieces=12):
    """The outline of the material that a beam removes along a straight line."""
    along = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    across = np.array([-along[1], along[0]])
    points = []
    for end, side in ((line[1], 1), (line[0], -1)):
        for angle in np.linspace(-np.pi / 2, np.pi / 2, pieces + 1):
            points.append(end + kerf / 2 * side * (np.cos(angle) * along + np.sin(angle) * across))
    return np.array(points)


# ---------------------------------------------------------------------------------------------------
# Editors. Each returns the text of a file, and the map of points of the sheet to it, millimetres.

def number(x, digits):
    return repr(float(x)) if digits is None else f"{x:.{digits}f}"


def svgText(paths, digits, style, rng):
    angle = rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    shift = rng.uniform(50, 400, 2)
    def place(p):
        return p @ turn.T + shift
    def coordinates(p):
        return number(p[0], digits) + "," + number(p[1], digits)
    content = []
    for points, isClosed in paths:
        if style == "transforms":
            # The sheet's own coordinates, and the motion in a transform.
            content.append("<polyline points=\"%s\"/>" % " ".join(
                coordinates(p) for p in (np.vstack([points, points[:1]]) if isClosed else points)))
            continue
        moved = place(points)
        if style == "relative":
            # Rounded steps add up, so they begin at the rounded positions.
            at = np.array([float(number(x, digits)) for x in moved[0]])
            d = "m" + coordinates(at)
            for p in moved[1:]:
                step = [number(x, digits) for x in p - at]
                at = at + [float(x) for x in step]
                d += " l" + ",".join(step)
        else:
            d = "M" + " L".join(coordinates(p) for p in moved)
        content.append(f"<path d=\"{d}{'z' if isClosed else ''}\"/>")
    body = "\n".join(content)
    if style == "transforms":
        matrix = ",".join(repr(float(x)) for x in (*turn.T.ravel(), *shift))
        body = f"<g transform=\"matrix({matrix})\">{body}</g>"
    return ("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"2000mm\" height=\"2000mm\" "
            f"viewBox=\"0 0 2000 2000\" fill=\"none\" stroke=\"black\">{body}</svg>",
            lambda p: place(p) * [1, -1])


def dxfText(paths, digits, style, rng):
    shift = rng.uniform(-300, 300, 2)
    text = "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
    def xy(p, x, y):
        return f"{x}\n{number(p[0], digits)}\n{y}\n{number(p[1], digits)}\n"
    for points, isClosed in paths:
        moved = points + shift
        if style == "polylines":
            text += f"0\nLWPOLYLINE\n8\ncut\n90\n{len(moved)}\n70\n{int(isClosed)}\n"
            text += "".join(xy(p, 10, 20) for p in moved)
            continue
        ends = np.vstack([moved, moved[:1]]) if isClosed else moved
        for a, b in zip(ends, ends[1:]):
            text += "0\nLINE\n8\ncut\n" + xy(a, 10, 20) + xy(b, 11, 21)
    return text + "0\nENDSEC\n0\nEOF\n", lambda p: p + shift


EDITORS = [("svg", svgText, "absolute"), ("svg", svgText, "relative"), ("svg", svgText, "transforms"),
           ("dxf", dxfText, "lines"), ("dxf", dxfText, "polylines")]


# ---------------------------------------------------------------------------------------------------

def run(*words):
    return subprocess.run([PROGRAM, *words], capture_output=True, text=True)


def motions(place):
    ended = run("inspect", place, "--json")
    if ended.returncode != 0:
        return ended.stderr.strip()
    return json.loads(ended.stdout)["start"]["mobility"]["plane"]["degrees_of_freedom"]


def difference(sheet, free, text, ending, place, kerf, digits, folder):
    """The differences from the sheet, in words, and the largest move of joints, millimetres."""
    drawing, out = os.path.join(folder, "drawing." + ending), tempfile.mktemp(dir=folder)
    open(drawing, "w").write(text)
    ended = run("convert", drawing, out)
    if ended.returncode != 0:
        return ended.stderr.strip(), 0
    tiles = [np.array(line.split(), float).reshape(-1, 3)[:, :2]
             for line in open(os.path.join(out, "vertices.txt")) if not line.startswith("#")]
    rows = [[int(word) for word in line.split()] for line in open(os.path.join(out, "constraints.txt"))
            if not line.startswith("#")]
    if (len(tiles), len(rows)) != (len(sheet.tiles), len(sheet.joints)):
        return f"{len(tiles)} tiles and {len(rows)} joints", 0
    expected = place(sheet.places())
    found = np.array([tiles[row[0]][row[1]] for row in rows])
    distances = np.linalg.norm(found[:, None] - expected[None], axis=2)
    moved = max(distances.min(axis=0).max(), distances.min(axis=1).max())
    allowed = kerf if kerf > 0 else 1e-6 * sheet.size + (2 * 10.0 ** -digits if digits else 0)
    if moved > allowed:
        return f"joints are off by {moved:.2g} mm, {allowed:.2g} mm is allowed", moved
    if free is not None and (read := motions(drawing)) != free:
        return f"{read} motions instead of {free}", moved
    return "", moved


def planarModels(names):
    for name in sorted(os.listdir(DATA)):
        folder = os.path.join(DATA, name)
        if (names and name not in names) or not os.path.exists(os.path.join(folder, "vertices.txt")):
            continue
        sheet = Sheet.read(folder)
        if sheet is not None:
            yield name, folder, sheet


FAMILIES = ["tessellation", "quads", "fan", "heart", "square-to-disk", "square-to-circle", "triangles",
            "hexagons", "stars", "crosses", "islamic", "trefoils", "cap", "moebius", "stampfli-chain",
            "penrose-chain", "ammann-beenker-chain", "stampfli-expansion", "penrose-expansion",
            "ammann-beenker-expansion"]
SIZES = {"--columns": (2, 5), "--rows": (2, 5), "--half-size": (1, 2), "--half-columns": (2, 4),
         "--tiles": (10, 30), "--seed": (1, 999)}


def member(family, rng, folder):
    """A random sheet of a family; None if the family has no sheet of that size."""
    offered = run("generate", family, "--help").stdout
    place = tempfile.mktemp(dir=folder)
    words = [word for option, (least, most) in SIZES.items() if option in offered
             for word in (option, str(rng.integers(least, most + 1)))]
    if run("generate", family, place, *words).returncode != 0:
        return None
    return place, " ".join([family, *words])


# Not read correctly yet: slots of moebius (one motion less) and of penrose_expanded (two false necks), and
# slits of random stars (two necks less).
KNOWN = ("moebius", "penrose_expanded", "stars --columns 3 --rows 5")


class Report:
    def __init__(self):
        self.count, self.faults, self.known, self.open, self.worst = 0, [], [], [], {}

    def read(self, name, sheet, free, paths, kerf, digits, k, rng, folder):
        ending, editor, style = EDITORS[k]
        text, place = editor(paths, digits, style, rng)
        words, moved = difference(sheet, free, text, ending, place, kerf, digits, folder)
        self.count += 1
        self.worst[kerf > 0] = max(self.worst.get(kerf > 0, 0), moved)
        if words:
            faults = self.known if name in KNOWN else self.faults
            faults.append(f"{name}, {ending} ({style}), kerf {kerf:.3g} mm, "
                          f"{digits or 'all'} digits: {words}")


def readModels(report, extent, names, folder):
    for name, place, sheet in planarModels(names):
        if extent == "quick" and not names and name != "tessellation_4x4":
            continue
        free = motions(place)
        report.worst = {}
        for kerf in (0.0, 0.2):
            paths = drawn(sheet, [0.05 * min(TILE, sheet.least())] * len(sheet.joints), kerf)
            if paths is None:
                report.open.append(name)
                break
            for k in range(len(EDITORS)):
                for digits in (None, 3):
                    report.read(name, sheet, free, paths, kerf, digits, k, np.random.default_rng(k), folder)
        print(f"{name}: {len(sheet.tiles)} tiles, {len(sheet.joints)} joints, {free} motions; " + ", ".join(
            f"{'slots' if k else 'slits'}: joints off by {w:.2g} mm" for k, w in report.worst.items()), flush=True)


def readMembers(report, count, folder):
    rng = np.random.default_rng(1)
    report.worst, done = {}, 0
    for number in range(4 * count):
        made = member(FAMILIES[number % len(FAMILIES)], rng, folder)
        sheet = made and Sheet.read(made[0])
        if not sheet or done == count:
            continue
        digits = [None, 3, 4][rng.integers(3)]
        kerf = 0.0 if rng.random() < 0.5 else rng.uniform(0.02, 0.3)
        most = min(0.08 * TILE, 0.2 * sheet.least())
        necks = rng.uniform(min(max(0.005 * TILE, 0.6 * kerf), most), most, len(sheet.joints))
        paths = drawn(sheet, necks, kerf)
        if paths is None:
            report.open.append(made[1])
            continue
        done += 1
        report.read(made[1], sheet, motions(made[0]), paths, kerf, digits, rng.integers(len(EDITORS)), rng, folder)
    print(f"{done} random sheets; " + ", ".join(
        f"{'slots' if k else 'slits'}: joints off by {w:.2g} mm" for k, w in report.worst.items()))


def main():
    extent, names = sys.argv[1], sys.argv[2:]
    report = Report()
    with tempfile.TemporaryDirectory() as folder:
        readModels(report, extent, names, folder)
        if not names:
            readMembers(report, 4 if extent == "quick" else 50, folder)
    if report.open:
        print("not drawn, gaps are open at the start: " + ", ".join(report.open))
    for fault in report.faults:
        print("FAILED:", fault)
    for fault in report.known:
        print("known:", fault)
    print(f"{report.count} drawings, {len(report.faults)} differ, {len(report.known)} known")
    return 1 if report.faults else 0


if __name__ == "__main__":
    sys.exit(main())
