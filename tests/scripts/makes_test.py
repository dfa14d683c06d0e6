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


if __name__ == "__main__":
    unittest.main()
