#!/usr/bin/python3
"""Random models of all families, each at random placements: same outcome, path and figures.

    test_placements.py quick|long [FIRST [MODELS [PLACEMENTS]]]

A placement combines transformations of test_matrix.py at random: a rotation in space, a mirror, a move by up to
a thousand sizes, a power of two, a unit, new numbers of tiles and joints, swapped ends of joints, another name,
another file format. Without gravity none of them counts. FIRST is the number of the first model, which seeds it.
The program is $KIRIREEL_PROGRAM. Returns 1 if a placement differs; 77 (skipped) without NumPy.
"""
import json
import os
import re
import sys
import tempfile

import test_matrix
from test_matrix import UNITS, DYNAMIC, Failure, KINEMATIC, Model, Transformation, difference, metres, np, rotationAbout, run, unitOf

# Parameters that keep a model small, of those that the family has.
SMALL = {"columns": (2, 4), "rows": (2, 4), "half-columns": (2, 3), "half-size": (2, 2), "size": (3, 5),
         "tiles": (5, 12), "cells": (3, 5)}
STATES = ("25%", "50%", "75%")  # on the way
# Families of the quick test, in order of its models.
QUICK = ("tessellation", "stars", "cap", "stampfli-chain", "quads", "penrose-removal")
# Lengths of a run's summary.
LENGTHS = ("target_error_start", "target_error_end", "rigid_bound", "assembled_error", "joint_opening_max",
           "penetration_max", "penetration_grown_max")


def families():
    page = run("generate", "--help").split("Subcommands:")[1]
    return re.findall(r"^  ([a-z][a-z-]*)", page, re.MULTILINE)


def make(family, rng, folder):
    """A small random model of the family, or the default one if these values have none."""
    page = run("generate", family, "--help")
    options = []
    for name, (least, most) in SMALL.items():
        if f"--{name} " in page:
            options += [f"--{name}", str(rng.integers(least, most + 1))]
    try:
        run("generate", family, folder, *options)
    except Failure:
        run("generate", family, folder)
    return Model.read(folder)


def placement(rng):
    """Each part is in half of all placements."""
    has = lambda: rng.random() < 0.5
    turn = rotationAbout(rng.normal(size=3), rng.uniform(0, 2 * np.pi)) if has() else np.eye(3)
    if has():
        turn = turn @ np.diag([-1.0, 1, 1])
    scale = 2.0 ** rng.integers(-6, 7) if has() else 1.0
    unit = list(UNITS)[rng.integers(len(UNITS))]
    return Transformation("random", turn, shift=10 ** rng.uniform(-1, 3) if has() else 0, scale=scale / UNITS[unit],
                          options=["--unit", unit] if unit != "m" else [],
                          reorder=[None, "tiles", "ends"][rng.integers(3)],
                          folder=["m", "hull", "my tiles", "Möbius 紙"][rng.integers(4)],
                          form=[None, "m.fold", "m_contracted.obj"][rng.integers(3)])


def describe(t):
    parts = [unitOf(t), f"scale {t.scale:.3g}", f"moved {t.shift:.3g}"]
    parts += ["turned"] if not np.allclose(np.abs(t.rotation), np.eye(3)) else []
    parts += ["mirrored"] if t.isMirror() else []
    return ", ".join(parts + [word for word in (t.reorder, t.form, t.folder) if word])


def outcome(place, t, out):
    """Results of a default run: words, states of the path, and figures."""
    run("simulate", place, *t.options, "--out", out)
    summary = json.load(open(os.path.join(out, "summary.json")))
    moves = summary["end_time"] > 0  # otherwise there is one state
    run("export", out, "--format", "vertices", "--states", ",".join(STATES if moves else STATES[:1]), "--out", out + "e")
    needs, path = summary["needs"], summary["path"]
    words = [summary["outcome"], path["kind"], needs["planar"]["on"], needs["contacts"]["on"], summary["at_target"],
             summary["shortfall"] is None]
    states = [test_matrix.readTiles(os.path.join(out, "final_vertices.txt"))]
    states += [test_matrix.readTiles(os.path.join(out + "e", name)) for name in sorted(os.listdir(out + "e"))
               if name.endswith(".txt")]
    lengths = [summary["accuracy"][name] or 0.0 for name in LENGTHS]
    return words, states, [length * t.scale / metres(t) for length in lengths]


def compare(found, expected, t, model):
    """The largest difference of states and figures, in tiles. Throws Failure if words differ."""
    if found[0] != expected[0]:
        raise Failure(f"{found[0]} instead of {expected[0]}")
    if len(found[1]) != len(expected[1]):
        raise Failure(f"{len(found[1])} states instead of {len(expected[1])}")
    # The end comes first.
    states = [difference({"points": a}, {"points": b}, t, model) for a, b in zip(found[1], expected[1])]
    figures = difference({"lengths": found[2]}, {"lengths": expected[2]}, t, model)
    return states, figures


def knownFailure(model, expected):
    """Why a model of the long test misses its bound, and the bound that it keeps; None for other models. Found paths
    without contacts agree to 1e-11."""
    if expected[0][3]:
        return "paths among flush bricks, and their smoothing, amplify rounding: measured 0.5 on the way", np.inf
    if not model.target:
        return "smoothing amplifies rounding: measured 2e-12 at the end, 2e-9 on the way", 1e-8
    return None


def check(k, family, placements, isQuick, scratch):
    rng = np.random.default_rng(100 + k)
    folder = os.path.join(scratch, str(k))
    os.makedirs(folder)
    model = make(family, rng, os.path.join(folder, "made"))
    test_matrix.PLAIN[0] = model
    plain = Transformation("plain")
    expected = outcome(test_matrix.put(model, plain, folder), plain, os.path.join(folder, "out"))
    bound = DYNAMIC if expected[0][3] or expected[0][1] != "continuation" else KINEMATIC
    known = None if isQuick else knownFailure(model, expected)
    differ, failed, worst = 0, 0, 0.0
    for p in range(placements):
        t = placement(rng)
        there = os.path.join(folder, f"placement{p}")
        os.makedirs(there)
        try:
            found = outcome(test_matrix.put(model, t, there), t, os.path.join(there, "out"))
            states, figures = compare(found, expected, t, model)
            worst = max(worst, *states, figures)
            good = max(*states, figures) <= bound
            reason = known[0] if known and max(*states, figures) <= known[1] else None
            cell = f"states off by {', '.join(f'{x:.1g}' for x in states)}, figures by {figures:.1g}"
        except Failure as failure:
            good, reason, cell = False, None, str(failure)  # another outcome is never known
        if not good:
            differ += 1
            failed += reason is None
            print(f"{family} {k}, placement {p} ({describe(t)}): {cell} " + (f"(known: {reason})" if reason else "FAILS"),
                  flush=True)
    print(f"{family} {k}: {len(model.tiles)} tiles, {expected[0][0]} {expected[0][1]}: {placements - differ} of "
          f"{placements} hold, off by {worst:.1g} of {bound:g}", flush=True)
    return np.array([placements - differ, failed])


def main():
    quick = sys.argv[1] == "quick"
    numbers = [int(word) for word in sys.argv[2:]]
    first, models, placements = (numbers + [0, len(QUICK) if quick else 50, 2 if quick else 10][len(numbers):])[:3]
    names = families()
    held, failed = 0, 0
    with tempfile.TemporaryDirectory() as scratch:
        for k in range(first, first + models):
            family = QUICK[k % len(QUICK)] if quick else names[(7 * k) % len(names)]
            good, bad = check(k, family, placements, quick, scratch)
            held, failed = held + good, failed + bad
    print(f"{held} of {models * placements} placements hold")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
