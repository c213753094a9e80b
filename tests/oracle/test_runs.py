#!/usr/bin/python3
"""Runs of shipped models and of random scenes against check_run.py.

    test_runs.py quick|long

Prints the largest disagreement of each figure over all runs; returns 1 if one is above its bound, 77
(skipped) without NumPy or h5py. The program is $KIRIREEL_PROGRAM.
"""
import os
import random
import subprocess
import sys
import tempfile

try:
    import check_run
except ImportError as missing:
    print(f"skipped: {missing}; install python3-numpy and python3-h5py")
    sys.exit(77)

DATA = os.path.join(os.path.dirname(__file__), "..", "..", "data")
PROGRAM = os.environ["KIRIREEL_PROGRAM"]
GROUND = ["--gravity", "-9.81", "--ground", "--duration", "0.5"]
VARIANTS = [[], GROUND, ["--contacts", "none"], ["--contacts", "none"] + GROUND]
QUICK = [("tessellation_4x4", v) for v in ([], GROUND, ["--path", "guided"])] + [
    ("nonrigid", ["--planar", "off", "--fps", "30"]), ("nonrigid", ["--contacts", "none", "--fps", "60"]),
    ("moebius", ["--contacts", "none", "--fps", "30"]), ("square_to_circle", []), ("stars", ["--fps", "30"])]
FAMILIES = [
    ("tessellation", ["--rows", "{2-4}", "--columns", "{2-4}", "--skew", "{0-25}"]),
    ("cylinder", ["--half-columns", "{3-4}", "--rows", "{2-3}"])]
RANDOM_OPTIONS = [
    [], ["--contacts", "none"], ["--contacts", "all"], ["--planar", "off"], ["--path", "guided"],
    ["--actuation", "none", "--gravity", "-2", "--pin", "1", "--planar", "off"],
    ["--actuation", "none", "--gravity", "-9.81", "--ground", "--mass", "prism"],
    ["--hinge-stiffness", "0.5", "--path", "dynamic"], ["--path", "straight", "--linear-damping", "0"]]


def run(*arguments):
    """The exit code; a run that misses its target also counts."""
    return subprocess.run([PROGRAM, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def random_scenes(folder, count):
    chance = random.Random(49)
    for number in range(count):
        family, options = chance.choice(FAMILIES)
        drawn = [str(chance.randint(*map(int, o[1:-1].split("-")))) if o.startswith("{") else o for o in options]
        model = os.path.join(folder, f"random_{number}")
        made = run("generate", family, model, *drawn)
        if made.returncode:
            raise SystemExit(f"generate {family} {drawn}: {made.stderr}")
        # Joints of a cylinder are balls, which have no springs.
        fitting = [o for o in RANDOM_OPTIONS if family != "cylinder" or "--hinge-stiffness" not in o]
        yield model, chance.choice(fitting) + ["--duration", "1", "--seed", str(number)]


def scenes(extent, folder):
    if extent == "quick":
        for name, options in QUICK:
            yield os.path.join(DATA, name), options
        return
    for name in sorted(os.listdir(DATA)):
        if os.path.exists(os.path.join(DATA, name, "vertices.txt")):
            for options in VARIANTS:
                yield os.path.join(DATA, name), options
    yield from random_scenes(folder, 20)


def finds_wrong_energy(out):
    """Whether check_run.py rejects a kinetic energy that is 5% too large."""
    with check_run.h5py.File(os.path.join(out, "trajectory.h5"), "r+") as run:
        run["energy/kinetic"][...] = 1.05 * run["energy/kinetic"][:]
    return check_run.check(out, few=True)["kinetic energy of the poses"][1] > 1


def main(extent):
    largest, failed = check_run.Table(), False
    with tempfile.TemporaryDirectory() as folder:
        for number, (model, options) in enumerate(scenes(extent, folder)):
            out = os.path.join(folder, f"run_{number}")
            words = " ".join([os.path.basename(model), *options])
            ended = run("simulate", model, *options, "--out", out)
            if not os.path.exists(os.path.join(out, "summary.json")):
                print(f"{words}: exit code {ended.returncode}: {ended.stderr.strip()}")
                failed = True
                continue
            for name, (difference, ratio) in check_run.check(out, few=extent == "quick").items():
                largest.put(name, difference, ratio)
                if ratio > 1:
                    failed = True
                    print(f"{words}: {name}: {difference:.3g} of the scale, {ratio:.3g} of its bound", flush=True)
        model = os.path.join(folder, "pendulum")
        run("generate", "tessellation", model, "--rows", "2", "--columns", "2", "--start-angle", "20")
        out = os.path.join(folder, "wrong")
        # A pendulum: 5% is a thousand times the bound.
        run("simulate", model, "--actuation", "none", "--pin", "0", "--gravity=0,-9.81,0", "--planar", "on", "--contacts", "none",
            "--tolerance", "1e-6", "--duration", "1", "--out", out)
        if not finds_wrong_energy(out):
            print("a kinetic energy that is 5% too large is not found")
            failed = True
    check_run.report(largest.rows)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
