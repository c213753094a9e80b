"""The results of a type checker for right and wrong calls."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import kirireel


class Stubs(unittest.TestCase):
    def check(self, line):
        if subprocess.run([sys.executable, "-c", "import mypy"], capture_output=True).returncode:
            self.skipTest("install mypy to check the stubs with it")
        with tempfile.TemporaryDirectory() as folder:
            script = f"import kirireel\nmodel = kirireel.read('x')\n{line}\n"
            environment = {**os.environ, "MYPYPATH": str(pathlib.Path(kirireel.__file__).parents[1])}
            command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", folder, "-c", script]
            return subprocess.run(command, capture_output=True, text=True, env=environment).stdout

    def test_allow_what_is_right(self):
        self.assertIn("Success", self.check(
            "kirireel.deploy(model, thickness=0.02, contacts='auto', ground=True,"
            " gravity=(0, 0, -9.81), on_sample=lambda sample: sample.time < 1)"
            ".render(1.5, view='iso').mean()"))
        self.assertIn("Success", self.check("kirireel.generate('square_to_disk', half_size=3)"))

    def test_refuse_what_is_wrong(self):
        self.assertIn('Unexpected keyword argument "thicknes"',
                      self.check("kirireel.deploy(model, thicknes=0.02)"))
        self.assertIn("incompatible type", self.check("kirireel.deploy(model, contacts='some')"))


if __name__ == "__main__":
    unittest.main()
