"""One world of two makes of robot: experiments/makes in one process and in four, and what its README promises."""
import csv
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

from matplotlib.figure import Figure

import run_folder  # noqa: F401  (makes the scripts importable)
import run_figure

ROOT = pathlib.Path(__file__).resolve().parents[2]
ARKMESH = ROOT / "build/release/arkmesh"
ENVIRONMENT = {**os.environ, "ARKMESH_PYTHON": "/usr/bin/python3"}


class Makes(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def played(self, command, prefix, seconds, *more):
        labs = [ROOT / f"experiments/makes/{prefix}{lab}.toml" for lab in ("kilobots", "thymios")]
        out = self.folder / f"{prefix}{command}"
        done = subprocess.run([ARKMESH, command, *labs, "--set", f"run.duration_s={seconds}", "--out", out, *more], capture_output=True, text=True,
                              timeout=1200, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return json.loads((out / ("kilobots/result.json" if command == "up" else "result.json")).read_text()), out

    def test_team_formation_has_one_hash_in_one_process_and_in_four(self):
        one, _ = self.played("run", "dhtf_", 300)
        four, _ = self.played("up", "dhtf_", 300)
        self.assertEqual(one["final_hash"], four["final_hash"])
        self.assertGreater(one["counts"]["completed"], 0)
        self.assertEqual(one["counts"]["completed"], four["counts"]["completed"])

    def test_what_a_run_keeps_repeats_it(self):
        one, out = self.played("run", "dhtf_", 20)
        done = subprocess.run([ARKMESH, "run", *(out / lab / "config.toml" for lab in ("kilobots", "thymios")), "--out", self.folder / "again"],
                              capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(json.loads((self.folder / "again/result.json").read_text())["final_hash"], one["final_hash"])

    def test_light_up(self):
        one, out = self.played("run", "light_up_", 60)
        self.assertGreater(one["counts"]["lit_periods"], 0)
        # a picture draws each robot as large as it is, also those of the other make: 3 m are 1 m of the shared world
        for lab, own, other in zip(run_figure.labs_of(out), (0.056, 0.0165), (0.0165 * 3, 0.056 / 3)):
            axes = Figure().add_subplot()
            run_figure.draw_robots(axes, lab)
            self.assertEqual({round(circle.radius, 4) for circle in axes.patches}, {round(radius, 4) for radius in (own, other)}, lab.name)

    def test_thymios_that_are_driven_come_to_the_kilobots(self):
        _, out = self.played("run", "meet_", 60)
        with open(out / "thymios/met.csv", newline="") as table:
            near = [int(row["near"]) for row in csv.DictReader(table)]
        self.assertLess(near[0], 6)
        self.assertEqual(near[-1], 6)

    def test_thymios_that_hear_their_proximity_sensors_stay_off_walls_and_each_other(self):
        (self.folder / "avoid.py").write_text(AVOID)
        (self.folder / "lab.toml").write_text('[lab]\nname = "thymios"\n[run]\nscenario = "avoid.py"\nduration_s = 60\n'
                                              '[arena]\nwidth_m = 2.0\nheight_m = 2.0\nrobots = 4\n[arena.ode]\nrobot = "thymio"\n'
                                              'start_poses = [-0.5, -0.5, 0.5, 0.5, -0.5, 2.0, 0.5, 0.5, 3.6, -0.5, 0.5, -1.1]\n')
        done = subprocess.run([ARKMESH, "run", self.folder / "lab.toml", "--out", self.folder / "out"], capture_output=True, text=True, timeout=300, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        counters = json.loads((self.folder / "out/thymios/result.json").read_text())["counters"]
        self.assertEqual(counters["arena.contacts.solved"], 0)
        with open(self.folder / "out/thymios/turned.csv", newline="") as table:
            self.assertGreater(sum(int(row["robots"]) for row in csv.DictReader(table)), 2)


AVOID = '''
import arkmesh
import numpy


class Avoid(arkmesh.Scenario):
    def begin(self, lab):
        self.front = [lab.says.index(f"prox.horizontal.{sensor}") for sensor in range(5)]
        self.seen = numpy.zeros((len(lab.ids), len(lab.says)))

    def frame(self, lab):
        for robot, kind, value in lab.heard:
            self.seen[numpy.searchsorted(lab.ids, robot), kind] = value
        self.turns = self.seen[:, self.front].max(axis=1) > 1300
        lab.drive(lab.seen, numpy.where(self.turns, -0.05, 0.08), numpy.where(self.turns, 0.05, 0.08))

    def period(self, lab):
        lab.row("turned", time_s=round(lab.now_s, 1), robots=int(self.turns.sum()))
'''

if __name__ == "__main__":
    unittest.main()
