"""Arrays: shapes, no copies, and values, against trajectory.h5 and closed forms."""

import gc
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import kirireel
from support import model_folder, run_program


def address(array):
    return array.__array_interface__["data"][0]


def turned(rotations, vectors):
    """Vectors turned by unit quaternions w x y z: v + 2 w (q x v) + 2 q x (q x v)."""
    w, q = rotations[..., :1], rotations[..., 1:]
    cross = np.cross(q, vectors)
    return vectors + 2 * (w * cross + np.cross(q, cross))


class Arrays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.model = kirireel.read(model_folder("tessellation_4x4"))
        cls.run_ = kirireel.deploy(cls.model)

    def test_have_the_shapes_that_they_say(self):
        samples = len(self.run_.time)
        self.assertEqual(self.run_.position.shape, (samples, 16, 3))
        self.assertEqual(self.run_.rotation.shape, (samples, 16, 4))
        self.assertEqual(self.run_.velocity.shape, (samples, 16, 3))
        self.assertEqual(self.run_.angular_velocity.shape, (samples, 16, 3))
        for curve in (self.run_.joint_gap, self.run_.target_error, self.run_.penetration):
            self.assertEqual(curve.shape, (samples,))

    def test_are_views_of_the_run(self):
        for name in ("time", "position", "rotation", "velocity", "angular_velocity", "joint_gap"):
            first, second = getattr(self.run_, name), getattr(self.run_, name)
            self.assertEqual(address(first), address(second), name)
            self.assertIs(first.base, self.run_, name)
            self.assertFalse(first.flags.owndata, name)
            self.assertFalse(first.flags.writeable, name)

    def test_keep_their_run_alive(self):
        position = kirireel.deploy(self.model).position
        before = position.copy()
        gc.collect()
        np.testing.assert_array_equal(position, before)

    def test_put_each_corner_at_its_target(self):
        start = np.concatenate(self.model.tiles).reshape(16, 4, 3)
        # A brick's origin is its centre of mass, half a thickness above its bottom, in the plane the
        # mean of a rectangle's corners.
        arms = start - self.run_.position[0][:, None]
        end = self.run_.position[-1][:, None] + turned(self.run_.rotation[-1][:, None], arms)
        target = np.concatenate(self.run_.model.target).reshape(16, 4, 3)
        self.assertLess(np.abs(end - target).max(), 1e-9)  # 2e-14 measured

    def test_velocities_are_those_of_the_poses(self):
        # Squares turn by 45 degrees each way about z, and the angle of a path at an even pace
        # is the integral of its speed: the trapezoid of central differences is exact at the ends.
        turn = np.trapz(self.run_.angular_velocity[:, :, 2], self.run_.time, axis=0)
        np.testing.assert_allclose(np.abs(turn), np.pi / 4, rtol=0.01)

    def test_opened_run_is_the_deployed_one(self):
        with tempfile.TemporaryDirectory() as folder:
            self.run_.save(folder)
            opened = kirireel.open(pathlib.Path(folder) / "trajectory.h5")
            for name in ("time", "position", "rotation", "joint_gap", "target_error"):
                np.testing.assert_array_equal(getattr(opened, name), getattr(self.run_, name))
            self.assertEqual(opened.events, self.run_.events)
            np.testing.assert_array_equal(opened.render(size="64x48"), self.run_.render(size="64x48"))

    def test_sample_by_sample(self):
        times, heights = [], []

        def note(sample):
            times.append(sample.time)
            heights.append(sample.position)
            return sample.time < 1

        run = kirireel.deploy(self.model, on_sample=note)
        self.assertEqual(run.outcome, "interrupted")
        np.testing.assert_array_equal(times, run.time[: len(times)])
        np.testing.assert_array_equal(heights, run.position[: len(heights)])
        self.assertLess(run.time[-1], 1.1)


class Pictures(unittest.TestCase):
    def test_are_the_programs(self):
        with tempfile.TemporaryDirectory() as folder:
            words = ("--size", "160x120", "--view", "iso", "--frames-at", "0,100%", "--no-video")
            model = model_folder("tessellation_4x4")
            run_program("record", model, "--out", folder, *words)
            import matplotlib.image

            run = kirireel.deploy(kirireel.read(model))
            for time, file in zip((0, None), sorted(pathlib.Path(folder, "frames").iterdir())):
                ours = run.render(time, size="160x120", view="iso")
                theirs = np.rint(255 * matplotlib.image.imread(file)).astype(np.uint8)
                self.assertEqual(ours.shape, (120, 160, 4))
                np.testing.assert_array_equal(ours[..., :3], theirs[..., :3])


    def test_turn_with_the_orbit(self):
        run = kirireel.deploy(kirireel.read(model_folder("cap")))
        pictures = {}
        for time, behind in ((0, 0), (None, 90)):
            # The orbit is at 0 at the start and complete at the end; full turns have no effect.
            orbit = run.render(time, view="40,30", orbit=90, size="80x60")
            there = run.render(time, view=f"{40 + behind},30", orbit=360, size="80x60")
            self.assertLess(np.abs(orbit.astype(int) - there).max(), 2)
            pictures[behind] = orbit.astype(int)
        far = run.render(view="40,30", orbit=360, size="80x60")
        self.assertGreater(np.abs(pictures[90] - far).mean(), 1)

    def test_are_painted_by_several_threads(self):
        # A separate process: the first calls of several threads may wait for each other.
        script = """
import sys, concurrent.futures, kirireel
run = kirireel.deploy(kirireel.read(sys.argv[1]))
with concurrent.futures.ThreadPoolExecutor(4) as pool:
    pictures = {picture.tobytes() for picture in pool.map(lambda k: run.render(size="80x60"), range(8))}
print(len(pictures))
"""
        output = subprocess.check_output([sys.executable, "-c", script, model_folder("cap")],
                                       text=True, timeout=120)
        self.assertEqual(output, "1\n")


class Families(unittest.TestCase):
    def test_have_their_parameters(self):
        model = kirireel.generate("tessellation", columns=3, rows=2, length=2.0)
        self.assertEqual(len(model.tiles), 6)
        self.assertAlmostEqual(np.ptp(model.tiles[0][:, 0]), 2.0)
        self.assertEqual(model.joints.shape[1], 5)

    def test_are_the_programs(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            run_program("generate", "cylinder", folder / "theirs")
            kirireel.generate("cylinder").write(folder / "ours")
            for file in (folder / "theirs").iterdir():
                self.assertEqual((folder / "ours" / file.name).read_bytes(), file.read_bytes())


if __name__ == "__main__":
    unittest.main()
