"""Batches through a real Slurm of one node: the same tables as without, in a job array that may be waited for twice."""
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
import slurm_node
from lab_processes import PROGRAM, ROOT

EXPERIMENT = f"""labs = ["{ROOT}/experiments/dhtf/shark.toml"]
seeds = "1..3"
[set]
run.duration_s = 40
arena.robots = 8
[sweep]
gate.period_s = [1, 2]
"""


@unittest.skipIf(slurm_node.missing(), slurm_node.missing())
class Slurm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if "ARKMESH_THOROUGH" not in os.environ:
            raise unittest.SkipTest("scripts/nightly runs it: ARKMESH_THOROUGH is not set")
        cls.slurm = slurm_node.SlurmNode()
        try:
            cls.slurm.__enter__()
        except (RuntimeError, subprocess.SubprocessError) as why:
            raise unittest.SkipTest(f"Slurm does not start on this machine: {why}")
        cls.addClassCleanup(cls.slurm.stop)

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = pathlib.Path(scratch.name)

    def words(self, text, out, *more):
        file = self.scratch / "small.toml"
        file.write_text(text)
        return [PROGRAM, "batch", file, "--out", self.scratch / out, *more]

    def batch(self, text, out, *more):
        return subprocess.run(self.words(text, out, *more), env=self.slurm.environment, capture_output=True, text=True, timeout=600)

    def tables(self, out):
        return [(self.scratch / out / name).read_text() for name in ("runs.csv", "summary.csv", "effects.csv")]

    def test_an_array_gives_the_same_tables(self):
        """Six runs as an array, and in one process: equal tables; what is there already is not submitted again."""
        here = self.batch(EXPERIMENT, "here")
        self.assertEqual(here.returncode, 0, here.stderr)
        there = self.batch(EXPERIMENT, "there", "--slurm")
        self.assertEqual(there.returncode, 0, there.stdout + there.stderr)
        self.assertRegex(there.stderr, r"job \d+ is submitted")
        self.assertIn("6 of 6 runs finished, 0 failed", there.stdout)
        self.assertEqual(self.tables("here"), self.tables("there"))
        again = self.batch(EXPERIMENT, "there", "--slurm")
        self.assertEqual((again.returncode, "job" in again.stderr), (0, False), again.stderr)

    def test_who_stops_waiting_finds_the_array_again(self):
        """Ctrl-C leaves the array running; the same command waits for it and gathers."""
        text = EXPERIMENT.replace("duration_s = 40", "duration_s = 6000")
        with subprocess.Popen(self.words(text, "out", "--slurm"), env=self.slurm.environment, stderr=subprocess.PIPE, text=True) as waiting:
            job = re.search(r"job (\d+) is submitted", waiting.stderr.readline())[1]
            waiting.send_signal(signal.SIGINT)
            self.assertIn(f"scancel {job} ends it", waiting.stderr.read())
        self.assertEqual(waiting.returncode, 3)
        again = self.batch(text, "out", "--slurm")
        self.assertIn(f"job {job} is running", again.stderr)
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertIn("6 of 6 runs finished, 0 failed", again.stdout)

    def test_a_failing_run_is_a_row(self):
        """Robots' programs that crash: rows that say so, exit code 1."""
        text = EXPERIMENT.replace("[sweep]", f'arena.ode.controller = "{ROOT}/tests/programs/crash_after_delay.c"\n[sweep]')
        done = self.batch(text, "out", "--slurm")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn("0 of 6 runs finished, 6 failed", done.stdout)
        self.assertEqual(self.tables("out")[0].count(",failed,"), 6)
        result = self.scratch / "out/runs/00005/result.json"
        before = result.stat().st_mtime_ns
        self.assertNotIn("submitted", self.batch(text, "out", "--slurm").stderr)
        self.assertIn("submitted", self.batch(text, "out", "--slurm", "--retry").stderr)
        self.assertGreater(result.stat().st_mtime_ns, before)

    def test_slurm_refuses_in_its_own_words(self):
        """An option that Slurm does not take is said; nothing was run."""
        done = self.batch(EXPERIMENT, "out", "--slurm", "--slurm-option=--partition=nowhere")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"arkmesh: Slurm refused the job: .*partition")


class WithoutSlurm(unittest.TestCase):
    def test_its_absence_is_said(self):
        """Without sbatch the sentence names the package."""
        with tempfile.TemporaryDirectory() as scratch:
            file = pathlib.Path(scratch) / "small.toml"
            file.write_text(EXPERIMENT)
            done = subprocess.run([PROGRAM, "batch", file, "--out", pathlib.Path(scratch) / "out", "--slurm", "--set", "arena.use=null"], env=os.environ | {"PATH": scratch},
                                  capture_output=True, text=True, timeout=600)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("install slurm-client", done.stderr)


if __name__ == "__main__":
    unittest.main()
