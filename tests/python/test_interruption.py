"""Ctrl-C ends what runs, soon, and Python goes on as it was; other threads are not held up."""

import os
import pathlib
import signal
import tempfile
import threading
import time
import unittest

import kirireel
from support import model_folder

SOON = 0.3  # seconds; at most 0.1 measured, on a machine with much else to do


def interrupted_after(seconds, work):
    """How long after Ctrl-C the work raised."""
    sent = []

    def send():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(seconds, send)
    timer.start()
    try:
        work()
    except KeyboardInterrupt:
        return time.monotonic() - sent[0]
    finally:
        timer.cancel()
    raise AssertionError("the work ended before it was interrupted; it must take longer")


class Interruption(unittest.TestCase):
    def test_ends_a_run_soon(self):
        # Of 1,600 tiles it took 0.17 to 0.77 s on a loaded machine: a step is not taken apart.
        model = kirireel.generate("tessellation", columns=20, rows=20)
        for options in ({"path": "dynamic", "duration": 1000}, {"contacts": "all"}):
            for seconds in (0.2, 0.5, 1.0):
                took = interrupted_after(seconds, lambda: kirireel.deploy(model, **options))
                print(f"{options} after {seconds} s: {took:.3f} s")
                self.assertLess(took, SOON)

    def test_ends_saving(self):
        run = kirireel.deploy(kirireel.read(model_folder("cap")), size="1920x1080")
        with tempfile.TemporaryDirectory() as folder:
            took = interrupted_after(1.0, lambda: run.save(pathlib.Path(folder, "run")))
            self.assertFalse(pathlib.Path(folder, "run", "summary.json").exists())
        print(f"saving: {took:.3f} s")
        self.assertLess(took, 3)  # frames that wait are painted first; 0.5 s measured

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
