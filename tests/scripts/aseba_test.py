"""A lab of Thymios with their makers' simulator: found, named, driven, stopped, and stopped by themselves when their lab is gone."""
import csv
import itertools
import json
import math
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "tests/support/aseba")]
import playground  # noqa: E402
from lab_processes import PROGRAM, end_with_parent, run_delay_s  # noqa: E402
from playground import until  # noqa: E402

LAB = """[lab]
name = "thymios"
[bus]
url = "udpm://239.255.76.67:7793?ttl=0&recv_buf_size=4194304"
[run]
scenario = "circles.py"
duration_s = 10000.0
[arena]
use = "aseba"
width_m = 1.1
height_m = 1.1
robots = 2
[arena.aseba]
robot = "{robot}"
connect = "{connect}"
marker_m = {marker_m}
[[arena.aseba.cameras]]
source = "{camera}"
calibration = "{calibration}"
"""
TWO_MAKES = """include = ["{root}/experiments/makes/dhtf_thymios.toml"]
[arena]
use = "aseba"
[arena.aseba]
connect = "tcp:127.0.0.1:34012"
marker_m = {marker_m}
[[arena.aseba.cameras]]
source = "{camera}"
calibration = "{calibration}"
"""
SCENARIO = """import arkmesh


class Circles(arkmesh.Scenario):
    def frame(self, lab):
        lab.tell(lab.seen, kind=lab.ids)
        lab.drive(lab.seen, 0.06, 0.02)
"""


@unittest.skipIf(playground.lacking(), playground.lacking())
class Aseba(unittest.TestCase):
    def setUp(self):
        if not PROGRAM.exists():
            self.skipTest("scripts/build has not been run")
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def arkmesh(self, *command):
        done = subprocess.run([PROGRAM, *command], capture_output=True, text=True, timeout=120)
        return done.returncode, done.stdout + done.stderr

    def start_lab(self, name):
        with open(self.folder / f"{name}.txt", "wb") as said:
            self.lab = subprocess.Popen([PROGRAM, "lab", self.folder / "lab.toml", "--out", self.folder / name], stdin=subprocess.DEVNULL, stdout=said,
                                        stderr=said, preexec_fn=end_with_parent)
        self.addCleanup(self.end_lab)
        self.name = name

    def end_lab(self):
        self.lab.kill()
        self.lab.wait()

    def said(self):
        return (self.folder / f"{self.name}.txt").read_text()

    def log(self):
        """What it said, but for its progress."""
        return [line for line in self.said().splitlines() if not re.search(r"period \d+/", line)]

    def until(self, seconds, condition, what):
        return until(seconds, condition, what, lambda sentence: AssertionError("\n".join([sentence, *self.log()])))

    def all_drive(self, world):
        for robot in (1, 2):
            self.until(30, lambda robot=robot: world.speed(robot) > 0.02, f"robot {robot} drives")

    def stand_within(self, seconds, world, robots, what, at):
        """Since the moment `at`; what the simulator, the lab or this test waited for a processor does not count."""
        delayed = self.delayed(world)
        self.until(20, lambda: all(world.speed(robot, 1) < 0.002 for robot in robots), f"robots stand {what}")
        waited = sum(delay_s - delayed[pid] for pid, delay_s in self.delayed(world).items() if pid in delayed)
        for robot in robots:
            self.assertLess(world.moved_last(robot) - at, seconds + waited, f"robot {robot} stands {what}")

    def delayed(self, world):
        living = [process.pid for process in (*world.processes, self.lab) if process.poll() is None]
        return {pid: run_delay_s(pid) for pid in [*living, os.getpid()]}

    def write_lab(self, world, robot, connect):
        (self.folder / "circles.py").write_text(SCENARIO)
        (self.folder / "lab.toml").write_text(
            LAB.format(robot=robot, connect=connect, marker_m=playground.MARKER_M, camera=world.camera, calibration=world.calibration))
        return self.folder / "lab.toml"

    def load(self, world, program, robots, lab):
        """Until doctor names none without it. What doctor says."""
        for _ in range(5):
            for robot in range(1, robots + 1):
                world.load(ROOT / "experiments/makes" / program, 34012, robot, robots)
            code, said = self.arkmesh("doctor", lab)
            if "run no program" not in said:
                return said
        self.fail(said)

    def test_e_pucks(self):
        """Driven, and standing after STOP and at the end, without a program of ours."""
        with playground.Playground(self.folder, 1.1, [(-0.25, 0.12, 0.0), (0.2, -0.15, 1.57)], make="e-puck") as world:
            lab = self.write_lab(world, "e-puck", "tcp:127.0.0.1:34001,tcp:127.0.0.1:34002")
            self.start_lab("pucks")
            self.all_drive(world)
            self.assertEqual(self.arkmesh("pause", lab)[0], 0)
            self.stand_within(2, world, [1, 2], "after STOP", time.monotonic())
            self.assertEqual(self.arkmesh("resume", lab)[0], 0)
            self.all_drive(world)
            self.lab.send_signal(signal.SIGINT)
            self.assertEqual(self.lab.wait(60), 3, self.said())
            self.until(2, lambda: all(world.speed(robot) < 0.002 for robot in (1, 2)), "robots stand at the end")

    def test_lab(self):
        with playground.Playground(self.folder, 1.1, [(-0.25, 0.12, 0.0), (0.2, -0.15, 1.57)]) as world:
            lab = self.write_lab(world, "thymio", "tcp:127.0.0.1:34012")
            # both behind one switch, as on a radio: of robots without the program it is said that nothing stops them, and each is loaded for itself
            switch = "asebaswitch", "-p", "34012", "tcp:127.0.0.1;34001", "tcp:127.0.0.1;34002"
            first = world.start("switch", *switch)
            code, said = self.arkmesh("doctor", lab)
            self.assertIn("robots 1, 2 run no program that stops their wheels when the lab is gone", said)
            said = self.load(world, "robot.aesl", 2, lab)
            self.assertIn("robot 2: node 2 of tcp:127.0.0.1:34012, thymio-II with 30 variables", said)
            # driven
            self.start_lab("first")
            self.all_drive(world)
            # their nodes are gone: they stand by themselves, that is counted and said; they are back, and drive
            at = time.monotonic()
            first.kill()
            self.stand_within(2, world, [1, 2], "without their lab", at)
            self.until(10, lambda: "robot 2, node 2 of tcp:127.0.0.1:34012, is gone with its connection" in self.said(), "the loss is said")
            world.start("switch_again", *switch)
            self.all_drive(world)
            # STOP
            self.assertEqual(self.arkmesh("pause", lab)[0], 0)
            self.stand_within(2, world, [1, 2], "after STOP", time.monotonic())
            stood = dict(world.newest)
            self.assertEqual(self.arkmesh("resume", lab)[0], 0)
            self.all_drive(world)
            self.lab.send_signal(signal.SIGINT)
            self.assertEqual(self.lab.wait(60), 3, self.said())
            self.until(2, lambda: all(world.speed(robot) < 0.002 for robot in (1, 2)), "robots stand at the end")
            # killed
            self.start_lab("second")
            self.all_drive(world)
            at = time.monotonic()
            self.lab.kill()
            self.stand_within(2, world, [1, 2], "after their lab was killed", at)
            self.judge(world, stood)

    @unittest.skipUnless("ARKMESH_THOROUGH" in os.environ, "scripts/nightly runs it: ARKMESH_THOROUGH is not set")
    def test_two_makes(self):
        """Six Thymios behind one switch and twelve simulated Kilobots play team formation for ten minutes: both labs know the same tasks."""
        places = [(x, y, x + 2 * y) for x in (-1, 0, 1) for y in (-1, 1)]
        with playground.Playground(self.folder, 3.0, places, px=1600) as world:
            world.start("switch", "asebaswitch", "-p", "34012", *(f"tcp:127.0.0.1;{34001 + i}" for i in range(6)))
            labs = [ROOT / "experiments/makes/dhtf_kilobots.toml", self.folder / "thymios.toml"]
            labs[1].write_text(TWO_MAKES.format(root=ROOT, marker_m=playground.MARKER_M, camera=world.camera, calibration=world.calibration))
            self.load(world, "dhtf.aesl", 6, labs[1])
            done = subprocess.run([PROGRAM, "up", *labs, "--out", self.folder / "run"], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=1200)
            self.assertEqual(done.returncode, 0, done.stderr[-3000:])
        results = [json.loads((self.folder / f"run/{lab}/result.json").read_text()) for lab in ("kilobots", "thymios")]
        for key in ("final_hash", "counts"):
            self.assertEqual(results[0][key], results[1][key])
        counters = results[1]["counters"]
        self.assertEqual([counters.get(f"arena.{name}", 0) for name in ("nodes.found", "nodes.lost", "nodes.twice", "robots.unguarded")], [6, 0, 0, 0])
        self.assertEqual(self.arkmesh("export", self.folder / "run/thymios", "--csv", "--out", self.folder / "csv")[0], 0)
        with open(self.folder / "csv/thymios/poses.robots.csv", newline="") as table:
            rows = list(csv.DictReader(table))[::50]
        self.assertGreater(len(rows), 100)
        for row in rows:
            pose, path = (float(row["x_m"]), float(row["y_m"])), [poses[int(row["robot"])] for _, poses in world.history]
            self.assertLess(min(to_segment(pose, *ends) for ends in itertools.pairwise(path) if math.dist(ends[0][:2], pose) < 0.1), 0.005)

    def judge(self, world, stood):
        """What the first lab counted and saw."""
        counters = json.loads((self.folder / "first/result.json").read_text())["counters"]
        self.assertEqual({name: counters.get(f"arena.{name}", 0) for name in ("nodes.found", "nodes.lost", "robots.unguarded")},
                         {"nodes.found": 4, "nodes.lost": 2, "robots.unguarded": 0})
        self.assertEqual(self.arkmesh("export", self.folder / "first", "--csv", "--out", self.folder / "csv")[0], 0)
        with open(self.folder / "csv/thymios/poses.robots.csv", newline="") as table:
            rows = list(csv.DictReader(table))
        for robot, led in ((1, "1"), (2, "2")):
            seen = [row for row in rows if int(row["robot"]) == robot]
            self.assertIn(led, {row["led"] for row in seen})  # the colour that its program says
            path = [poses[robot] for _, poses in world.history]
            ours = [tuple(float(row[name]) for name in ("x_m", "y_m", "heading_rad")) for row in seen]
            self.assertGreater(len(ours), 20)  # as many as the lab had time for
            for pose in ours:
                self.assertLess(min(to_segment(pose, *ends) for ends in itertools.pairwise(path)), 0.005)
            stands = [pose for pose in ours if math.dist(pose[:2], stood[robot][:2]) < 0.005]
            self.assertGreater(len(stands), 4)  # in the second that was waited for
            for pose in stands:
                self.assertLess(abs(math.remainder(pose[2] - stood[robot][2], math.tau)), 0.1)  # 5 mm of the circle are 0.05


def to_segment(point, begin, end):
    """How far a point is from the way between two others."""
    way, off = [e - b for b, e in zip(begin[:2], end[:2])], [p - b for b, p in zip(begin[:2], point[:2])]
    length2 = sum(part * part for part in way)
    share = min(1, max(0, sum(a * b for a, b in zip(way, off)) / length2)) if length2 else 0
    return math.hypot(off[0] - share * way[0], off[1] - share * way[1])


if __name__ == "__main__":
    unittest.main()
