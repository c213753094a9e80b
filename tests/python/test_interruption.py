"""Ctrl-C ends a run soon, and Python continues. Other threads are not blocked."""

import os
import pathlib
import signal
import tempfile
import threading
import time
import unittest

import kirireel
from support import model_folder

SOON = 0.3  # seconds; 0.001 to 0.28 measured
SIDES = (20, 40, 100)  # of square sheets: 400, 1,600 and 10,000 tiles


def clock():
    """Seconds, without waits of the main thread for a core."""
    waited = int(pathlib.Path("/proc/self/schedstat").read_text().split()[1])
    return time.monotonic() - 1e-9 * waited


def interrupted_after(seconds, work):
    """Time from Ctrl-C to the exception, seconds."""
    sent = []

    def send():
        sent.append(clock())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(seconds, send)
    timer.start()
    try:
        while True:
            work()
    except KeyboardInterrupt:
        return clock() - sent[0]
    finally:
        timer.cancel()


class Interruption(unittest.TestCase):
    def check(self, what, work, moments=(0.05, 0.3, 1.0)):
        """Repeated work ends soon after a Ctrl-C at any of these seconds.

        Other programs on the machine may delay an attempt, so there are three.
        """
        for seconds in moments:
            for _ in range(3):
                took = interrupted_after(seconds, work)
                print(f"{what} after {seconds} s: {took:.3f} s")
                if took < SOON:
                    break
            self.assertLess(took, SOON, what)

    def sheets(self):
        for side in SIDES:
            yield side * side, kirireel.generate("tessellation", columns=side, rows=side)

    def test_ends_making_and_reading_models(self):
        with tempfile.TemporaryDirectory() as folder:
            for count, model in self.sheets():
                place = pathlib.Path(folder, str(count))
                model.write(place)
                self.check(f"reading {count} tiles", lambda: kirireel.read(place))
                side = round(count ** 0.5)
                self.check(f"making {count} tiles",
                           lambda: kirireel.generate("tessellation", columns=side, rows=side))

    def test_ends_the_search_for_a_path(self):
        for count, model in self.sheets():
            self.check(f"path of {count} tiles", lambda: kirireel.deploy(model))
            self.check(f"path of {count} tiles that touch",
                       lambda: kirireel.deploy(model, contacts="all"))

    def test_ends_dynamics(self):
        # Gravity along the sheet keeps it moving; no path is searched.
        options = {"actuation": "none", "gravity": (1, 0, 0), "duration": 1000, "planar": "off"}
        for count, model in self.sheets():
            for contacts in ("none", "all"):
                self.check(f"dynamics of {count} tiles, contacts {contacts}",
                           lambda: kirireel.deploy(model, contacts=contacts, **options))

    def test_ends_painting_and_saving(self):
        for count, model in self.sheets():
            run = kirireel.deploy(model, path="dynamic", search_effort=0, duration=0.1)
            self.check(f"a picture of {count} tiles", lambda: run.render(size="1920x1080"))
            with tempfile.TemporaryDirectory() as folder:
                place = pathlib.Path(folder, "run")
                self.check(f"saving {count} tiles", lambda: run.save(place), (0.1, 0.5, 1.5, 3))

    def test_leaves_no_half_saved_run(self):
        run = kirireel.deploy(kirireel.read(model_folder("cap")), size="1920x1080")
        with tempfile.TemporaryDirectory() as folder:
            self.check("saving", lambda: run.save(pathlib.Path(folder, "run")), (1.0,))
            self.assertFalse(pathlib.Path(folder, "run", "summary.json").exists())

    def test_leaves_pythons_handler(self):
        before = signal.getsignal(signal.SIGINT)
        kirireel.deploy(kirireel.read(model_folder("tessellation_4x4")))
        self.assertIs(signal.getsignal(signal.SIGINT), before)
        with self.assertRaises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(1)

    def test_other_threads_run_meanwhile(self):
        counted, done = [0], threading.Event()

        def count():
            while not done.is_set():
                counted[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        start = time.monotonic()
        kirireel.deploy(kirireel.read(model_folder("cap")), path="dynamic", duration=2)
        seconds = time.monotonic() - start
        done.set()
        thread.join()
        self.assertGreater(counted[0], 100 * seconds)  # of at most 1000 a second


if __name__ == "__main__":
    unittest.main()
