"""Many runs in one process need no more memory than a few."""

import gc
import pathlib
import unittest

import kirireel
from support import model_folder

RUNS = 1000
WARM_UP = 100


def resident_megabytes():
    for line in pathlib.Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    raise AssertionError("no VmRSS")


class Memory(unittest.TestCase):
    def test_stays_flat(self):
        model = kirireel.read(model_folder("tessellation_4x4"))
        for number in range(RUNS):
            run = kirireel.deploy(model, on_sample=lambda sample: None)
            run.velocity.sum()
            if number == WARM_UP:
                gc.collect()
                before = resident_megabytes()
        gc.collect()
        grown = resident_megabytes() - before
        print(f"{RUNS} runs: {before:.1f} MB after {WARM_UP}, {grown:+.2f} MB since")
        self.assertLess(grown, 5)


if __name__ == "__main__":
    unittest.main()
