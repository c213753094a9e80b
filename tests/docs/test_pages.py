"""Runs every block of README.md, docs/guide.md and docs/gallery.md, each page in a folder of its own.

Fenced blocks say what they are. `sh install` is for a system without a compiler, where
tests/package/bare_root runs it. README's blocks are indented; what they are shows in how they begin.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCES = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ["KIRIREEL_PROGRAM"])
BUILD = pathlib.Path(os.environ["KIRIREEL_BUILD"])
FINE = (0, 3)  # exit code 3: a run ended short of its target, which is no mistake of the page


def fenced_blocks(text):
    return re.findall(r"^```(\S[^\n]*)\n(.*?)^```$", text, re.M | re.S)


def indented_blocks(text):
    blocks = re.findall(r"(?:^|\n\n)((?:    [^\n]*\n(?:\n(?=    ))?)+)", text)
    return [re.sub(r"^    ", "", block, flags=re.M) for block in blocks]


class Page:
    """A folder in which a page's blocks run one after the other."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        for name in ("data", "docs", "scripts"):
            (self.folder / name).symlink_to(SOURCES / name)
        # The page's program, and the Python that the module is for.
        commands = self.folder / ".bin"
        commands.mkdir()
        (commands / "kirireel").symlink_to(PROGRAM)
        (commands / "python3").symlink_to(sys.executable)
        self.environment = {**os.environ, "PATH": f"{commands}:{os.environ['PATH']}"}

    def run(self, *words):
        end = subprocess.run([str(word) for word in words], cwd=self.folder, text=True,
                             env=self.environment, capture_output=True)
        if end.returncode not in FINE:
            raise AssertionError(f"{words}: exit code {end.returncode}\n{end.stdout}{end.stderr}")
        return end.stdout

    def shell(self, block):
        for line in block.splitlines():
            if line:
                self.run("bash", "-c", line)

    def write(self, name, block):
        (self.folder / name).write_text(block)


def run_link(page, block):
    """The example of the page against what this build installs."""
    prefix = page.folder / "installed"
    page.run("cmake", "--install", BUILD, "--prefix", prefix, "--component", "development")
    page.environment["CMAKE_PREFIX_PATH"] = str(prefix)
    page.shell(block)


def run_octave(page, block):
    if shutil.which("octave-cli"):
        page.write("block.m", block)
        return page.run("octave-cli", "--no-gui", "-q", "block.m")
    print("octave is not installed: its block was left out")
    return ""


def run_fenced(page, kind, block):
    if kind == "sh":
        page.shell(block)
    elif kind == "sh install":
        page.run("bash", "-n", "-c", block)
    elif kind == "sh link":
        run_link(page, block)
    elif kind == "python":
        page.run("python3", "-W", "ignore", "-c", block)
    elif kind == "octave":
        run_octave(page, block)
    elif kind.startswith("toml "):
        page.write(kind.split()[1], block)
    else:
        raise AssertionError(f"no test knows what to do with a block of {kind}")


def run_indented(page, block):
    """Of README.md."""
    if "──" in block:
        return  # a drawing
    if block.startswith("scripts/"):
        for line in block.splitlines():
            page.run("bash", "-n", line.split()[0])  # they build, and run these tests
    elif block.startswith(("kirireel", "build/release/render/cli/kirireel")):
        page.shell(block.replace("build/release/render/cli/kirireel", "kirireel"))
    elif block.startswith("generate ="):
        page.write("sweep.toml", block)
        page.run("kirireel", "sweep", "sweep.toml")
    elif block.startswith("["):
        page.write("scene.toml", block)
        page.run("kirireel", "simulate", "data/tessellation_4x4", "--scene", "scene.toml",
                 "--contacts", "none", "--duration", "2")
    else:
        raise AssertionError(f"no test knows what to do with this block:\n{block}")


class Pages(unittest.TestCase):
    def run_page(self, name, blocks, run):
        self.assertTrue(blocks, f"{name} has no blocks")
        with tempfile.TemporaryDirectory() as folder:
            page = Page(folder)
            for block in blocks:
                with self.subTest(block=block):
                    run(page, block)

    def test_readme(self):
        text = (SOURCES / "README.md").read_text()
        self.run_page("README.md", indented_blocks(text), run_indented)

    def test_guide(self):
        text = (SOURCES / "docs/guide.md").read_text()
        self.run_page("docs/guide.md", fenced_blocks(text),
                      lambda page, block: run_fenced(page, *block))

    def test_gallery_shows_every_family(self):
        text = (SOURCES / "docs/gallery.md").read_text()
        help_text = subprocess.run([PROGRAM, "generate", "--help"], text=True, capture_output=True)
        families = re.findall(r"^  ([a-z-]+) ", help_text.stdout.split("Subcommands:")[1], re.M)
        shown = [block.split()[2] for _, block in fenced_blocks(text)]
        self.assertEqual(shown, families)
        for picture in re.findall(r"\]\(([^)]+\.png)\)", text):
            self.assertTrue((SOURCES / "docs" / picture).exists(), picture)

    def test_gallery(self):
        text = (SOURCES / "docs/gallery.md").read_text()
        self.run_page("docs/gallery.md", fenced_blocks(text),
                      lambda page, block: run_fenced(page, *block))


class Examples(unittest.TestCase):
    def test_angle_is_that_of_the_closed_form(self):
        with tempfile.TemporaryDirectory() as folder:
            said = Page(folder).run("python3", "docs/examples/python/optimise_angle.py")
        # cos(a/2) + sin(a/2) = 1.3: a = 2 asin(1.3 / sqrt(2)) - 90 degrees = 43.630
        self.assertAlmostEqual(float(said.split()[0]), 43.630, delta=0.01)

    def test_figure_is_a_picture(self):
        with tempfile.TemporaryDirectory() as folder:
            Page(folder).run("python3", "docs/examples/python/plot_study.py", "study.png")
            picture = pathlib.Path(folder, "study.png").read_bytes()
        self.assertTrue(picture.startswith(b"\x89PNG"))

    def test_octave_reads_what_python_reads(self):
        if not shutil.which("octave-cli"):
            self.skipTest("install octave to read a trajectory by it")
        import kirireel

        with tempfile.TemporaryDirectory() as folder:
            page = Page(folder)
            run = kirireel.deploy(kirireel.read(SOURCES / "data/cap"), no_video=True, no_snapshots=True)
            run.save(page.folder / "run")
            said = run_octave(page, 'addpath ("docs/examples/octave");'
                              'run = read_trajectory ("run/trajectory.h5");'
                              'printf ("%.17g %.17g %.17g %d", run.time(end), '
                              'run.position(1, 2, end), run.rotation(4, 3, end), columns (run.position));')
        time, place, turn, tiles = map(float, said.split())
        self.assertEqual(time, run.time[-1])
        self.assertEqual(place, run.position[-1, 1, 0])
        self.assertEqual(turn, run.rotation[-1, 2, 3])
        self.assertEqual(tiles, run.position.shape[1])


if __name__ == "__main__":
    unittest.main()
