"""A run saved from Python has the program's bytes; two threads at once make the same."""

import json
import pathlib
import tempfile
import threading
import unittest

import kirireel
from support import model_folder, run_program

# In the plane, in space, with contacts, without a target, and as dynamics.
RUNS = {
    "tessellation_4x4": {},
    "cap": {"thickness": 0.02, "contacts": "auto"},
    "fan": {"view": "iso", "grid": "2x2"},
    "stampfli_24": {"duration": 2},
    "triangles": {"gravity": -9.81, "ground": True, "duration": 1},
}
SMALL = {"size": "320x240"}


def words_of(options):
    words = []
    for name, value in options.items():
        name = "--" + name.replace("_", "-")
        words.append(name if value is True else f"{name}={value}")
    return words


def contents(folder):
    """All files by name; of the summary only the reproducible part."""
    files = {}
    for file in sorted(pathlib.Path(folder).rglob("*")):
        if file.is_file():
            files[str(file.relative_to(folder))] = file.read_bytes()
    summary = json.loads(files["summary.json"])
    for key in ("cost", "versions", "sha256"):
        del summary[key]
    files["summary.json"] = summary
    return files


class Bytes(unittest.TestCase):
    def test_are_the_programs(self):
        for name, options in RUNS.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                ours, theirs = pathlib.Path(folder, "ours"), pathlib.Path(folder, "theirs")
                options = {**options, **SMALL}
                run_program("record", model_folder(name), "--out", theirs, *words_of(options))
                names = kirireel.deploy(kirireel.read(model_folder(name)), **options).save(ours)
                expected, found = contents(theirs), contents(ours)
                self.assertEqual(sorted(names), sorted(expected))
                self.assertEqual(sorted(found), sorted(expected))
                for file, bytes_ in expected.items():
                    self.assertEqual(found[file] == bytes_, True, f"{name}: {file} differs")
                self.assertEqual(run_program("verify", ours).returncode, 0)

    def test_do_not_depend_on_other_threads(self):
        model = kirireel.read(model_folder("cap"))
        single = kirireel.deploy(model, path="dynamic", duration=2)
        runs = [None, None]

        def work(k):
            runs[k] = kirireel.deploy(model, path="dynamic", duration=2)

        threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for run in runs:
            for name in ("time", "position", "rotation", "penetration", "target_error"):
                self.assertEqual(getattr(run, name).tobytes(), getattr(single, name).tobytes(), name)


if __name__ == "__main__":
    unittest.main()
