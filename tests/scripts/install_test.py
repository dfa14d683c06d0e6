"""arkmesh installed and moved: its programs find what they need, and a scenario of one's own in C++ is made, built, run and tested against it."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/release"
# Runs a command where the sources and their build are an empty folder.
AS_ROOT = () if os.getuid() == 0 else ("--user", "--map-root-user")
WITHOUT_SOURCES = "unshare", *AS_ROOT, "--mount", "sh", "-c", 'mount -t tmpfs none "$0" && exec "$@"', ROOT


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        subprocess.run(["cmake", "--install", BUILD, "--prefix", cls.folder / "first"], check=True, capture_output=True)
        cls.prefix = cls.folder / "moved here"
        shutil.move(cls.folder / "first", cls.prefix)
        cls.environment = {**os.environ, "ARKMESH_PYTHON": "/usr/bin/python3", "XDG_CACHE_HOME": str(cls.folder / "cache"),
                           "PATH": f"{cls.prefix}/bin:{os.environ['PATH']}"}

    def run_it(self, *command, code=0, around=WITHOUT_SOURCES):
        command = *around, *command
        done = subprocess.run(list(map(str, command)), cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=600)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def final_hash(self, out):
        return json.loads((self.folder / out / "a/result.json").read_text())["final_hash"]

    def test_a_scenario_in_cpp_against_the_installed_tree(self):
        """It is built and run where the sources are hidden, its test passes, and its hash is that of the built-in twin and of the one in Python."""
        said = self.run_it("arkmesh", "scenario", "new", "my_swarm", "--cpp")
        for file in (self.folder / "my_swarm").iterdir():
            self.assertNotRegex(file.read_text(), r"(?i)light[_-]?up|\.py\b", file.name)
        commands = {line.split()[0]: line.split(" it with ")[1] for line in said.splitlines() if " it with " in line}
        built = self.run_it("sh", "-c", "export CMAKE_GENERATOR=Ninja CMAKE_EXPORT_COMPILE_COMMANDS=ON VERBOSE=1; " + commands["build"])
        for text in (built, (self.folder / "my_swarm/build/compile_commands.json").read_text()):
            self.assertNotIn(str(ROOT), text)
            self.assertIn("-ffp-contract=off", text)
        self.run_it("ctest", "--test-dir", "my_swarm/build", "--no-tests=error", "--output-on-failure")
        self.assertIn("20 s simulated", self.run_it("sh", "-c", commands["run"]))
        program = self.folder / "my_swarm/build/my_swarm"
        labs = "my_swarm/a.toml", "my_swarm/b.toml"
        more = "--seconds", "20", "--seed", "1"
        self.run_it(program, "run", *labs, *more, "--out", "own")
        built_in = [word for lab in "ab" for word in ("--set", f"{lab}:run.scenario=light_up")]
        self.run_it("arkmesh", "run", *labs, *more, *built_in, "--out", "built_in")
        python = [self.prefix / f"share/arkmesh/experiments/light_up/{lab}.toml" for lab in "ab"]
        self.run_it("arkmesh", "run", *python, *more, "--out", "python")
        for out in ("built_in", "python"):
            self.assertEqual(self.final_hash(out), self.final_hash("own"), out)
        # What has labs as processes, and what another program of arkmesh does.
        self.run_it(program, "up", *labs, "--set", "run.duration_s=20", "--set", "run.seed=1", "--out", "joined")
        self.assertEqual(self.final_hash("joined"), self.final_hash("own"))
        self.run_it(program, "batch", *labs, "--seeds", "1,2", "--jobs", "2", "--set", "run.duration_s=20", "--out", "batch")
        self.assertIn(self.final_hash("own"), (self.folder / "batch/runs.csv").read_text())
        self.run_it(program, "export", "own", "--csv")
        self.assertIn("reach_m", self.run_it(program, "config", "--keys").split("scenario.my_swarm")[1])

    def test_the_kit_in_cpp(self):
        """Every header of the kit is there, and a program that uses one links with what is installed."""
        headers = sorted(f"scenarios/kit/{file.name}" for file in (ROOT / "scenarios/kit").glob("*.hpp"))
        self.assertGreater(len(headers), 10)
        project = self.folder / "kit"
        project.mkdir()
        (project / "main.cpp").write_text("".join(f'#include "{header}"\n' for header in headers) +
                                          "int main() { return arkmesh::scenarios::kit::Region::disc({0, 0}, 1).contains({0.5, 0}) ? 0 : 1; }\n")
        (project / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.25)\nproject(kit LANGUAGES C CXX)\nfind_package(arkmesh REQUIRED)\n"
                                                "add_executable(kit main.cpp)\ntarget_link_libraries(kit PRIVATE arkmesh::scenarios)\n")
        self.run_it("sh", "-c", f"cmake -S kit -B kit/build -G Ninja -DCMAKE_PREFIX_PATH='{self.prefix}' && cmake --build kit/build && kit/build/kit")

    def test_names_that_cannot_be_a_namespace(self):
        for name in ("main", "dhtf", "switch", "constexpr", "lab", "settings", "rebuild_cache"):
            self.assertIn("choose another name", self.run_it("arkmesh", "scenario", "new", name, "--cpp", code=2))

    def test_beside_other_targets(self):
        """As a folder of somebody else's project: nothing of the project's own settings changes, and its programs can use ours."""
        project = self.folder / "theirs"
        project.mkdir()
        (project / "main.cpp").write_text("int main() {}\n")
        (project / "CMakeLists.txt").write_text(f"""cmake_minimum_required(VERSION 3.25)
project(theirs LANGUAGES C CXX)
add_subdirectory({ROOT} arkmesh EXCLUDE_FROM_ALL)
add_executable(theirs main.cpp)
target_link_libraries(theirs PRIVATE arkmesh::cli)
add_executable(alone main.cpp)
""")
        self.run_it("cmake", "-S", "theirs", "-B", "theirs/build", "-G", "Ninja", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", around=())
        compiled = json.loads((project / "build/compile_commands.json").read_text())
        alone, theirs = (next(entry["command"] for entry in compiled if f"CMakeFiles/{name}.dir/" in entry["command"])
                         for name in ("alone", "theirs"))
        self.assertNotRegex(alone, r"arkmesh|-W|-std|-O|-ffp")
        self.assertNotIn("-W", theirs)
        self.assertIn("-ffp-contract=off", theirs)
        self.assertRegex(theirs, r"ARKMESH_PROGRAM_FOLDER=\S+theirs/build/arkmesh")
        targets = self.run_it("ninja", "-C", "theirs/build", "-t", "targets", "all", around=())
        self.assertIn("\ntheirs: ", targets)
        self.assertNotIn("test_hal", targets)


if __name__ == "__main__":
    unittest.main()
