"""Runs every block of README.md and of the pages in docs/ that have blocks, in a copy of the sources.

The fence of a block has its kind. `sh root` installs packages of Debian, `sh clone` the program from the
sources, and `sh install` our packages; these blocks run in a bare Debian, for pages_on_bare_debian and
tests/package/bare_root.
"""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from fresh.test_scripts import copy_sources

SOURCES = pathlib.Path(__file__).resolve().parents[2]
FINE = (0, 3)  # exit code 3: a run ended short of its target, which is not an error of the page


def fenced_blocks(text):
    return re.findall(r"^```(\S[^\n]*)\n(.*?)^```$", text, re.M | re.S)


def blocks_of(name):
    blocks = fenced_blocks((SOURCES / name).read_text())
    if not blocks:
        raise AssertionError(f"{name} has no blocks")
    return blocks


def commands(kind, block, place):
    """Shell commands that run a block. place: "here", or in a bare Debian "clone" (in the folder of the
    sources) or "packages" (which are in /root)."""
    here = "'END OF BLOCK'"
    lines = [line for line in block.replace("\\\n", " ").splitlines() if line]
    if kind in ("sh", "sh link"):
        return lines
    if kind in ("sh root", "sh path", "sh clone"):
        if place == "here":
            return [line for line in lines if line.startswith(("kirireel ", "scripts/plot"))]
        return lines if (kind, place) != ("sh clone", "packages") else []
    if kind == "sh install":
        return [f"(cd /root && {line})" for line in lines] if place == "packages" else []
    if kind == "sh packages":
        return lines if place == "packages" else []
    if kind in ("sh sources", "sh cluster", "sh example", "sh record", "toml part"):
        return []
    if kind == "python":
        return [f"python3 -W ignore - <<{here}\n{block}END OF BLOCK"]
    if kind == "octave":
        return [f"cat > block.m <<{here}\n{block}END OF BLOCK", "octave-cli --no-gui -q block.m"]
    if kind.startswith("toml "):
        name = kind.split()[1]
        run = {"scene.toml": ["kirireel simulate tessellation_4x4 --scene scene.toml --contacts none --duration 2"],
               "sweep.toml": ["kirireel sweep sweep.toml"]}
        return [f"cat > {name} <<{here}\n{block}END OF BLOCK", *run.get(name, [])]
    raise AssertionError(f"no test knows what to do with a block of {kind}")


def bare_script(name, place):
    """A shell script of a page, for a bare Debian."""
    steps = ["set -u"]
    for kind, block in blocks_of(name):
        for command in commands(kind, block, place):
            steps.append(f"echo {shlex.quote('+ ' + command.splitlines()[0])}")
            steps.append(command)
            steps.append("code=$?; if [ $code != 0 ] && [ $code != 3 ]; then echo failed: exit code $code; exit 1; fi")
    return "\n".join(steps) + "\n"


class Page:
    """A copy of the sources in which a page's blocks run one after the other."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder, "a clone")
        copy_sources(self.folder)
        # The program of this build, and the Python of its module.
        programs = pathlib.Path(folder, "bin")
        programs.mkdir()
        (programs / "kirireel").symlink_to(os.environ["KIRIREEL_PROGRAM"])
        (programs / "python3").symlink_to(sys.executable)
        self.environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}

    def run(self, *words):
        end = subprocess.run([str(word) for word in words], cwd=self.folder, text=True,
                             env=self.environment, capture_output=True)
        if end.returncode not in FINE:
            raise AssertionError(f"{words}: exit code {end.returncode}\n{end.stdout}{end.stderr}")
        return end.stdout

    def run_block(self, kind, block):
        if kind == "octave" and not shutil.which("octave-cli"):
            print("octave is not installed: its block was left out")
            return ""
        if kind == "sh link":
            # The installed files of this build.
            prefix = self.folder / "installed"
            self.run("cmake", "--install", os.environ["KIRIREEL_BUILD"], "--prefix", prefix,
                     "--component", "development")
            self.environment["CMAKE_PREFIX_PATH"] = str(prefix)
        if kind.startswith("sh"):
            self.run("bash", "-n", "-c", block)
        return "".join(self.run("bash", "-c", command) for command in commands(kind, block, "here"))


class Pages(unittest.TestCase):
    def run_page(self, name):
        with tempfile.TemporaryDirectory() as folder:
            page = Page(folder)
            for kind, block in blocks_of(name):
                with self.subTest(block=block):
                    page.run_block(kind, block)

    def test_readme(self):
        self.run_page("README.md")

    def test_readme_names_the_defaults_of_the_help(self):
        help_text = subprocess.run([os.environ["KIRIREEL_PROGRAM"], "record", "--help", "all"],
                                   text=True, capture_output=True).stdout
        help_text = re.sub(r"\n {26}", " ", help_text)  # one option per line
        defaults = dict(re.findall(r"^  (--[a-z-]+) .*\(default ([\w.]+)[^()]*\)$", help_text, re.M))
        rows = re.findall(r"^\| `(--[a-z-]+)[^`]*` \|.*?\((\d[\w.]*|auto)\b", (SOURCES / "README.md").read_text(), re.M)
        self.assertGreater(len(rows), 4)
        for option, default in rows:
            self.assertEqual(default, defaults[option], option)

    def test_python(self):
        self.run_page("docs/python.md")

    def test_models(self):
        self.run_page("docs/models.md")

    def test_figures(self):
        self.run_page("docs/figures.md")

    def test_video(self):
        self.run_page("docs/video.md")

    def test_fea(self):
        self.run_page("docs/fea.md")

    def test_files(self):
        self.run_page("docs/files.md")

    def test_scenes(self):
        self.run_page("docs/scenes.md")

    def test_elastic(self):
        self.run_page("docs/elastic.md")

    def test_sweeps(self):
        self.run_page("docs/sweeps.md")

    def test_gallery_shows_every_family_and_drawing(self):
        text = (SOURCES / "docs/gallery.md").read_text()
        help_text = subprocess.run([os.environ["KIRIREEL_PROGRAM"], "generate", "--help"], text=True, capture_output=True)
        listed = re.sub(r"\n {26}", " ", help_text.stdout.split("Subcommands:")[1])
        families = re.findall(r"^  ([a-z-]+) ", listed, re.M)
        shown = [block.split()[2] for kind, block in fenced_blocks(text) if kind == "sh"]
        drawn = [name for name in shown if name.startswith("docs/drawings/")]
        self.assertEqual(shown, families + drawn)
        drawings = (SOURCES / "docs/drawings").iterdir()
        self.assertEqual(sorted(drawn), sorted(f"docs/drawings/{path.name}" for path in drawings))
        for picture in re.findall(r"\]\(([^)]+\.png)\)", text):
            self.assertTrue((SOURCES / "docs" / picture).exists(), picture)

    def test_gallery(self):
        [record] = [block for kind, block in blocks_of("docs/gallery.md") if kind == "sh record"]
        with tempfile.TemporaryDirectory() as folder:
            page = Page(folder)
            for kind, block in blocks_of("docs/gallery.md"):
                with self.subTest(block=block):
                    page.run_block(kind, block)
                    if block.startswith("kirireel generate "):
                        page.run_block("sh", record.replace("MODEL", block.split()[2]))

    def test_links_lead_to_files(self):
        for page in [*SOURCES.glob("*.md"), *SOURCES.glob("docs/*.md"), SOURCES / "data/README.md"]:
            for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text()):
                with self.subTest(page=page.name, target=target):
                    self.assertTrue((page.parent / target).exists())


class Examples(unittest.TestCase):
    def test_angle_is_that_of_the_closed_form(self):
        with tempfile.TemporaryDirectory() as folder:
            output = Page(folder).run("python3", "docs/examples/python/optimise_angle.py")
        # cos(a/2) + sin(a/2) = 1.3: a = 2 asin(1.3 / sqrt(2)) - 90 degrees = 43.630
        self.assertAlmostEqual(float(output.split()[0]), 43.630, delta=0.01)

    def test_figure_is_a_picture(self):
        with tempfile.TemporaryDirectory() as folder:
            page = Page(folder)
            page.run("python3", "docs/examples/python/plot_study.py", "study.png")
            picture = (page.folder / "study.png").read_bytes()
        self.assertTrue(picture.startswith(b"\x89PNG"))

    def test_octave_reads_what_python_reads(self):
        if not shutil.which("octave-cli"):
            self.skipTest("install octave to read a trajectory by it")
        import kirireel

        with tempfile.TemporaryDirectory() as folder:
            page = Page(folder)
            run = kirireel.deploy(kirireel.read(SOURCES / "data/cap"), no_video=True, no_snapshots=True)
            run.save(page.folder / "run")
            output = page.run_block("octave", 'addpath ("docs/examples/octave");'
                              'run = read_trajectory ("run/trajectory.h5");'
                              'printf ("%.17g %.17g %.17g %d", run.time(end), '
                              'run.position(1, 2, end), run.rotation(4, 3, end), columns (run.position));\n')
        time, place, turn, tiles = map(float, output.split())
        self.assertEqual(time, run.time[-1])
        self.assertEqual(place, run.position[-1, 1, 0])
        self.assertEqual(turn, run.rotation[-1, 2, 3])
        self.assertEqual(tiles, run.position.shape[1])


if __name__ == "__main__":
    print(bare_script(*sys.argv[1:]), end="")
