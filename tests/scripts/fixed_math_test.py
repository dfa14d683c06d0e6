"""A run gives the same hash whatever versions of its functions the C library chooses for the CPU."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
from lab_processes import PROGRAM, ROOT

LABS = [str(ROOT / f"experiments/dhtf/{lab}.toml") for lab in ("shark", "roark")]
MATHEMATICS = ROOT / "tests/sim_ode/controllers/mathematics.c"
PLAIN = "import math; print([math.sin(0.1 + 1.2345 * i).hex() for i in range(1000)])"


def output(command, without_fma):
    """What a command prints, where the C library may use the CPU's fused multiplication, or is told that there is none."""
    environment = dict(os.environ, GLIBC_TUNABLES="glibc.cpu.hwcaps=-FMA" if without_fma else "")
    return subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True, timeout=600).stdout


def hash_of(arguments, without_fma):
    with tempfile.TemporaryDirectory() as folder:
        said = output([PROGRAM, "run", *arguments, "--out", str(pathlib.Path(folder) / "run")], without_fma)
    return said.split("final hash ")[1].split()[0]


class FixedMathTest(unittest.TestCase):
    def setUp(self):
        plain = [sys.executable, "-c", PLAIN]
        if output(plain, False) == output(plain, True):
            self.skipTest("plain sin() does not differ here without FMA, so equal hashes would prove nothing")

    def test_robots_program(self):
        """A robot's program that calls functions of mathematics and moves as their last bits say."""
        run = [LABS[0], "--set", f'arena.ode.controller="{MATHEMATICS}"', "--set", "run.duration_s=10"]
        self.assertEqual(hash_of(run, False), hash_of(run, True))

    def test_crowded_demo(self):
        """The demo with a crowd that pushes, in which the last bits grow within a minute; left alone they need ten."""
        crowd = ("arena.robots=110", "arena.width_m=0.5", "arena.height_m=0.5", "arena.ode.motion_noise=0.2")
        run = [*LABS, "--set", "run.duration_s=60", "--set", "shared.projection.shark.scale=2", *(word for key in crowd for word in ("--set", "shark:" + key))]
        self.assertEqual(hash_of(run, False), hash_of(run, True))


if __name__ == "__main__":
    unittest.main()
