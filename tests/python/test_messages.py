"""Errors are those of the program, warnings are issued, and every option has a docstring and a type."""

import ast
import inspect
import pathlib
import subprocess
import unittest
import warnings

import kirireel
from support import PROGRAM, model_folder


class Messages(unittest.TestCase):
    def setUp(self):
        self.model = kirireel.read(model_folder("tessellation_4x4"))

    def message(self, **options):
        with self.assertRaises(kirireel.InputError) as caught:
            kirireel.deploy(self.model, **options)
        return str(caught.exception)

    def test_are_those_of_the_command_line(self):
        words = {"thicknes": 1, "contacts": "some", "thickness": -1, "density": 5}
        for name, value in words.items():
            option = f"--{name}={value}"
            end = subprocess.run([PROGRAM, "record", model_folder("cap"), option],
                                 capture_output=True, text=True)
            self.assertEqual("kirireel: " + self.message(**{name: value}) + "\n", end.stderr)

    def test_name_what_a_call_has_not(self):
        self.assertEqual(self.message(out="x"),
                         "error: out is not an option of this call; remove it")

    def test_are_also_what_python_calls_them(self):
        with self.assertRaisesRegex(ValueError, "nowhere: error: there is no such folder"):
            kirireel.read("nowhere")
        with self.assertRaisesRegex(kirireel.InputError, "the model's name is empty"):
            kirireel.read("")
        with self.assertRaisesRegex(OSError, "error"):
            kirireel.deploy(self.model, duration=0.1, no_video=True).save("/proc/kirireel")
        self.assertTrue(issubclass(kirireel.RunError, kirireel.Error))

    def test_of_a_callback_come_through(self):
        def fail(sample):
            raise KeyError("mine")

        with self.assertRaisesRegex(KeyError, "mine"):
            kirireel.deploy(self.model, on_sample=fail)

    def test_warnings_are_pythons(self):
        with warnings.catch_warnings(record=True) as issued:
            warnings.simplefilter("always")
            kirireel.deploy(self.model, thickness=5)
        self.assertIn("bricks are 5 m thick", str(issued[0].message))


class Options(unittest.TestCase):
    def test_take_values_of_all_kinds(self):
        run = kirireel.deploy(kirireel.read(model_folder("tessellation_4x4")),
                              gravity=(0, 0, -9.81), ground=True, pin=[0, 5], no_align=False,
                              fix=[[1, 2]], path=None, duration=0.05)
        self.assertEqual(run.summary["settings"]["environment"]["gravity"], [0, 0, -9.81])
        self.assertEqual(run.outcome, "out_of_time")

    def test_have_docstrings_with_units(self):
        self.assertIn("thickness (LENGTH): thickness of the bricks", kirireel.deploy.__doc__)
        self.assertIn("length (METRES): of a tile along x", kirireel.generate.__doc__)
        self.assertIn("view (WORD|AZ,EL[,ROLL])", kirireel.Trajectory.render.__doc__)

    def test_have_types(self):
        stub = ast.parse(pathlib.Path(kirireel.__file__).with_name("__init__.pyi").read_text())
        functions = {node.name: node for node in stub.body if isinstance(node, ast.FunctionDef)}
        typed = {argument.arg for argument in functions["deploy"].args.kwonlyargs}
        for name in ("thickness", "contacts", "spring_stiffness", "on_sample", "fps", "scene"):
            self.assertIn(name, typed)
        self.assertTrue(typed.isdisjoint({"out", "json", "help"}))
        typed = {argument.arg for argument in functions["read"].args.kwonlyargs}
        self.assertTrue(typed.issuperset({"unit", "strict", "joints_file", "widest_neck"}))
        self.assertTrue(typed.isdisjoint({"target", "help"}))

    def test_public_names_have_docstrings(self):
        for kind in (kirireel.Model, kirireel.Sample, kirireel.Trajectory, kirireel.Run):
            self.assertTrue(kind.__doc__)
            for name, member in inspect.getmembers(kind):
                if not name.startswith("_") and name != "name":
                    self.assertTrue(member.__doc__, f"{kind.__name__}.{name}")


if __name__ == "__main__":
    unittest.main()
