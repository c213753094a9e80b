#!/usr/bin/python3
"""Random models of all families, each at random placements: same outcome, path and figures.

    test_placements.py quick|long

Each placement is a rotation in space, at times with a mirror, a move by up to a thousand sizes, a scale, a
unit, and new numbers of tiles and joints. Without gravity nothing of this counts. The program is
$KIRIREEL_PROGRAM. Returns 77 (skipped) without NumPy.
"""
import json
import os
import sys
import tempfile

import test_matrix
from test_matrix import Failure, Model, Transformation, difference, np, rotationAbout, run

# A path is kinematic, see test_matrix; figures are lengths and counts.
BOUND = 1e-9
# Parameters that keep a model small, of those that the family has.
SMALL = {"columns": (2, 4), "rows": (2, 4), "half-columns": (2, 3), "half-size": (2, 2), "size": (3, 5),
         "tiles": (5, 12), "cells": (3, 5)}


def families():
    """Names, each with the options that are in SMALL."""
    page = run("generate", "--help")
    names = [line.split()[0] for line in page.splitlines()
             if line.startswith("  ") and len(line.split()) > 1 and line[2] != " " and not line.strip().startswith("-")]
    return [name for name in names if name[0].islower() and name not in ("kirireel",)]


def make(family, rng, folder):
    """A small random model of the family; None if the program has none with these values."""
    try:
        page = run("generate", family, "--help")
    except Failure:
        return None
    options = []
    for name, (least, most) in SMALL.items():
        if f"--{name} " in page:
            options += [f"--{name}", str(rng.integers(least, most + 1))]
    try:
        run("generate", family, folder, *options)
    except Failure:
        try:
            run("generate", family, folder)
        except Failure:
            return None
    return Model.read(folder)


def place(rng):
    """A random placement of a model."""
    axis = rng.normal(size=3)
    turn = rotationAbout(axis, rng.uniform(0, 2 * np.pi))
    if rng.random() < 0.5:
        turn = turn @ np.diag([-1.0, 1, 1])
    unit, factor = [("m", 1.0), ("mm", 1e3), ("in", 1 / 0.0254)][rng.integers(3)]
    scale = factor * 10 ** rng.uniform(-1, 1)
    t = Transformation("random", turn, shift=10 ** rng.uniform(-1, 3), scale=scale, options=["--unit", unit],
                       reorder="tiles" if rng.random() < 0.5 else "ends")
    t.metres = scale / factor
    return t


def outcome(folder, t, out):
    run("simulate", folder, *t.options, "--search", "5", "--out", out)
    summary = json.load(open(os.path.join(out, "summary.json")))
    words = [summary["outcome"], summary["path"]["kind"], summary["needs"]["planar"]["on"], summary["needs"]["contacts"]["on"],
             summary.get("at_target")]
    return words, {"points": test_matrix.readTiles(os.path.join(out, "final_vertices.txt"))}


def main():
    models, placements = (4, 2) if sys.argv[1] == "quick" else (50, 10)
    names = families()
    failed = tried = 0
    with tempfile.TemporaryDirectory() as scratch:
        k = 0
        while k < models:
            rng = np.random.default_rng(100 + k)
            family = names[(k * 7) % len(names)] if sys.argv[1] == "long" else ("tessellation", "stars", "hexagons", "cylinder")[k]
            folder = os.path.join(scratch, f"{k}")
            os.makedirs(folder)
            model = make(family, rng, os.path.join(folder, "made"))
            k += 1
            if model is None:
                print(f"{family}: not made")
                continue
            test_matrix.PLAIN[0] = model
            plain = Transformation("plain")
            plain.metres = 1.0
            try:
                words, expected = outcome(test_matrix.put(model, plain, folder), plain, os.path.join(folder, "out"))
            except Failure as failure:
                print(f"{family}: left out: {failure}")
                continue
            for placement in range(placements):
                t = place(rng)
                t.folder = f"placement{placement}"
                tried += 1
                try:
                    found, points = outcome(test_matrix.put(model, t, folder), t, os.path.join(folder, f"out{placement}"))
                    off = difference(points, expected, t, model)
                    good = found == words and off <= BOUND
                    cell = f"{off:.1g}" + ("" if found == words else f", {found} instead of {words}")
                except Failure as failure:
                    good, cell = False, str(failure)
                if not good:
                    failed += 1
                    print(f"{family} {k - 1}, placement {placement}: {cell} FAILS", flush=True)
            print(f"{family} {k - 1}: {len(model.tiles)} tiles, {words}", flush=True)
    print(f"{tried - failed} of {tried} placements hold")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
