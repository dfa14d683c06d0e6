"""arkmesh fit: robots of a recorded run come back in the file and walk like the original; fit_check tells wrong robots from right ones."""
import math
import pathlib
import subprocess
import tempfile
import tomllib
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
from lab_processes import PROGRAM, ROOT

LAB = """[lab]
name = "roark"
[run]
scenario = "light_up"
duration_s = {seconds}
seed = {seed}
[arena]
use = "ode"
width_m = 1.2
height_m = 1.2
robots = 20
[arena.ode]
preset = "{preset}"
controller = "{root}/hal/platforms/kilobot/firmware/fit_robots.c"
{more}
"""


class Fit(unittest.TestCase):
    def setUp(self):
        if not PROGRAM.exists():
            self.skipTest("scripts/build has not been run")
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def arkmesh(self, *words, ends_with=0):
        done = subprocess.run([PROGRAM, *words], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, ends_with, done.stdout + done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        return done.stdout + done.stderr

    def run_lab(self, name, seed, preset="measured", more="", seconds=300):
        (self.folder / f"{name}.toml").write_text(LAB.format(seed=seed, preset=preset, more=more, root=ROOT, seconds=seconds))
        self.arkmesh("run", f"{name}.toml", "--out", name)

    def test_there_and_back(self):
        """Robots of a file are found in their run, and robots of the file that is written walk like them, but not like those of a wrong preset."""
        hidden = [{"speed_m_per_s": 0.007 + 0.0003 * i, "drift_deg_per_s": -6 + 0.6 * i, "turn_left_deg_per_s": 30 + i, "turn_right_deg_per_s": 49 - i} for i in range(20)]
        (self.folder / "hidden.toml").write_text("\n".join(f"[[robot]]\nid = {i}\n" + "\n".join(f"{key} = {value}" for key, value in robot.items()) for i, robot in enumerate(hidden)))
        self.run_lab("real", 1, more='robots_file = "hidden.toml"')
        said = self.arkmesh("fit", "robots", "real", "--out", "found.toml")
        self.assertIn("led_bearing_deg of all robots: LED not seen in a recording", said)
        self.assertTrue((self.folder / "found.png").read_bytes().startswith(b"\x89PNG"))
        found = tomllib.loads((self.folder / "found.toml").read_text())["robot"]
        told = {key: [(robot[key], hidden[robot["id"]][key]) for robot in found if key in robot] for key in hidden[0]}
        for key in ("speed_m_per_s", "turn_left_deg_per_s", "turn_right_deg_per_s"):
            self.assertGreaterEqual(len(told[key]), 17, said)
            self.assertLess(max(abs(value / true - 1) for value, true in told[key]), 0.06, (key, told[key]))
        self.assertLess(math.sqrt(sum((value - true) ** 2 for value, true in told["drift_deg_per_s"]) / len(told["drift_deg_per_s"])), 0.6)
        self.run_lab("simulated", 2, more='robots_file = "found.toml"')
        self.assertIn("fit_check: alike", self.arkmesh("fit", "check", "real", "simulated"))
        self.run_lab("wrong", 3, preset="measured_0")
        self.assertIn("fit_check: different: change of turn", self.arkmesh("fit", "check", "real", "wrong", "--png", "wrong.pdf", ends_with=1))
        self.assertTrue((self.folder / "wrong.pdf").read_bytes().startswith(b"%PDF"))

    def test_standing_robots(self):
        """Robots that stand in one run only are different, and two runs in which nobody moves cannot be compared."""
        (self.folder / "stands.c").write_text("#include <kilolib.h>\nvoid setup() {}\nvoid loop() {}\nint main() { kilo_init(); kilo_start(setup, loop); return 0; }\n")
        self.run_lab("real", 1, seconds=80)
        for name, seed in (("still", 2), ("still too", 3)):
            (self.folder / f"{name}.toml").write_text(LAB.format(seed=seed, preset="measured", more="", root=ROOT, seconds=80).replace(f"{ROOT}/hal/platforms/kilobot/firmware/fit_robots.c", "stands.c"))
            self.arkmesh("run", f"{name}.toml", "--out", name)
        self.assertIn("fit_check: different: squared displacement", self.arkmesh("fit", "check", "real", "still", ends_with=1))
        self.assertIn("nothing can be compared", self.arkmesh("fit", "check", "still", "still too", ends_with=1))

    def test_wrong_input(self):
        """One sentence each: a folder without a recording, a table that is none, an empty table, too short a run."""
        (self.folder / "empty").mkdir()
        (self.folder / "bad.csv").write_text("a,b\n1,2\n")
        (self.folder / "none.csv").write_text("# 1 1 led\ntime_s,robot,x_m,y_m,direction_rad,led\nnan,0,inf,0,0,2\n")
        self.run_lab("short", 1, seconds=10)
        for words, sentence in ((["robots", "empty"], "holds no recording of a lab"), (["robots", "bad.csv"], "is not a table of tracks"),
                                (["robots", "none.csv"], "no robot drove straight"), (["robots", "short", "--lab", "shark"], "no recording of the lab shark"),
                                (["check", "short", "short"], "too few to compare")):
            with self.subTest(words):
                self.assertIn(sentence, self.arkmesh("fit", *words, ends_with=1))
        self.assertFalse((self.folder / "robots.toml").exists())


if __name__ == "__main__":
    unittest.main()
