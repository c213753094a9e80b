#!/usr/bin/python3
"""Computes every figure of finished runs again, from trajectory.h5 and summary.json.

    check_run.py [--few] RUN...

Uses NumPy and h5py only and shares no code with the program. Prints for each figure the largest
disagreement and returns 1 if one is above its bound: 1e-9 of the figure or 1e-12 of a tile (for
energies of the largest energy), whichever is larger. --few: only every tenth interval between samples.

Moments between two samples (penetration_max). No brick may turn by more than 0.05 rad from one sample
to the next, else the interval is left out. With s from 0 to 1, positions taken straight and rotations by
the shortest turn give straight(s). If all joints are closed in both samples (to 1e-9 of a tile), the
bricks of straight(1/3) and straight(2/3) are moved as little as possible in the metric of their masses
until the joints are closed, by c and d (position and rotation vector). The state is straight(s) moved by
13.5 s (1 - s) ((2/3 - s) c + (s - 1/3) d), at s = 1/11 ... 10/11.

Overlap of two bricks: the largest of any two of their convex parts; for two parts the least overlap of
their projections over all face normals and products of edges. Bricks that fill one layer are separated
within it.
"""
import json
import math
import os
import sys
from fractions import Fraction

import h5py
import numpy as np

RELATIVE, TILE = 1e-9, 1e-12
MOST_TURN, MOMENTS, CLOSED = 0.05, 10, 1e-9
PARALLEL, LAYER = 1e-9, 1e-6


# ------------------------------------------------------------------------------------------------
# Rotations.

def matrices(q):
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.stack([np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
                     np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
                     np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1)], -2)


def product(a, b):
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack([aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
                     aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw], -1)


def inverse(q):
    return q * np.array([1, -1, -1, -1])


def vector_of(q):
    """The rotation vector of the shortest turn."""
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1)
    angle = 2 * np.arctan2(sine, q[..., 0])
    return q[..., 1:] * np.where(sine > 1e-300, angle / np.maximum(sine, 1e-300), 2)[..., None]


def rotation_of(vector):
    angle = np.linalg.norm(vector, axis=-1)[..., None]
    return np.concatenate([np.cos(angle / 2), vector * np.sinc(angle / 2 / np.pi) / 2], -1)


# ------------------------------------------------------------------------------------------------
# Polygons.

def cross2(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def newell(v):
    d = v - v.mean(0)
    return np.cross(d, np.roll(d, -1, 0)).sum(0)


def sine_at(points, a, b, c):
    u, w = points[b] - points[a], points[c] - points[b]
    return cross2(u, w) / (np.linalg.norm(u) * np.linalg.norm(w))


def ears(points):
    """The triangles of a concave polygon: the ear with the largest least sine first."""
    def holds(t, p):
        return all(cross2(points[t[(k + 1) % 3]] - points[t[k]], p - points[t[k]])
                   >= -1e-12 * ((points[t[(k + 1) % 3]] - points[t[k]]) ** 2).sum() for k in range(3))
    ring, cut = list(range(len(points))), []
    while len(ring) > 3:
        n = len(ring)
        triangles = [(ring[k - 1], ring[k], ring[(k + 1) % n]) for k in range(n)]
        quality = [min(sine_at(points, *t), sine_at(points, t[1], t[2], t[0]), sine_at(points, t[2], t[0], t[1]))
                   for t in triangles]
        order = sorted(range(n), key=lambda k: -np.round(1e9 * quality[k]))
        best = order[0]
        for k in order:
            if not quality[k] > 1e-9:
                break
            if not any(holds(triangles[k], points[p]) for p in ring if p not in triangles[k]):
                best = k
                break
        cut.append(triangles[best])
        del ring[best]
    return cut + [tuple(ring)]


def convex_parts(corners, normal):
    """Corner numbers of the convex parts (Hertel and Mehlhorn)."""
    n = len(corners)
    e = np.roll(corners, -1, 0) - corners
    e /= np.linalg.norm(e, axis=1)[:, None]
    sines = np.cross(np.roll(e, 1, 0), e) @ normal
    if sines.min() >= -0.03 and -np.minimum(sines, 0).sum() <= 0.06:
        return [list(range(n))]
    x = e[0]
    points = np.stack([(corners - corners[0]) @ x, (corners - corners[0]) @ np.cross(normal, x)], -1)
    triangles = ears(points)
    parts = [list(t) for t in triangles]

    def with_side(a, b):
        return next((p for p in parts if any(p[k - 1] == a and p[k] == b for k in range(len(p)))), None)
    for t in triangles:
        for k in range(3):
            a, b = t[k], t[(k + 1) % 3]
            first, second = with_side(a, b), with_side(b, a)
            if a > b or first is None or second is None:
                continue
            i, j = first.index(b), second.index(a)
            whole = first[i:] + first[:i] + (second[j:] + second[:j])[1:-1]
            if min(sine_at(points, whole[m - 1], whole[m], whole[(m + 1) % len(whole)])
                   for m in range(len(whole))) < -1e-3:
                continue
            parts[parts.index(first)] = whole
            parts.remove(second)
    return parts


def orientation(a, b, c):
    """The cross product of b - a and c - a: exact if rounding may decide its sign."""
    first, second = (b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0])
    if abs(first - second) > 1e-9 * (abs(first) + abs(second)):
        return first - second
    a, b, c = ([Fraction(x) for x in p] for p in (a, b, c))
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def hull(points):
    points = sorted(set(map(tuple, points)))
    if len(points) < 3:
        return np.array(points)

    def half(ordered):
        chain = []
        for p in ordered:
            while len(chain) > 1 and orientation(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain
    return np.array(half(points)[:-1] + half(points[::-1])[:-1])


def covered_area(tiles):
    """Of the union: the covered length of horizontal lines is linear between corners and crossings."""
    low, high, sign = [], [], []
    for v in tiles:
        turn = np.sign(cross2(v - v[0], np.roll(v, -1, 0) - v[0]).sum())
        for a, b in zip(v, np.roll(v, -1, 0)):
            if a[1] != b[1]:
                low.append(min(a, b, key=lambda p: p[1])), high.append(max(a, b, key=lambda p: p[1]))
                sign.append(turn if a[1] < b[1] else -turn)
    low, high, sign = np.array(low), np.array(high), np.array(sign)
    d = high - low
    with np.errstate(all="ignore"):
        sine = cross2(d[:, None], d[None])
        between = low[None] - low[:, None]
        s, t = cross2(between, d[None]) / sine, cross2(between, d[:, None]) / sine
        y = low[:, None, 1] + s * d[:, None, 1]
        y = y[(s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)]
    heights = np.unique(np.concatenate([low[:, 1], high[:, 1], y]))
    area = 0.0
    for a, b in zip(heights[:-1], heights[1:]):
        m = (a + b) / 2
        on = (low[:, 1] < m) & (high[:, 1] > m)
        x = low[on, 0] + (m - low[on, 1]) / d[on, 1] * d[on, 0]
        order = np.argsort(x, kind="stable")
        inside = np.cumsum(sign[on][order]) != 0
        area += (np.diff(x[order]) * inside[:-1]).sum() * (b - a)
    return area


# ------------------------------------------------------------------------------------------------
# A run.

class Run:
    def __init__(self, folder):
        with open(os.path.join(folder, "summary.json")) as text:
            self.summary = json.load(text)
        self.file = h5py.File(os.path.join(folder, "trajectory.h5"))
        f = self.file
        self.time, self.position, self.rotation = f["time"][:], f["position"][:], f["rotation"][:]
        sizes = f["model/tile_sizes"][:]
        self.first = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
        self.owner = np.repeat(np.arange(len(sizes)), sizes)
        self.bottom, self.top, self.normal = f["bricks/bottom"][:], f["bricks/top"][:], f["bricks/normal"][:]
        self.thickness, self.mass, self.inertia = (f["bricks/" + n][:] for n in ("thickness", "mass", "inertia"))
        self.vertices = f["model/vertices"][:]
        self.target = f["model/target"][:] if "model/target" in f else None
        self.joints = f["model/joints"][:] if "model/joints" in f else np.zeros((0, 6), int)
        self.tile = self.summary["model"]["tile_size"]
        self.pivots = []
        self.only_pivots = all(j[5] == 0 for j in self.joints)
        for a, va, b, vb, face, kind in self.joints:
            for bit, points in ((1, self.bottom), (2, self.top)):
                if kind == 0 and face & bit:
                    self.pivots.append((a, points[self.first[a] + va], b, points[self.first[b] + vb], bit == 2))
        self.planar = self.summary["needs"]["planar"]["on"]

    def tiles(self, k, points=None):
        points = self.bottom if points is None else points
        return np.einsum("vij,vj->vi", matrices(self.rotation[k])[self.owner], points) + self.position[k][self.owner]

    def gaps(self, position, rotation):
        if not self.pivots:
            return np.zeros((len(position), 0, 3))
        a, pa, b, pb = (np.array([p[i] for p in self.pivots]) for i in range(4))
        R = matrices(rotation)
        return (position[:, a] + np.einsum("kpij,pj->kpi", R[:, a], pa)
                - position[:, b] - np.einsum("kpij,pj->kpi", R[:, b], pb))


def close(run, p, q, planar):
    """The closed state at the least distance, weighted by the masses. Each step projects the move of all steps."""
    a, pa, b, pb = (np.array([v[i] for v in run.pivots]) for i in range(4))
    rows = 2 if planar else 3
    use = np.array([not (planar and v[4]) for v in run.pivots])
    n, m = len(p), int(use.sum())
    start, first = p, q
    moved = np.zeros((n, 6))
    for _ in range(12):
        R = matrices(q)
        gap = run.gaps(p[None], q[None])[0][use][:, :rows].ravel()
        J = np.zeros((m, rows, n, 6))
        for side, brick, point in ((1, a[use], pa[use]), (-1, b[use], pb[use])):
            arm = np.einsum("pij,pj->pi", R[brick], point)
            cross = np.zeros((m, 3, 3))
            cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = arm[:, 2], -arm[:, 1], arm[:, 0]
            cross -= np.swapaxes(cross, 1, 2)
            block = np.concatenate([np.broadcast_to(np.eye(3), (m, 3, 3)), cross], 2)[:, :rows]
            if planar:
                block = block * np.array([1, 1, 0, 0, 0, 1])
            J[np.arange(m), :, brick] += side * block
        J = J.reshape(m * rows, n * 6)
        W = np.zeros((n, 6, 6))
        W[:, range(3), range(3)] = 1 / run.mass[:, None]
        W[:, 3:, 3:] = np.linalg.inv(np.einsum("nij,njk,nlk->nil", R, run.inertia, R))
        if planar:
            W[:, 5, 5] = 1 / np.einsum("nij,njk,nlk->nil", R, run.inertia, R)[:, 2, 2]
        WJ = np.einsum("nij,rnj->rni", W, J.reshape(-1, n, 6)).reshape(m * rows, n * 6)
        A = J @ WJ.T
        A[np.diag_indices(len(A))] += 1e-13 * np.trace(A) / max(1, len(A))
        before, moved = moved, -(WJ.T @ np.linalg.solve(A, gap - J @ moved.ravel())).reshape(n, 6)
        p = start + moved[:, :3]
        q = product(rotation_of(moved[:, 3:]), first)
        if np.abs(moved - before).max(initial=0) < 1e-13 * run.tile:
            break
    return p, q, np.abs(run.gaps(p[None], q[None])).max(initial=0)


def states_between(run, few):
    """Positions and rotations of all moments between samples."""
    turn = np.linalg.norm(vector_of(product(run.rotation[1:], inverse(run.rotation[:-1]))), axis=-1).max(-1)
    gaps = np.linalg.norm(run.gaps(run.position, run.rotation), axis=-1).max(-1, initial=0)
    share = np.arange(1, MOMENTS + 1)[:, None, None] / (MOMENTS + 1)
    positions, rotations = [], []
    for k in range(0, len(run.time) - 1, 10 if few else 1):
        if not turn[k] <= MOST_TURN or not run.only_pivots:
            continue
        p0, p1, q0, q1 = run.position[k], run.position[k + 1], run.rotation[k], run.rotation[k + 1]
        step = vector_of(product(q1, inverse(q0)))
        p, q = p0 + share * (p1 - p0), product(rotation_of(share * step), q0)
        if run.pivots and max(gaps[k], gaps[k + 1]) <= CLOSED * run.tile:
            flat = (np.abs((np.einsum("nij,nj->ni", matrices(q0), run.normal))[:, :2]).max() <= 1e-9
                    and np.abs(step[:, :2]).max() <= 1e-9 and np.abs((p1 - p0)[:, 2]).max() <= 1e-9 * run.tile)
            thirds = []
            for third in (1 / 3, 2 / 3):
                pm, qm = p0 + third * (p1 - p0), product(rotation_of(third * step), q0)
                pc, qc, gap = close(run, pm, qm, flat)
                thirds.append((pc - pm, vector_of(product(qc, inverse(qm))), gap))
            if max(t[2] for t in thirds) <= CLOSED * run.tile:
                whole = 13.5 * share * (1 - share)
                bulges = whole * (2 / 3 - share), whole * (share - 1 / 3)
                p = p + bulges[0] * thirds[0][0] + bulges[1] * thirds[1][0]
                q = product(rotation_of(bulges[0] * thirds[0][1] + bulges[1] * thirds[1][1]), q)
        positions.append(p), rotations.append(q)
    if not positions:
        return run.position[:0], run.rotation[:0]
    return np.concatenate(positions), np.concatenate(rotations)


class Part:
    """A convex part of a brick, in brick axes."""

    def __init__(self, run, brick, corners):
        bottom = run.bottom[run.first[brick]:run.first[brick + 1]][corners]
        self.brick, self.normal, self.bottom = brick, run.normal[brick], bottom
        self.rise = run.thickness[brick] * self.normal
        edges = np.roll(bottom, -1, 0) - bottom
        self.directions = np.vstack([self.normal, edges / np.linalg.norm(edges, axis=1)[:, None]])
        self.points = np.vstack([bottom, bottom + self.rise])
        self.faces = np.vstack([self.normal, np.cross(self.directions[1:], self.normal)])


def depths(a, b, p, R):
    """Overlap of two parts at all states."""
    def world(x, brick):
        return np.einsum("kij,vj->kvi", R[:, brick], x)
    A = world(a.points, a.brick) + (p[:, a.brick] - p[:, b.brick])[:, None]
    B = world(b.points, b.brick)
    boxes = np.minimum(A.max(1) - B.min(1), B.max(1) - A.min(1)).min(1)
    out = np.zeros(len(p))
    near = np.flatnonzero(boxes > 0)
    for some in np.array_split(near, max(1, len(near) // 400)):
        if not len(some):
            continue
        Ra, Rb = R[some, a.brick], R[some, b.brick]
        fa, fb = np.einsum("kij,vj->kvi", Ra, a.faces), np.einsum("kij,vj->kvi", Rb, b.faces)
        da, db = np.einsum("kij,vj->kvi", Ra, a.directions), np.einsum("kij,vj->kvi", Rb, b.directions)
        parallel = np.linalg.norm(np.cross(fa[:, 0], fb[:, 0]), axis=-1) < PARALLEL
        thickness = np.linalg.norm(a.rise)
        low = np.einsum("ki,ki->k", B[some][:, 0] - A[some][:, 0], fa[:, 0])
        ends = np.sort(np.stack([low, low + np.einsum("ki,ki->k", Rb @ b.rise, fa[:, 0])]), 0)
        layer = parallel & (np.abs(ends[0]) <= LAYER * thickness) & (np.abs(ends[1] - thickness) <= LAYER * thickness)
        axes = np.concatenate([fa, fb], 1)
        skip = np.zeros(axes.shape[:2], bool)
        skip[:, 0] = skip[:, fa.shape[1]] = layer
        if not parallel.all():
            cross = np.cross(da[:, :, None], db[:, None]).reshape(len(some), -1, 3)
            length = np.linalg.norm(cross, axis=-1)
            bad = (length < PARALLEL) | parallel[:, None]
            axes = np.concatenate([axes, cross / np.where(bad, 1, length)[..., None]], 1)
            skip = np.concatenate([skip, bad], 1)
        x, y = A[some] @ np.swapaxes(axes, 1, 2), B[some] @ np.swapaxes(axes, 1, 2)
        overlap = np.minimum(x.max(1) - y.min(1), y.max(1) - x.min(1))
        out[some] = np.maximum(0, np.where(skip, np.inf, overlap).min(1))
    return out


def deepest(run, p, q):
    """The deepest overlap of each state."""
    parts = []
    for brick in range(len(run.mass)):
        bottom = run.bottom[run.first[brick]:run.first[brick + 1]]
        parts += [Part(run, brick, c) for c in convex_parts(bottom, run.normal[brick])]
    R, out = matrices(q), np.zeros(len(p))
    reach = [np.linalg.norm(part.points, axis=1).max() for part in parts]
    for i, a in enumerate(parts):
        for j in range(i):
            b = parts[j]
            if a.brick == b.brick:
                continue
            apart = np.linalg.norm(p[:, a.brick] - p[:, b.brick], axis=-1)
            near = np.flatnonzero(apart < reach[i] + reach[j])
            if len(near):
                out[near] = np.maximum(out[near], depths(a, b, p[near], R[near]))
    return out


# ------------------------------------------------------------------------------------------------
# The figures.

class Table:
    """The largest disagreement of each figure, over its bound."""

    def __init__(self):
        self.rows = {}

    def add(self, name, stated, own, scale, least=0.0):
        """`scale`: 1e-12 of it counts as 0."""
        stated, own = np.asarray(stated, float), np.asarray(own, float)
        if (np.isnan(stated) != np.isnan(own)).any():
            return self.put(name, np.inf, np.inf)
        known = ~np.isnan(stated)
        difference = np.abs(stated - own)[known]
        bound = np.maximum(np.maximum(RELATIVE * np.abs(own), TILE * scale), least)
        bound = np.broadcast_to(bound, known.shape)[known]
        if difference.size:
            worst = np.argmax(difference / bound)
            self.put(name, difference[worst] / scale, difference[worst] / bound[worst])

    def put(self, name, difference, ratio):
        if ratio >= self.rows.get(name, (0, -1))[1]:
            self.rows[name] = (float(difference), float(ratio))


def check_bricks(run, table):
    f = run.file["bricks"]
    for i in range(len(run.mass)):
        v = run.vertices[run.first[i]:run.first[i + 1]]
        area = newell(v)
        n = area / np.linalg.norm(area)
        o = v.mean(0)
        e, g = v - o, np.roll(v, -1, 0) - o
        w = np.cross(e, g) @ n / 2
        middle = o + (w[:, None] * (e + g)).sum(0) / 3 / w.sum()
        volume = w.sum() * run.thickness[i]
        centre = middle + n * run.thickness[i] / 2
        own = run.bottom[run.first[i]:run.first[i + 1]]
        table.add("brick corners", own, v - centre, run.tile)
        table.add("volume", f["volume"][i], volume, run.tile ** 3)
        mass = 1.0 if f.attrs["rule_mass"] in ("unit", b"unit") else f.attrs["rule_density"] * volume
        table.add("mass", run.mass[i], mass, mass)
        S = np.outer(n, n) * run.thickness[i] ** 2 / 12
        for x, y, part in zip(e, g, w):
            corners = np.array([o, o + x, o + y]) - middle
            s = corners.sum(0)
            S = S + part / w.sum() / 12 * (corners.T @ corners + np.outer(s, s))
        own = run.mass[i] * (np.trace(S) * np.eye(3) - S)
        table.add("inertia", run.inertia[i], own, np.abs(own).max())


def check_gaps(run, table):
    f, accuracy = run.file, run.summary["accuracy"]
    if run.only_pivots:
        gap = np.linalg.norm(run.gaps(run.position, run.rotation), axis=-1).max(-1, initial=0)
        table.add("joint gap", f["measures/joint_gap"][:], gap, run.tile)
        most = max(gap.max(), f["steps/joint_gap"][:].max())
        table.add("joint_gap_max", accuracy["joint_gap_max"], most, run.tile)
        table.add("joint_gap_end", accuracy["joint_gap_end"], gap[-1], run.tile)
    if run.target is not None:
        error = np.array([np.linalg.norm(run.tiles(k) - run.target, axis=1).max() for k in range(len(run.time))])
        table.add("target error", f["measures/target_error"][:], error, run.tile)
        table.add("target_error_start", accuracy["target_error_start"], error[0], run.tile)
        table.add("target_error_end", accuracy["target_error_end"], error[-1], run.tile)
        least = min(error.min(), f["steps/target_error"][:].min())
        table.add("target_error_min", accuracy["target_error_min"], least, run.tile)


def check_overlaps(run, table, few):
    stated = run.file["measures/penetration"][:]
    own = deepest(run, run.position, run.rotation)
    table.add("penetration", stated, own, run.tile)
    most = run.summary["accuracy"]["penetration_max"]
    states = [s.decode() if isinstance(s, bytes) else s for s in run.file["figures/name"][:]]
    if "penetration_max" in states:
        k = states.index("penetration_max")
        at = deepest(run, run.file["figures/position"][k][None], run.file["figures/rotation"][k][None])
        table.add("penetration_max at its state", most, at[0], run.tile)
    p, q = states_between(run, few)
    largest = max(own.max(), deepest(run, p, q).max(initial=0))
    # Interpolated states agree to the square of the gap of the straight ones.
    short = max(0.0, largest - most)
    table.put("penetration_max, short of moments", short / run.tile,
              short / max(RELATIVE * largest, 1e-9 * run.tile))
    if not few and run.only_pivots:
        table.put("penetration_max, over 1.1 x moments", (most - 1.1 * largest) / run.tile,
                  max(0.0, (most - 1.1 * largest) / (1e-6 * run.tile)))


def sheet_axes(run):
    """Rows: x and y in the plane of a flat start, and its normal; else those of the world.

    The normal of a plane that is not horizontal has most of the area anticlockwise. x and y follow from
    the shortest rotation of z onto it.
    """
    flat = 1e-9 * np.linalg.norm(np.ptp(run.vertices, axis=0))
    areas = np.array([newell(run.vertices[a:b]) for a, b in zip(run.first[:-1], run.first[1:])])
    side = areas @ areas[0]
    turned = np.where(side[:, None] < 0, -areas, areas).sum(0)
    n = turned / np.linalg.norm(turned) * (-1 if side.sum() < -1e-9 * np.abs(side).sum() else 1)
    heights = (run.vertices - run.vertices[0]) @ n
    if np.abs(run.vertices[:, 2] - run.vertices[0, 2]).max() <= flat or np.abs(heights).max() > flat:
        return np.eye(3)
    axis = np.array([-n[1], n[0], 0])
    axis = axis / np.linalg.norm(axis) if axis.any() else np.array([1.0, 0, 0])
    x = matrices(rotation_of(math.atan2(np.hypot(n[0], n[1]), n[2]) * axis))[:, 0]
    return np.array([x, np.cross(n, x), n])


def poissons_ratio(run, frame, tiles):
    """-e_yy / e_xx of the affine map that fits the tiles' centres best, for each sample."""
    def centres(v):
        c = np.array([v[run.first[i]:run.first[i + 1], :2].mean(0) for i in range(len(run.mass))])
        return c - c.mean(0)
    start = centres((run.vertices - run.vertices[0]) @ frame.T)
    ratio = np.full(len(tiles), np.nan)
    width = np.linalg.svd(start, compute_uv=False)
    if len(start) < 3 or width[1] < 1e-6 * width[0]:
        return ratio
    for k, v in enumerate(tiles):
        map_ = np.linalg.lstsq(start, centres(v), rcond=None)[0]
        values, axes = np.linalg.eigh(map_ @ map_.T)
        strain = axes @ np.diag(np.log(values) / 2) @ axes.T
        if abs(strain[0, 0]) >= 1e-3:
            ratio[k] = -strain[1, 1] / strain[0, 0]
    return ratio


def check_curves(run, table):
    if "curves" not in run.file:
        return
    c = run.file["curves"]
    count = len(run.time)
    tiles = [run.tiles(k) for k in range(count)]
    sides = np.array([v.max(0) - v.min(0) for v in tiles])
    for axis, name in enumerate(("width", "height", "depth")):
        table.add(name, c[name][:], sides[:, axis], run.tile)
    frame = sheet_axes(run)
    tiles = [(v - run.vertices[0]) @ frame.T for v in tiles]
    sides = np.array([v.max(0) - v.min(0) for v in tiles])
    area, around, covered = (np.full(count, np.nan) for _ in range(3))
    for k, v in enumerate(tiles):
        h = hull(v[:, :2])
        d = h - h[0]
        area[k] = abs(cross2(d, np.roll(d, -1, 0)).sum()) / 2
        around[k] = np.linalg.norm(np.roll(h, -1, 0) - h, axis=1).sum()
        if sides[k, 2] <= 1e-6 * np.linalg.norm(sides[k]):
            covered[k] = covered_area([v[run.first[i]:run.first[i + 1], :2] for i in range(len(run.mass))])
    table.add("hull area", c["hull_area"][:], area, run.tile ** 2)
    table.add("hull perimeter", c["hull_perimeter"][:], around, run.tile)
    table.add("covered area", c["covered_area"][:], covered, run.tile ** 2)
    with np.errstate(all="ignore"):
        table.add("porosity", c["porosity"][:], 1 - covered / area, 1.0, RELATIVE)
    table.add("Poisson's ratio", c["poissons_ratio"][:], poissons_ratio(run, frame, tiles), 1.0, RELATIVE)
    if "opening" in c and len(run.joints):
        a, b = run.joints[:, 0], run.joints[:, 2]
        turn = vector_of(product(run.rotation[:, b], inverse(run.rotation[:, a])))
        table.add("opening", c["opening"][:], np.degrees(np.linalg.norm(turn, axis=-1)), 180.0)


def hinge_energy(run):
    h = run.file["hinges"]
    a, b = h["bricks"][:].T
    between = product(inverse(run.rotation[:, a]), run.rotation[:, b])
    turn = 2 * np.arctan2((between[..., 1:] * h["axis"][:]).sum(-1), between[..., 0])
    turn = np.unwrap(turn, axis=0, period=4 * math.pi)
    return (h["stiffness"][:] / 2 * (h["start"][:] + turn - h["rest"][:]) ** 2).sum(1)


def perturbation(run):
    """At most the energy of perturbations, which count as work: a run at rest gets 1e-6 of the model's size per second."""
    return 10 * run.mass.sum() * (1e-6 * np.linalg.norm(np.ptp(run.vertices, axis=0))) ** 2


def check_energies(run, table):
    f = run.file
    if "energy" not in f:
        return
    e = {name: f["energy/" + name][:] for name in f["energy"]}
    largest = max(np.abs(v).max() for v in e.values()) or 1.0
    if "hinges" in f and "ligaments" not in f:
        table.add("elastic energy", e["elastic"], hinge_energy(run), largest)
    settings = run.summary["settings"]
    gravity = np.array(settings["environment"]["gravity"], float)
    if settings["actuation"]["actuation"] == "none" and not settings.get("timeline"):
        height = (run.position @ gravity) @ run.mass
        table.add("work of gravity", e["work"] - e["work"][0], height - height[0], largest, perturbation(run))
    table.put("damped, falls", max(0.0, -np.diff(e["damped"]).min(initial=0)) / largest,
              max(0.0, -np.diff(e["damped"]).min(initial=0)) / (TILE * largest))
    table.put("energies below 0", max(0.0, -min(e[n].min() for n in ("kinetic", "spring", "elastic"))) / largest,
              max(0.0, -min(e[n].min() for n in ("kinetic", "spring", "elastic"))) / (TILE * largest))
    if run.summary["path"]["kind"] == "guided":
        table.put("first spring energy", e["spring"][0] / largest, e["spring"][0] / (RELATIVE * largest))


def rate(values, k, h, weights):
    """The derivative at sample k; `weights` of the samples k - 2 to k + 2."""
    return np.tensordot(np.array(weights) / h, values[k - 2:k + 3], 1)


def kinetic_from_poses(run, k, weights):
    h = (run.time[k + 2] - run.time[k - 2]) / 4
    turn = vector_of(product(run.rotation, inverse(run.rotation[k]))[k - 2:k + 3])
    R = matrices(run.rotation[k])
    spin = np.einsum("nji,nj->ni", R, np.tensordot(np.array(weights) / h, turn, 1))
    speed = rate(run.position, k, h, weights)
    return (run.mass @ (speed ** 2).sum(1) + np.einsum("ni,nij,nj->", spin, run.inertia, spin)) / 2


def check_kinetic(run, table):
    """Kinetic energy from the poses of five samples, of fourth order in their interval.

    The bound is twice the difference to differences of second order, the largest of neighbouring samples.
    Steps of first order have the velocity of their last interval. Energies are linear within a step, so only
    samples at ends of steps count, and only if no impact lies among the five samples: samples do not resolve
    the velocities of an impact.
    """
    stated = run.file["energy/kinetic"][:]
    if len(run.time) < 5:
        return
    steps, cost = run.file["steps/time"][:], run.summary["accuracy"]
    impacts = steps[(run.file["steps/impacted"][:] > 0) | (run.file["steps/touching_time"][:] > 0)]
    fixed = (run.summary["path"]["kind"] == "guided" or run.summary["settings"]["solver"]["tolerance"] == 0
             or cost["touching_time"] > 0 or cost["singular_time"] > 0)
    low = [-1 / 2, 0, 1 / 2] if not fixed else [-1, 1, 0]
    fourth, bound = np.full(len(run.time), np.nan), np.zeros(len(run.time))
    for k in range(2, len(run.time) - 2):
        isolated = not ((impacts > run.time[k - 2]) & (impacts < run.time[k + 2] + 1e-9)).any()
        if (isolated and np.ptp(np.diff(run.time[k - 2:k + 3])) < 1e-9 * run.time[-1]
                and np.abs(steps - run.time[k]).min() < 1e-9):
            fourth[k] = kinetic_from_poses(run, k, [1 / 12, -2 / 3, 0, 2 / 3, -1 / 12])
            bound[k] = abs(fourth[k] - kinetic_from_poses(run, k, [0, *low, 0]))
    largest = max(np.abs(run.file["energy/" + n][:]).max() for n in run.file["energy"]) or 1.0
    for k in np.flatnonzero(~np.isnan(fourth)):
        most = 2 * bound[max(0, k - 2):k + 3].max() + 1e-7 * largest + perturbation(run)
        table.put("kinetic energy of the poses", abs(stated[k] - fourth[k]) / largest, abs(stated[k] - fourth[k]) / most)


def rests(run, k):
    """Whether no brick moves at sample k, nor to the one before or after it."""
    if not 0 < k < len(run.time) - 1:
        return False
    around = slice(k - 1, k + 2)
    turn = np.linalg.norm(vector_of(product(run.rotation[around], inverse(run.rotation[k]))), axis=-1).max()
    return max(np.ptp(run.position[around], axis=0).max() / run.tile, turn) < 1e-9


def check_balance(run, table):
    """Forces are finite or absent. Those from outside carry the weight of a sheet at rest."""
    f = run.file
    if "holds" not in f:
        return
    force, point = f["holds/force"][:], f["holds/point"][:]
    table.put("forces that are not finite", 0, 0 if np.isfinite(force).all() and np.isfinite(point).all() else np.inf)
    settings = run.summary["settings"]
    gravity = np.array(settings["environment"]["gravity"], float)
    weight = run.mass.sum() * np.linalg.norm(gravity)
    if weight == 0 or settings["actuation"]["actuation"] != "none":
        return
    outside = (f["holds/kind"][:] == 0) | (f["holds/tiles"][:][:, 1] < 0)
    for k in filter(lambda k: rests(run, k), range(len(run.time))):
        rows = outside & (np.abs(f["holds/time"][:] - run.time[k]) < 1e-9)
        if rows.any():
            rest = np.linalg.norm(force[rows].sum(0) + run.mass.sum() * gravity)
            table.put("balance at rest", rest / weight, rest / weight / 1e-3)


def check(folder, few=False):
    run = Run(folder)
    table = Table()
    check_bricks(run, table)
    check_gaps(run, table)
    check_overlaps(run, table, few)
    check_curves(run, table)
    check_energies(run, table)
    if "energy" in run.file:
        check_kinetic(run, table)
    check_balance(run, table)
    return table.rows


def report(rows):
    for name, (difference, ratio) in rows.items():
        print(f"{name:36} {difference:10.2e}  {ratio:9.2e} of its bound{'' if ratio <= 1 else '  TOO LARGE'}")


def main(arguments):
    few = "--few" in arguments
    largest = Table()
    for folder in arguments:
        if folder == "--few":
            continue
        rows = check(folder, few)
        for name, (difference, ratio) in rows.items():
            largest.put(name, difference, ratio)
            if ratio > 1:
                print(f"{folder}: {name}: {difference:.3g} of the scale, {ratio:.3g} of its bound")
    report(largest.rows)
    return int(any(ratio > 1 for _, ratio in largest.rows.values()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
