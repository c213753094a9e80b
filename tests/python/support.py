"""Functions for several tests."""

import os
import pathlib
import subprocess

SOURCES = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ["KIRIREEL_PROGRAM"]


def model_folder(name):
    return SOURCES / "data" / name


def run_program(*words):
    """Runs the program. Exit codes also report the end of a run, so only 1 and 2 are failures."""
    end = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, cwd=SOURCES)
    assert end.returncode not in (1, 2), end.stderr
    return end
