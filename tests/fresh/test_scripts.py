"""The scripts and the configuration on machines with missing packages.

Other programs are replaced by ones of the test: a package is missing because apt, pkg-config or CMake
says so.
"""

import os
import pathlib
import shutil
import subprocess
import tempfile
import textwrap
import unittest

SOURCES = pathlib.Path(__file__).resolve().parents[2]


def copy_sources(folder):
    """The files of a clone."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=SOURCES, capture_output=True)
    if listed.returncode != 0:
        # Without git: all files except generated ones.
        shutil.copytree(SOURCES, folder, ignore=shutil.ignore_patterns("build", "out"))
        return
    for name in filter(None, listed.stdout.decode().split("\0")):
        if (SOURCES / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(SOURCES / name, folder / name)


def write_program(file, text):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("#!/usr/bin/env bash\n" + textwrap.dedent(text))
    file.chmod(0o755)


class Machine:
    """A folder with the sources, in one with a space in its name, and programs with priority on the path."""

    def __init__(self, folder):
        self.programs = pathlib.Path(folder, "bin")
        self.programs.mkdir()
        self.sources = pathlib.Path(folder, "a clone")
        copy_sources(self.sources)
        self.environment = {**os.environ, "PATH": f"{self.programs}:/usr/bin:/bin"}
        self.environment.pop("CI", None)

    def run(self, *words, **environment):
        return subprocess.run(list(map(str, words)), cwd=self.sources, text=True, capture_output=True,
                              stdin=subprocess.DEVNULL, env={**self.environment, **environment})

    def contents(self):
        return {file: (file.stat().st_mtime_ns, file.read_bytes())
                for file in self.sources.rglob("*") if file.is_file()}


class OnAMachine(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.machine = Machine(folder.name)


class Help(OnAMachine):
    def test_every_script_answers_and_changes_nothing(self):
        for name in ("apt-get", "sudo", "cmake", "ctest", "npm", "kirireel"):
            write_program(self.machine.programs / name, "echo started >> ../started; exit 99")
        before = self.machine.contents()
        scripts = [file for file in (self.machine.sources / "scripts").iterdir() if file.is_file()]
        self.assertGreater(len(scripts), 10)
        for script in scripts + [self.machine.sources / ".ci/run"]:
            for spelling in ("--help", "-h"):
                with self.subTest(script=script.name, spelling=spelling):
                    end = self.machine.run(script, spelling)
                    self.assertEqual(end.returncode, 0, end.stderr)
                    self.assertEqual(end.stderr, "")
                    self.assertIn(script.name.replace("run", "scripts/test"), end.stdout)
        self.assertEqual(before, self.machine.contents())
        self.assertFalse((self.machine.sources.parent / "started").exists())

    def test_plots_name_their_package(self):
        hidden = self.machine.sources.parent / "hidden"
        hidden.mkdir()
        (hidden / "matplotlib.py").write_text("raise ImportError")
        for words in (["plot-study", "docs/accuracy"],
                      ["plot-sweep", "t.csv", "--x", "a", "--y", "b", "--measure", "c"]):
            end = self.machine.run(f"scripts/{words[0]}", *words[1:], PYTHONPATH=str(hidden))
            self.assertEqual(end.returncode, 1)
            self.assertEqual(end.stderr, f"{words[0]}: matplotlib is missing; install python3-matplotlib (Debian)\n")

    def test_gallery_without_the_program_keeps_the_page(self):
        before = self.machine.contents()
        end = self.machine.run("scripts/gallery")
        self.assertEqual(end.returncode, 2)
        self.assertIn("gallery: there is no program", end.stderr)
        self.assertEqual(before, self.machine.contents())


class Setup(OnAMachine):
    """With a dpkg and an apt for the packages in the files installed, listed and archive."""

    def setUp(self):
        super().setUp()
        self.folder = self.machine.sources.parent
        write_program(self.machine.programs / "dpkg-query", """
            sed 's/$/ installed/' ../installed""")
        write_program(self.machine.programs / "apt-cache", """
            case $1 in
              pkgnames) cat ../installed ../listed ;;
              madison) grep -x "$2" ../listed || true ;;
            esac""")
        write_program(self.machine.programs / "apt-get", """
            echo "apt-get $*" >> ../log
            case " $* " in
              *" update "*) cp ../archive ../listed ;;
              *" install "*) printf '%s\\n' "$@" | grep -v ^- >> ../installed ;;
            esac""")
        write_program(self.machine.programs / "npm", "exit 0")
        everything = self.machine.run("scripts/setup", "--help")
        self.assertEqual(everything.returncode, 0)
        self.write("installed")
        self.write("listed")
        self.names = self.all_names()
        self.write("archive", "apt", *self.names)

    def write(self, name, *lines):
        (self.folder / name).write_text("".join(line + "\n" for line in lines))

    def all_names(self):
        """Every name in the lists of the script."""
        names = set()
        for line in (self.machine.sources / "scripts/setup").read_text().splitlines():
            word, _, why = line.partition("  ")
            if why and word and " " not in word and not word.startswith("#"):
                names.update(set(word.split("|")) - {"none"})
        self.assertGreater(len(names), 40)
        return sorted(names)

    def installed(self):
        return (self.folder / "installed").read_text().split()

    @unittest.skipIf(os.geteuid() != 0, "asks for sudo")
    def test_bare_system_gets_first_alternatives(self):
        end = self.machine.run("scripts/setup", "--with-tools")
        self.assertEqual(end.returncode, 0, end.stderr)
        self.assertIn("clang-14", self.installed())
        self.assertNotIn("clang", self.installed())
        self.assertIn("libosmesa6-dev", self.installed())
        self.assertNotIn("none", self.installed())
        again = self.machine.run("scripts/setup", "--with-tools")
        self.assertEqual(again.stdout, "setup: all packages are installed; nothing to do\n")

    @unittest.skipIf(os.geteuid() != 0, "asks for sudo")
    def test_next_alternative_where_the_first_does_not_exist(self):
        gone = {"clang-14", "libclang-rt-14-dev", "libosmesa6-dev", "calculix-ccx"}
        self.write("archive", "apt", *(name for name in self.names if name not in gone))
        end = self.machine.run("scripts/setup", "--with-tools")
        self.assertEqual(end.returncode, 0, end.stderr)
        self.assertIn("setup: there is no libosmesa6-dev here; Kirireel works without it", end.stdout)
        self.assertIn("clang", self.installed())
        self.assertIn("libclang-rt-dev", self.installed())
        self.assertFalse(gone & set(self.installed()))
        updates = (self.folder / "log").read_text().count("update")
        again = self.machine.run("scripts/setup", "--with-tools")
        self.assertIn("setup: all packages are installed; nothing to do\n", again.stdout)
        self.assertEqual((self.folder / "log").read_text().count("update"), updates)

    @unittest.skipIf(os.geteuid() != 0, "asks for sudo")
    def test_package_that_no_archive_has(self):
        self.write("archive", "apt", *(name for name in self.names if name != "libfmt-dev"))
        end = self.machine.run("scripts/setup")
        self.assertEqual(end.returncode, 1)
        self.assertEqual(end.stderr, "setup: this system has no package libfmt-dev; "
                                     "Debian 12 and 13 have all of them\n")
        self.assertEqual(self.installed(), [])

    def as_user(self, *words):
        """Without root and sudo."""
        script = self.machine.sources / "scripts/setup"
        script.write_text(script.read_text().replace("$EUID -eq 0", "1 -eq 0").replace(
            "command -v sudo", "command -v no_such_program"))
        return self.machine.run(script, *words)

    def test_user_without_sudo_gets_a_command_that_works(self):
        self.write("listed", "apt", *self.names)
        self.write("installed", *(name for name in self.names if name not in ("libfmt-dev", "gmsh")))
        end = self.as_user("--with-tools")
        self.assertEqual(end.returncode, 1)
        command = "apt-get update && apt-get install --no-install-recommends libfmt-dev gmsh"
        self.assertEqual(end.stderr, f"setup: not root and no sudo; run this as root:\n{command}\n")
        self.assertEqual(self.machine.run("bash", "-c", command).returncode, 0)
        self.assertIn("gmsh", self.installed())

    def test_user_without_sudo_and_lists_gets_a_command_that_works(self):
        end = self.as_user("--with-tools")
        self.assertEqual(end.returncode, 1)
        command = end.stderr.splitlines()[1]
        self.assertIn("a\\ clone/scripts/setup --with-tools", command)
        script = self.machine.sources / "scripts/setup"
        script.write_text(script.read_text().replace("1 -eq 0", "0 -eq 0"))
        self.assertEqual(self.machine.run("bash", "-c", command).returncode, 0)
        self.assertIn("clang-14", self.installed())


PACKAGES = {"Eigen3": "libeigen3-dev", "fmt": "libfmt-dev", "tomlplusplus": "libtomlplusplus-dev",
            "nlohmann_json": "nlohmann-json3-dev", "OpenSSL": "libssl-dev", "ZLIB": "zlib1g-dev",
            "CLI11": "libcli11-dev", "GTest": "libgtest-dev", "pybind11": "pybind11-dev"}
MODULES = {"hdf5": "libhdf5-dev", "bullet": "libbullet-dev", "assimp": "libassimp-dev",
           "cairo": "libcairo2-dev", "libavcodec": "libavcodec-dev", "libavfilter": "libavfilter-dev",
           "libavformat": "libavformat-dev", "libavutil": "libavutil-dev",
           "fontconfig": "libfontconfig-dev", "freetype2": "libfreetype-dev",
           "fribidi": "libfribidi-dev", "geos": "libgeos-dev", "harfbuzz": "libharfbuzz-dev",
           "libpng": "libpng-dev", "pugixml": "libpugixml-dev",
           "egl": "libegl-dev", "osmesa": "libosmesa6-dev"}


class Configuration(OnAMachine):
    def setUp(self):
        super().setUp()
        # HIDDEN has the names of modules that must be missing.
        write_program(self.machine.programs / "pkg-config", """
            for word in "$@"; do
              for name in ${HIDDEN:-}; do [[ $word != "$name"* ]] || exit 1; done
            done
            exec /usr/bin/pkg-config "$@" """)

    def configure(self, *words, hidden=()):
        return self.machine.run("cmake", "-S", ".", "-B", "build", "-G", "Ninja",
                                f"-DPKG_CONFIG_EXECUTABLE={self.machine.programs}/pkg-config", *words,
                                HIDDEN=" ".join(hidden))


class Messages(Configuration):
    def test_one_configuration_names_all_missing_packages(self):
        disabled = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in PACKAGES]
        end = self.configure("-DKIRIREEL_PYTHON=ON", *disabled, hidden=MODULES)
        self.assertNotEqual(end.returncode, 0)
        output = set(end.stderr.replace(",", " ").split())
        for package in [*PACKAGES.values(), *MODULES.values(), "libgmock-dev", "python3-dev"]:
            self.assertIn(package, output)
        self.assertNotIn("Unknown CMake command", end.stderr)
        listed = (SOURCES / "scripts/setup").read_text().replace("|", " ").split()
        for package in [*PACKAGES.values(), *MODULES.values()]:
            self.assertIn(package, listed)

    def test_pkg_config_itself(self):
        end = self.configure("-DCMAKE_DISABLE_FIND_PACKAGE_PkgConfig=ON")
        self.assertNotEqual(end.returncode, 0)
        self.assertIn("install --no-install-recommends pkg-config", end.stderr)


class LaterPackages(Configuration):
    """A second configuration finds new packages and omits removed ones."""

    def targets(self):
        return (self.machine.sources / "build/build.ninja").read_text()

    def test_python_module_and_egl(self):
        absent = "-DCMAKE_DISABLE_FIND_PACKAGE_pybind11=ON"
        first = self.configure(absent, hidden=["egl"])
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertIn("The Python module is left out; install pybind11-dev", first.stdout)
        self.assertNotIn("module.cpp", self.targets())
        self.assertNotIn("egl_backend", self.targets())
        second = self.configure(absent.replace("=ON", "=OFF"))
        self.assertEqual(second.returncode, 0, second.stderr)
        self.assertIn("module.cpp", self.targets())
        self.assertIn("egl_backend", self.targets())
        third = self.configure(absent, hidden=["egl"])
        self.assertEqual(third.returncode, 0, third.stderr)
        self.assertNotIn("module.cpp", self.targets())
        self.assertNotIn("egl_backend", self.targets())

    def test_required_library(self):
        missing = self.configure("-DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON", hidden=["hdf5"])
        self.assertIn("libhdf5-dev", missing.stderr)
        found = self.configure("-DCMAKE_DISABLE_FIND_PACKAGE_fmt=OFF")
        self.assertEqual(found.returncode, 0, found.stderr)


if __name__ == "__main__":
    unittest.main()
