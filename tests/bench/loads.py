#!/usr/bin/python3
"""Measures CPU seconds of load steps, SciPy's minimisers and CalculiX, in one run.

Use: tests/bench/loads.py KIRIREEL [INCREMENTS]
A sheet of 10 x 10 squares on necks is compressed in 100 load steps: by Kirireel as a whole program,
files and all; by SciPy's minimisers of the same energy (tests/cli/ligament_minimiser.py), each step
from the one before; and as the deck with the same necks by CalculiX, with two elements an edge and
the given number (2) of those 100 increments, from which the rest is extrapolated. Then how the cost
of a state grows with the number of tiles.
"""
import csv
import math
import os
import resource
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
import ligament_minimiser

WIDTH, LENGTH, YOUNGS, POISSON, THICKNESS = 0.05, 0.1, 1e9, 0.3, 0.02
STEPS = 100


def cpu(words):
    """The CPU seconds of a program."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{words[0]} failed: {done.stdout[-300:]}{done.stderr[-300:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def load(program, folder, side, angle, move, steps):
    """A model and its run under a load; returns their folders, the seconds and the number of states."""
    model, run, scene = (f"{folder}/{name}{side}_{angle}" for name in ("model", "run", "scene"))
    cpu([program, "generate", "tessellation", "--columns", str(side), "--rows", str(side),
         "--start-angle", str(angle), model])
    tiles = lambda first: list(range(first, first + side))
    with open(scene, "w") as file:
        file.write(f"""[model]
no_align = true
ligaments = true
thickness = {THICKNESS}
hinge_neck = "{WIDTH},{LENGTH},{YOUNGS},{POISSON}"
[actuation]
load_steps = {steps}
[[grip]]
tiles = {tiles(0)}
move = {{x = 0}}
[[grip]]
tile = 0
move = {{y = 0}}
[[grip]]
tiles = {tiles(side * side - side)}
move = {{x = {move}}}
""")
    seconds, _ = cpu([program, "simulate", model, "--scene", scene, "--out", run])
    states = len(list(csv.DictReader(open(f"{run}/load_curve.csv"))))
    return model, run, seconds, states


def main():
    program, increments = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 2
    with tempfile.TemporaryDirectory() as folder:
        side, move = 10, -1.0
        model, run, own, states = load(program, folder, side, 40, move, STEPS)
        print(f"Kirireel: {own:.2f} s, {states} states")
        sheet = ligament_minimiser.Sheet(model, (WIDTH, LENGTH, YOUNGS, POISSON), THICKNESS)
        squeeze = ligament_minimiser.Squeeze(sheet, range(side), range(side * side - side, side * side))
        shares = [move * (k + 1) / STEPS for k in range(STEPS)]
        for method in ("trust-ncg", "Newton-CG", "L-BFGS-B"):
            _, seconds = squeeze.follow(shares, method)
            print(f"SciPy {method}: {seconds:.1f} s, {seconds / own:.0f} times as much")
        model, run, own, states = load(program, folder, side, 0, 1.0, STEPS)
        print(f"Kirireel from closed: {own:.2f} s, {states} states")
        cpu([program, "export", run, "--format", "inp", "--states", "initial", "--joints", "neck",
             "--neck-width", str(WIDTH), "--neck-length", str(LENGTH), "--kerf", "0.02", "--plane-stress",
             "--elements-per-edge", "2", "--out", f"{folder}/deck"])
        tiles = lambda first: ",".join(str(first + k) for k in range(side))
        _, output = cpu([sys.executable, f"{ligament_minimiser.__file__[:-21]}neck_pull.py",
                       f"{folder}/deck/sheet_mesh.inp", str(THICKNESS), str(YOUNGS), str(POISSON),
                       tiles(0), tiles(side * side - side), str(increments / STEPS), str(increments)])
        seconds = float(output.split()[-1]) * STEPS / increments
        print(f"CalculiX: {seconds:.0f} s by {increments} increments, {seconds / own:.0f} times as much")
        costs = []
        for side in (10, 20, 40):
            _, _, seconds, states = load(program, folder, side, 30, -0.05 * side, 1)
            costs.append((side * side, seconds / states))
            print(f"{side * side} tiles: {1e3 * seconds / states:.1f} ms a state, {states} states")
        growth = math.log(costs[-1][1] / costs[0][1]) / math.log(costs[-1][0] / costs[0][0])
        print(f"growth: tiles to the power of {growth:.2f}")


if __name__ == "__main__":
    main()
