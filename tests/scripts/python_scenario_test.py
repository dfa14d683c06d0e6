"""Scenarios in Python that fail: the run ends as failed, with one sentence about the user's file, and leaves its result."""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import sys
import unittest

import numpy
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scenarios/python"))
import arkmesh  # noqa: E402  # pylint: disable=wrong-import-position
ARKMESH = ROOT / "build/release/arkmesh"
ENVIRONMENT = {**os.environ, "ARKMESH_PYTHON": "/usr/bin/python3"}
LAB = """[lab]
name = "a"
[run]
scenario = "mine.py"
duration_s = 4
[scenario]
answer_s = 600
[arena]
use = "null"
robots = 5
"""
FRAME = "import arkmesh, os, signal, sys, time, numpy\nclass Mine(arkmesh.Scenario):\n  def frame(self, lab):\n    "


class Places(unittest.TestCase):
    def test_within_is_what_all_pairs_say(self):
        """With few places and many, on borders of cells, far away, apart, and with places that are none."""
        chance = numpy.random.default_rng(1)
        for k in range(600):
            n, m = chance.integers(0, 400, 2)
            size = 10.0 ** chance.integers(-3, 4)
            xy, others = (chance.random((count, 2)) * size - size / 2 for count in (n, m))
            reach = size * 10.0 ** chance.uniform(-3, 0.3)
            if k % 3 == 0:
                xy, others = numpy.round(xy / reach) * reach, numpy.round(others / reach) * reach
            if k % 5 == 0 and n:
                xy[chance.integers(0, n)] = numpy.nan
            if k % 7 == 0 and m:
                others[chance.integers(0, m)] = [numpy.inf, 1]
            if k % 11 == 0:
                others = others * 3 + size
            with numpy.errstate(invalid="ignore"):
                dx, dy = (others[:, axis] - xy[:, axis, None] for axis in (0, 1))
                wanted = (dx * dx + dy * dy <= reach * reach).any(axis=1)
                self.assertTrue((arkmesh.within(xy, others, reach) == wanted).all(), (k, n, m, size, reach))


KIT = """import math, numpy, arkmesh
class Mine(arkmesh.Scenario):
    def begin(self, lab):
        self.trail = lab.trail("trail", 2, 2, cell=0.02, half_life=30, zones=(4, 3.14, 0.05, 0.2), full=3)
        self.right, self.around = lab.eyes(1, reach=0.1), lab.eyes(4, reach=0.1, around=True, robots=0.02)
        self.crowd, self.own = lab.crowd(0.12), lab.crowd(0.12, leds=[0], others=False)
        self.disc = lab.region(centre=(0.1, 0), radius=0.2, resource={"rate": 0.001, "growth": 0.01})
        self.box = lab.region(corners=[(-0.2, -0.2), (0.1, -0.2), (0.1, 0.1), (-0.2, 0.1)])
        tiles = numpy.arange(12).reshape(3, 4)
        self.tiles, self.drawn = lab.floor("f", 0.8, 0.6, 4, 3, tiles=tiles), lab.floor("g", 1, 1, 20, 20, shares=(1, 3), patch=1)
        self.home, self.talk = lab.towards((0.3, 0.1)), lab.voices("talk", 3, reach=0.15)
        self.ring = lab.voices("ring", 2, graph=[(("a", i), ("b", i)) for i in range(20)])
        self.image = lab.floor("h", 0.8, 0.6, 4, 3, image="floor.png", levels=4)
        self.lamp, self.dim = lab.light(100, slope=(50, 0), beams=[{"path": [(0.1, 0), (0.2, 0)], "speed": 0.01}]), lab.light(500, noise=20)
        self.gps, self.vague = lab.gps(20, 10, headings=30), lab.gps(1000, 1000, 360, width=2, height=2, noise=(0.01, 0.1), every_s=1)
        self.half, self.whole = lab.eyes(8, reach=0.08, half_planes=True), lab.eyes(8, reach=0.08)
        self.dark = lab.region(centre=(0.1, 0), radius=0.2, leds=[0], resource={"rate": 0.001, "shared": True})
        self.lit = lab.region(centre=(0.1, 0), radius=0.2, leds=[1, 2], resource={"rate": 0.001})
        self.common, self.own_chance = lab.random("x", common=True), lab.random("x")
        assert lab.random("x", common=True) is self.common and (self.common.random() != self.own_chance.random())
        self.rare, self.rough = lab.towards((0.3, 0.1), every_s=1), lab.towards((0.3, 0.1), noise=(0.1, 0.02))
        lab.needs_airtime(50)
        assert lab.setting("reach_m", 0.1, own=True) == (0.2 if lab.name == "b" else 0.1)
    def period(self, lab):
        self.merged = True
        lab.row("chance", common=self.common.random(), own=self.own_chance.random())
        assert self.dark.robots + self.lit.robots <= self.disc.robots and numpy.isclose(self.lit.share, 0.0005 * (lab.periods > 0 and self.lit.robots > 0))
        if lab.periods > 0 and self.dark.robots > 0:
            assert numpy.isclose(self.dark.share * self.dark.robots, 0.0005)
    def frame(self, lab):
        def near(others, reach):
            return (numpy.hypot(*(lab.xy[:, None] - others[None]).T).T <= reach)
        own = near(lab.xy, 0.12).sum(axis=1) - 1
        assert (self.crowd.count == own + near(lab.others.xy, 0.12).sum(axis=1)).all()
        assert (self.own.count == near(lab.xy[lab.led == 0], 0.12).sum(axis=1) - (lab.led == 0)).all()
        wall = numpy.minimum(lab.width_m / 2 - abs(lab.xy[:, 0]), lab.height_m / 2 - abs(lab.xy[:, 1]))
        apart = numpy.hypot(*(lab.xy[:, None] - lab.others.xy[None]).T).T.min(axis=1, initial=numpy.inf) - 0.02
        nearest = numpy.minimum(wall, numpy.maximum(apart, 0))
        seen = self.around.distance.min(axis=1)
        assert numpy.allclose(seen[nearest < 0.0999], nearest[nearest < 0.0999]) and (seen[nearest > 0.1001] > 1).all()
        assert ((self.right.bits == 1) == numpy.isfinite(self.right.distance[:, 0])).all()
        x, y = lab.shared_xy.T
        assert (self.disc.inside == (numpy.hypot(x - 0.1, y) <= 0.2)).all()
        assert (self.box.inside == ((x >= -0.2) & (x < 0.1) & (y >= -0.2) & (y < 0.1))).all()
        row, column = numpy.floor((y + 0.3) / 0.2).clip(0, 2), numpy.floor((x + 0.4) / 0.2).clip(0, 3)
        assert (self.tiles.level == row * 4 + column).all() and set(self.drawn.level) <= {0, 1}
        assert (self.image.level == (row * 4 + column).astype(int) % 4).all()
        turned = lab.heading + (0.5 if lab.name == "b" else 0)
        assert (self.gps.column == numpy.floor((x + 0.3) / 0.03).clip(0, 19)).all() and (self.gps.row == numpy.floor((y + 0.3) / 0.06).clip(0, 9)).all()
        off = (turned - self.gps.heading * math.radians(12) + math.pi) % (2 * math.pi) - math.pi
        assert (abs(off) <= math.radians(6) + 1e-9).all() and set(self.gps.heading) <= set(range(30))
        assert abs((self.vague.column - 500) * 0.002 - x).max() < 0.08 and (self.vague.column != numpy.floor((x + 1) / 0.002)).any()
        assert (wall[self.half.bits > 0] < 0.08).all() and (self.half.bits >= self.whole.bits).any()
        lab.count("half", int((self.half.bits > 0).sum()))
        beam = 0.1 + abs((lab.now_s * 0.01 + 0.1) % 0.2 - 0.1)
        lit = numpy.hypot(x - beam, y)
        assert ((self.lamp.level == numpy.where(lit <= 0.1, 1023, numpy.rint(100 + 50 * x)))[abs(lit - 0.1) > 1e-6]).all()
        assert abs(self.dim.level.mean() - 500) < 25 and self.dim.level.std() > 5
        if round(lab.now_s * 10) % 10 == 0 or not hasattr(self, "at_second"):
            self.at_second = self.home.distance
        assert (self.rare.distance == self.at_second).all() and abs(self.rough.distance - self.home.distance).max() < 0.15
        if lab.periods > 3:
            assert (self.ring.heard[:, 1] == (lab.ids % 2)).all() and (self.ring.heard[:, 0] == 1 - lab.ids % 2).all()
        self.ring.say(lab.seen, (lab.ids % 2).astype(int))
        turned = lab.heading + (0.5 if lab.name == "b" else 0)
        off = numpy.arctan2(0.1 - y, 0.3 - x) - turned - self.home.bearing
        assert numpy.allclose(numpy.cos(off), 1) and numpy.allclose(self.home.distance, numpy.hypot(0.3 - x, 0.1 - y))
        if lab.periods > 3:
            everyone = numpy.concatenate([lab.shared_xy, lab.others.shared_xy])
            says = numpy.concatenate([lab.ids, lab.others.ids]) % 3
            within = numpy.hypot(*(lab.shared_xy[:, None] - everyone[None]).T).T <= 0.15
            within[numpy.arange(len(lab.ids)), numpy.arange(len(lab.ids))] = False
            assert (self.talk.heard == numpy.stack([(within & (says == v)).sum(axis=1) for v in range(3)], axis=1)).all()
            assert 0 < self.disc.stock < 1 and self.disc.robots >= 0
        self.talk.say(lab.seen, (lab.ids % 3).astype(int))
        self.trail.lay(lab.ids % 2 == 0, 0.5)
        assert (self.trail.value >= 0).all() and self.trail.gradient.shape == (len(lab.ids), 2) and (self.trail.zones < 16).all()
        lab.count("smelt", int((self.trail.value > 0.1).sum()))
"""


class PythonScenario(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        (self.folder / "a.toml").write_text(LAB)

    def command(self, *more):
        return [ARKMESH, "run", self.folder / "a.toml", "--out", self.folder / "out", *more]

    def run_it(self, text, *more):
        if text is not None:
            (self.folder / "mine.py").write_text(text)
        done = subprocess.run(self.command(*more), capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
        return done.returncode, done.stdout + done.stderr

    def fails(self, text, *wanted):
        """Ends as failed; the reason in result.json holds what is wanted."""
        code, said = self.run_it(text)
        self.assertNotEqual(code, 0, said)
        result = json.loads((self.folder / "out/a/result.json").read_text())
        self.assertEqual(result["state"], "failed")
        for each in wanted:
            self.assertIn(each, json.dumps(result), said)
        return said

    def test_what_is_no_scenario(self):
        """Missing, unreadable, with an import that is not there, empty, with two scenarios: the file and the line are named."""
        for text, wanted in ((None, "there is no file"), ("import arkmesh\n\nclass :\n", "mine.py:3: SyntaxError"),
                             ("import arkmesh\nimport nowhere_at_all\n", "mine.py:2: ModuleNotFoundError"),
                             ("x = 1\n", "mine.py:1: it holds no scenario"),
                             ("import arkmesh\nclass A(arkmesh.Scenario): pass\nclass B(arkmesh.Scenario): pass\n",
                              "mine.py:3: it holds 2 scenarios, A and B")):
            with self.subTest(wanted):
                self.fails(text, wanted)
                subprocess.run(["rm", "-r", self.folder / "out"], check=True)

    def test_what_goes_wrong_in_a_frame(self):
        """Raised, left, killed, hung, stopped, wrong answers: each has its sentence, within the patience."""
        for line, wanted in (("1 / 0", "mine.py:4: ZeroDivisionError"), ("sys.exit(3)", "mine.py:4: SystemExit"),
                             ("os._exit(3)", "mine.py ended by itself, with exit code 3"),
                             ("os.kill(os.getpid(), signal.SIGKILL)", "mine.py was killed by signal 9"),
                             ("os.kill(os.getpid(), signal.SIGSTOP)", "mine.py: no answer for 5 s"),
                             ("time.sleep(100)", "mine.py:4: no answer for 5 s"),
                             ("lab.tell(lab.seen[:2])", "mine.py:4: ValueError: who must be a mask of 5 rows"),
                             ("lab.tell([77])", "mine.py:4: ValueError: this lab has no robot 77"),
                             ("lab.tell([0], value=numpy.nan)", "mine.py:4: ValueError: value must be whole numbers"),
                             ("lab.tell([0], value=[1, 2])", "mine.py:4: ValueError: value must be one number, or 1 of them,"),
                             ("lab.message(b'123', 5)", "mine.py:4: ValueError: data must be nine bytes, not 3"),
                             ("lab.message([1, 2, 1 << 24], 5)", "mine.py:4: ValueError: data must be nine bytes, or three whole numbers"),
                             ("lab.parameters(bytes(9), 128)", "mine.py:4: ValueError: message_type must be 0 to 127"),
                             ("lab.drive([0], 0.1, 0.1)", "mine.py:4: ValueError: drive: a kilobot has no wheels"),
                             ("lab.whole_to_one = False; lab.message(bytes(9), 5, who=[0])", "mine.py:4: ValueError: who: an overhead controller cannot send a whole message"),
                             ("lab.row('t', x='7' * (1 << 27))", "sent 134217")):
            with self.subTest(line):
                # only who hangs is given up soon: a busy machine takes some seconds to answer
                (self.folder / "a.toml").write_text(LAB.replace("answer_s = 600", f"answer_s = {5 if 'no answer' in wanted else 600}"))
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                self.fails(FRAME + line + "\n", wanted)

    def test_a_python_that_cannot_begin_says_why(self):
        """Its own words are shown with the scenario's name; a variable that hides what lies beside our own files has no effect."""
        (self.folder / "mine.py").write_text(FRAME + "pass\n")
        for name, value, code in (("PYTHONSAFEPATH", "1", 0), ("PYTHONHOME", "/nowhere", 1)):
            with self.subTest(name):
                done = subprocess.run(self.command(), capture_output=True, text=True, timeout=60, env={**ENVIRONMENT, name: value})
                self.assertEqual(done.returncode, code, done.stderr)
                if code:
                    self.assertRegex(done.stdout + done.stderr, r"mine\.py: .*(encodings|Fatal Python error)")
                subprocess.run(["rm", "-r", self.folder / "out"], check=True)

    def test_what_it_prints_is_kept_and_bounded(self):
        """A child that prints without end does not stall the lab or fill the disk, and its traceback is in the log."""
        self.fails(FRAME + "print('y' * 100_000_000); 1 / 0\n", "mine.py:4: ZeroDivisionError")
        self.assertLess((self.folder / "out/a/scenario.log").stat().st_size, 1 << 20)
        subprocess.run(["rm", "-r", self.folder / "out"], check=True)
        self.fails(FRAME + "print('hello'); 1 / 0\n")
        log = (self.folder / "out/a/scenario.log").read_text()
        self.assertIn("hello", log)
        self.assertIn("Traceback", log)

    def test_settings(self):
        """A setting in the lab's file counts; one out of range or unknown is refused by name."""
        mine = ("import arkmesh\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n"
                "    lab.count('reach', lab.setting('reach', 3, low=1, high=9))\n")
        for value, wanted in (("reach=4", None), ("reach=10", "must be 1 to 9"), ("raech=4", "raech")):
            with self.subTest(value):
                code, said = self.run_it(mine, "--set", f"scenario.mine.{value}", "--force")
                if wanted is None:
                    self.assertEqual(code, 0, said)
                    self.assertEqual(json.loads((self.folder / "out/a/result.json").read_text())["counts"]["reach"], 4)
                else:
                    self.assertNotEqual(code, 0)
                    self.assertIn("scenario.mine." + value.partition("=")[0], said)

    def test_messages_of_other_layouts(self):
        """Start parameters reach all robots before they run, over a lossy way; whole messages reach all, or one; words are of the layout."""
        programs = ROOT / "tests/programs"
        mine = ("import arkmesh, numpy\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n    lab.parameters([0x8000, 1, 2], message_type=10)\n"
                "  def frame(self, lab):\n    lab.tell(lab.seen, kind=1, value=0x7FFF + 2 * (lab.ids % 2), shown=lab.ids < 0)\n"
                "    colour = 1 if lab.now_s < 2 else 4\n"
                "    lab.message(bytes([0, 0, colour << 1, 1, 2, 3, 4, 5, 6]), message_type=20)\n"
                "    if lab.now_s >= 3: lab.message([0, 4 << 8 | 1, 0x020304], 20, who=[3])\n"
                "    lab.row('leds', t=lab.now_s, shown=' '.join(map(str, lab.led)))\n")
        for program, layout, at, middle, last in (("layout_7_1_16", "7+1+16", 29, "1 2 1 2 1 2", "1 2 1 2 1 2"), ("layout_whole", "7+1+16", 19, "1 1 1 1 1 1", "4 4 4 7 4 4")):
            (self.folder / "a.toml").write_text(
                '[lab]\nname = "a"\n[run]\nscenario = "mine.py"\nduration_s = 4\n[arena]\nuse = "ode"\nrobots = 6\n[arena.ode]\noverhead_loss = 0.3\n'
                f'controller = "{programs / program}.c"\n[arena.kilobot]\nlayout = "{layout}"\n')
            code, said = self.run_it(mine, "--force")
            self.assertEqual(code, 0, said)
            rows = [line.partition(",")[2] for line in (self.folder / "out/a/leds.csv").read_text().splitlines()[1:]]
            self.assertEqual((rows[at], rows[-1]), (middle, last), program)
            self.assertNotIn("refused", json.dumps({k: v for k, v in json.loads((self.folder / "out/a/result.json").read_text())["drops"].items() if v}))

    def test_the_first_frame_comes_before_the_first_period(self):
        """Poses are there in period 0, without states of other labs; what it says goes out with that period, and is heard."""
        mine = ("import arkmesh, numpy\nclass Mine(arkmesh.Scenario):\n  def frame(self, lab):\n"
                "    if lab.now_s == 0: lab.say(lab.seen, kind=2); lab.message(bytes(9), 5); print('frame', len(lab.others.ids), lab.field('a', 'x').tolist())\n"
                "    lab.count('frames')\n  def begin(self, lab):\n    lab.declare('x'); lab.publish('x', 7); self.disc = lab.region(centre=(0, 0), radius=9)\n"
                "  def period(self, lab):\n    if lab.periods == 0: print('period', numpy.isfinite(lab.xy).all(), self.disc.inside.all(), self.disc.robots)\n")
        code, said = self.run_it(mine, "--set", "arena.use=ode", "--set", f"arena.ode.controller={ROOT}/tests/programs/labs_random_walk.c")
        self.assertEqual(code, 0, said)
        self.assertEqual((self.folder / "out/a/scenario.log").read_text().splitlines(), ["frame 0 []", "period True True 5"])
        result = json.loads((self.folder / "out/a/result.json").read_text())
        self.assertEqual(result["counts"]["frames"], 41)
        self.assertIn('"to_robots.sent": 6', json.dumps(result))

    def test_robots_that_speak_to_their_lab(self):
        """What a simulated robot says is there in the next frame, once, with its id; behind an overhead controller it ends the run by name."""
        (self.folder / "says.c").write_text("""#include <kilolib.h>
#include <arkmesh_say.h>
static void setup(void) {}
static void loop(void) {
  static uint32_t last = 0;
  if (kilo_ticks < last + 31) return;
  last = kilo_ticks;
  arkmesh_say(7, kilo_uid == 3 ? -300000 : kilo_uid);
}
int main(void) { kilo_init(); kilo_start(setup, loop); return 0; }
""")
        mine = ("import arkmesh\nclass Mine(arkmesh.Scenario):\n  def frame(self, lab):\n"
                "    for word in lab.heard: lab.row('heard', t=lab.now_s, robot=word['robot'], kind=word['kind'], value=word['value'])\n")
        says = ("--set", f"arena.ode.controller={self.folder}/says.c")
        code, said = self.run_it(mine, "--set", "arena.use=ode", *says)
        self.assertEqual(code, 0, said)
        rows = [line.split(",") for line in (self.folder / "out/a/heard.csv").read_text().splitlines()[1:]]
        self.assertEqual({(row[1], row[2], row[3]) for row in rows}, {(str(i), "7", "-300000" if i == 3 else str(i)) for i in range(5)})
        self.assertTrue(15 <= len(rows) <= 20, rows)

    def test_the_page_for_newcomers_has_an_example_that_runs(self):
        """Its three files, as they stand: robots are blue inside the site and red outside, and few beyond the control's chance are inside at the start."""
        text = (ROOT / "docs/coming-from-ark-and-argos.md").read_text()
        for name, language in (("site.c", "c"), ("site.py", "python"), ("table.toml", "toml")):
            block = re.search(rf"^```{language}\n((?:#|//) {name}:.*?)^```", text, re.S | re.M)
            (self.folder / name).write_text(block[1])
        done = subprocess.run([ARKMESH, "run", self.folder / "table.toml", "--seed", "1", "--out", self.folder / "site"], capture_output=True, text=True, timeout=120,
                              env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        run = arkmesh.open_run(self.folder / "site")
        inside = numpy.hypot(run.xy[:, :, 0] - 0.2, run.xy[:, :, 1]) <= 0.15
        self.assertEqual(inside[0].sum(), 0)
        self.assertTrue((numpy.hypot(run.xy[0, :, 0] + 0.2, run.xy[0, :, 1]) <= 0.2).all())
        late = inside[100:]
        self.assertGreater(late.sum(), 20)
        self.assertGreater((run.led[100:][late] == 4).mean(), 0.7)
        self.assertGreater((run.led[100:][~late] == 1).mean(), 0.9)

    def test_what_is_said_now_and_then(self):
        """With `every_s` each robot of a slot is told the newest once in so many seconds, and others are not kept from theirs."""
        mine = ("import arkmesh, numpy\nclass Mine(arkmesh.Scenario):\n  def frame(self, lab):\n"
                "    tick = round(lab.now_s * 10)\n"
                "    lab.say(lab.ids < 2, 1, tick, every_s=1)\n    lab.say([2, 4], 1, [tick, 900], every_s=0.5)\n    lab.say([0], 2, tick, slot=1, every_s=2)\n"
                "    if tick >= 25: lab.say([3], 3, tick, every_s=1)\n"
                "    words = numpy.concatenate(lab._words)\n    lab.row('said', what=' '.join(f'{w[\"robot\"]}:{w[\"value\"]}' for w in words))\n")
        code, said = self.run_it(mine)
        self.assertEqual(code, 0, said)
        rows = (self.folder / "out/a/said.csv").read_text().splitlines()[1:]
        told = {robot: [int(word.partition(":")[2]) for row in rows for word in row.split() if word.startswith(f"{robot}:")] for robot in range(5)}
        first = told[1][0]
        self.assertEqual(told[1], list(range(first, 41, 10)))
        self.assertEqual(told[2], list(range(first, 41, 5)))
        self.assertEqual(told[4], [900] * len(told[2]))
        self.assertEqual(told[3], [25, 35])
        self.assertEqual(told[0], sorted(told[1] + list(range(first, 41, 20))))

    def test_what_stands_and_lies_in_the_arena(self):
        """Obstacles with their corners in the arena, objects where they start and where robots have pushed them, a grid that is drawn."""
        mine = ("import arkmesh, numpy\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n"
                "    wall, (box, disc) = lab.obstacles[0].corners, lab.objects\n"
                "    lab.row('begin', low=f'{wall.min(axis=0)}', high=f'{wall.max(axis=0)}', box=box.name, disc=disc.radius, at=f'{lab.object_xy[0]}')\n"
                "  def frame(self, lab):\n    lab.row('object', heading=lab.object_heading[0], heard=len(lab.heard))\n"
                "  def period(self, lab):\n    lab.raster((-0.4, -0.3), 0.1, numpy.linspace(0, 1, 6).reshape(2, 3), label='grid')\n")
        (self.folder / "a.toml").write_text(
            '[lab]\nname = "a"\n[run]\nscenario = "mine.py"\nduration_s = 20\n[arena]\nuse = "ode"\nrobots = 20\nwidth_m = 0.6\nheight_m = 0.6\n'
            'obstacles = [{shape = "polygon", x_m = -0.1, y_m = 0.2, heading_deg = 90, corners = [0, 0, 0.05, 0, 0.05, 0.02]}]\n'
            'objects = [{name = "box", shape = "box", length_m = 0.1, width_m = 0.04, x_m = 0.16, mass_kg = 0.02}, {name = "d", shape = "disc", radius_m = 0.03, y_m = 0.16, mass_kg = 0.02}]\n'
            f'[arena.ode]\ncontroller = "{ROOT}/tests/programs/disperse_simple.c"\n')
        code, said = self.run_it(mine)
        self.assertEqual(code, 0, said)
        begin = (self.folder / "out/a/begin.csv").read_text().splitlines()[1]
        self.assertEqual(begin, "[-0.12  0.2 ],[-0.1   0.25],box,0.03,[0.16 0.  ]")
        rows = (self.folder / "out/a/object.csv").read_text().splitlines()[1:]
        self.assertEqual(rows[0], "0.0,0")
        self.assertNotEqual(rows[-1], rows[0])
        exported = subprocess.run([ARKMESH, "export", self.folder / "out", "--csv"], capture_output=True, text=True, timeout=600)
        self.assertEqual(exported.returncode, 0, exported.stderr)
        raster = (self.folder / "out/export/csv/a/overlay.rasters.csv").read_text().splitlines()
        self.assertIn("grid", raster[1])
        self.assertIn("003366", raster[1])

    def test_settings_are_listed(self):
        """As keys of a lab's file, with unit, default and range; a file that fails says where."""
        listed = subprocess.run([ARKMESH, "config", "--keys", ROOT / "experiments/light_up/light_up.py"], capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
        self.assertEqual(listed.returncode, 0, listed.stderr)
        self.assertEqual(listed.stdout.count("reach_m"), 1)
        for word in ("scenario.light_up", "0.1", "0.001", "100", "how near, in the shared world"):
            self.assertIn(word, listed.stdout)
        (self.folder / "mine.py").write_text("import arkmesh\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n    1 / 0\n")
        failed = subprocess.run([ARKMESH, "config", "--keys", self.folder / "mine.py"], capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
        self.assertEqual((failed.returncode, failed.stderr), (2, "arkmesh: mine.py:4: ZeroDivisionError: division by zero\n"))

    def test_experiments_show_their_effect(self):
        """Each counts something, and nothing when the reach is tiny or the labs are apart."""
        tiny, apart = "scenario.{}.reach_m=0.01", "shared.projection.b.shift_x_m=100"
        for name, count, control in (("quorum", "lit_periods", tiny), ("relay", "reached", tiny), ("beacon", "gathered_periods", apart)):
            labs = [ROOT / f"experiments/{name}/{lab}.toml" for lab in "ab"]
            counted = []
            for more in ((), ("--set", control.format(name))):
                out = self.folder / f"{name}{len(counted)}"
                done = subprocess.run([ARKMESH, "run", *labs, "--seconds", "20", "--seed", "1", "--out", out, *more], capture_output=True,
                                      text=True, timeout=600, env=ENVIRONMENT)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                counted.append(sum(json.loads((out / lab / "result.json").read_text())["counts"].get(count, 0) for lab in "ab"))
            self.assertGreater(counted[0], 0, name)
            self.assertEqual(counted[1], 0, name)

    def test_experiments_of_the_kit_show_their_effect(self):
        """Robots that are told of others gather, and food comes home; and not where they are told nothing, or there is no time. By night quorums and weights, too."""
        def counts(lab, *sets, seed=1):
            out = self.folder / f"kit{len(list(self.folder.iterdir()))}"
            done = subprocess.run([ARKMESH, "run", ROOT / f"experiments/{lab}", "--seed", str(seed), "--out", out, *(part for s in sets for part in ("--set", s))],
                                  capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            return json.loads((out / "result.json").read_text())["counts"]

        def counted(lab, count, *sets):
            return counts(lab, *sets)[count]
        short = ("run.duration_s=60", "arena.robots=60")
        self.assertLess(counted("aggregation/a.toml", "until_half_s", *short), 60)
        self.assertGreater(counted("aggregation/a.toml", "until_half_s", *short, "scenario.aggregation.sees=false"), 60)
        # cameras and controller find and tell them
        self.assertLess(counted("aggregation/a_emulated.toml", "until_half_s", "run.duration_s=30", "scenario.aggregation.range_m=0.4"), 25)
        self.assertGreater(counted("foraging/a.toml", "trips", "run.duration_s=600"), 0)
        self.assertEqual(counted("foraging/a.toml", "trips", "run.duration_s=20"), 0)

        near, far = (counted("adaptation/a.toml", "after_pct", f"scenario.adaptation.range_m={range_m}") for range_m in (0.05, 1.5))
        self.assertLess(far + 10, near)
        if "ARKMESH_THOROUGH" not in os.environ:
            return

        def means(quorum):
            runs = [counts("best_of_n/a.toml", f"scenario.best_of_n.quorum={quorum}", "scenario.best_of_n.limit_s=600", seed=seed) for seed in range(201, 204)]
            return [sum(run[count] for run in runs) / 3 for count in ("right_pct", "decided_s")]
        hasty, patient = means(1), means(7)
        self.assertLess(hasty[0] + 10, patient[0])
        self.assertLess(hasty[1] + 100, patient[1])
        own, both, others = (counted("weights/a.toml", "wrong_after_pct", f"scenario.weights.weight={weight}") for weight in (0.0, 0.25, 1.0))
        self.assertLess(both, own)
        self.assertLess(own + 50, others)

    def test_each_piece_lights_up_some_robots(self):
        for piece in ("eyes", "crowd", "region", "floor", "towards", "light", "trail", "voices"):
            out = self.folder / piece
            done = subprocess.run([ARKMESH, "run", ROOT / "experiments/pieces/a.toml", "--seconds", "20", "--seed", "1", "--out", out, "--set", f"scenario.pieces.piece={piece}"],
                                  capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            last = arkmesh.open_run(out).labs["a"].led[-1]
            self.assertTrue(0 < (last > 0).mean() < 0.9, (piece, last))

    def test_bad_settings_of_the_kit_are_one_sentence(self):
        """Before anything starts: no robots move, and the file and line are named."""
        (self.folder / "no.png").write_text("no image")
        for asked, sentence in (("eyes(0)", "sectors must be 1 to 16, not 0"), ("trail('t', 100, 100, cell=0.001)", "100000 x 100000 cells, and the limit is 1048576"),
                                ("floor('f', 1, 1, 4, 4, image='no.png')", "no.png cannot be read as an image"), ("floor('f', 1, 1, 4, 4, image='none.png')", "cannot read the image"),
                                ("floor('f', 1, 1, 100000, 4, image='no.png')", "columns must be 1 to 1000"), ("region(corners=[(0,0),(1,1),(1,0),(0,1)])", "a polygon's sides cross"),
                                ("needs_airtime(500)", "500 words a second exceed the 54.5"), ("crowd(0.1, noise=-1)", "noise must be 0 to 1e+06, not -1"),
                                ("voices('v', 2, graph=[(('z', 1), ('a', 2))])", "a graph joins robot 1 of z, and the labs are a"), ("light(slope=(1,))", "slope must be two numbers"),
                                ("voices('v', 2, graph=[3])", "a graph must be pairs of robots"), ("light(beams=[3])", "a beam needs a path")):
            code, printed = self.run_it(f"import arkmesh\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n    lab.{asked}\n", "--force",
                                        "--set", "arena.use=ode", "--set", f"arena.ode.controller={ROOT}/tests/programs/labs_random_walk.c")
            self.assertNotEqual(code, 0, asked)
            self.assertIn(sentence, printed.splitlines()[-1])
            self.assertIn("at period 0: mine.py", printed)

    def test_scenarios_in_the_kits_page_run(self):
        blocks = re.findall("```python\n(.*?)```", (ROOT / "docs/virtual-sensors.md").read_text(), re.S)
        self.assertEqual(len(blocks), 1)
        for block in blocks:
            code, printed = self.run_it(block, "--set", "arena.use=ode", "--set", f"arena.ode.controller={ROOT}/experiments/foraging/foraging.c")
            self.assertEqual(code, 0, printed)

    def test_the_kit_gives_what_numpy_computes(self):
        """Eyes and crowds in each frame, and a trail that two labs lay: equal seeds, equal hashes."""
        (self.folder / "mine.py").write_text(KIT)
        greys = 255 - (numpy.arange(12).reshape(3, 4) % 4 * 64 + 10)  # the lowest row first
        Image.fromarray(greys[::-1].astype(numpy.uint8).repeat(10, axis=0).repeat(10, axis=1)).save(self.folder / "floor.png")
        for name in "ab":
            (self.folder / f"{name}.toml").write_text(f"""[lab]
name = "{name}"
[run]
scenario = "mine.py"
duration_s = 20
[gate]
period_s = 0.5
[shared]
labs = ["a", "b"]
[shared.projection.b]
turn_rad = 0.5
[sensors.mine]
reach_m = {0.2 if name == "b" else 0.1}
[arena]
robots = 20
width_m = 0.6
height_m = 0.6
[arena.ode]
controller = "{ROOT}/tests/programs/labs_random_walk.c"
""")
        results = []
        for out in ("one", "two"):
            done = subprocess.run([ARKMESH, "run", self.folder / "a.toml", self.folder / "b.toml", "--out", self.folder / out], capture_output=True, text=True,
                                  timeout=600, env=ENVIRONMENT)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            results.append(json.loads((self.folder / out / "result.json").read_text()))
        self.assertEqual(results[0]["final_hash"], results[1]["final_hash"])
        self.assertGreater(results[0]["counts"]["smelt"], 100)
        self.assertGreater(results[0]["counts"]["half"], 100)
        chance = [[line.split(",") for line in (self.folder / f"one/{name}/chance.csv").read_text().splitlines()[1:]] for name in "ab"]
        self.assertEqual([row[0] for row in chance[0]], [row[0] for row in chance[1]])
        self.assertTrue(all(mine[1] != other[1] for mine, other in zip(*chance)))

    @staticmethod
    def lab_of_three():
        return arkmesh.Lab({"file": "mine.py", "name": "a", "labs": ["a"], "owner": "a", "seed": 1, "period_s": 1, "frame_s": 0.1, "width_m": 1, "height_m": 1, "scale": 1,
                            "kinds": 16, "values": 1024, "whole_to_one": True, "robots": [0, 1, 2], "obstacles": [], "objects": []}, lambda setting: setting["default"])

    def test_robots_that_were_never_seen_do_not_matter(self):
        """Whoever is told nothing needs no value: rows that the mask leaves out may hold anything."""
        lab = self.lab_of_three()
        trail, voices = lab.trail("t", 1, 1, 0.1), lab.voices("v", 3, 1)
        lab.seen = numpy.array([True, False, True])
        values = numpy.array([5, numpy.nan, 7])
        lab.tell(lab.seen, value=values)
        lab.say(lab.seen, kind=numpy.array([1, -1, 2]))
        trail.lay(lab.seen, values)
        trail.lay(lab.seen, numpy.array([0.0, numpy.nan, 0.0]))  # nothing
        voices.say(lab.seen, numpy.array([0, numpy.nan, 2]))
        words, said = lab._take()
        self.assertEqual(numpy.frombuffer(words, arkmesh.lab_facade.WORD)["value"].tolist(), [5, 7, 0, 0])
        self.assertEqual([act.get("amounts", act.get("values")) for act in said["kit_acts"]], [[5, 7], [0, 2]])
        with self.assertRaisesRegex(ValueError, "value must be whole numbers"):
            lab.tell([1], value=[numpy.nan])
        with self.assertRaisesRegex(ValueError, "amount must be 0 or more"):
            trail.lay([0, 1], [1, numpy.nan])

    def test_what_people_are_told(self):
        """Words, units and curves reach the result and the recording; counts with a curve have a table; what cannot be shown is refused in the user's line."""
        text = """import arkmesh
class Mine(arkmesh.Scenario):
  def begin(self, lab):
    lab.setting("half_life_s", 60.0, unit="s")
    lab.setting("reach", 60.0, unit="m")
    lab.show("half_life_s", "half-life")
    lab.show("trips", "trips home", curve=True)
    lab.show("late", curve=True)
    lab.show("lit.robots", "lit", "robots", curve=True)
    lab.legend("site_hard", "hard 0/1 + 4/2")
    lab.legend(4, "walks")
  def period(self, lab):
    lab.count("trips", 2)
"""
        code, said = self.run_it(text, "--set", "gate.period_s=0.5")
        self.assertEqual(code, 0, said)
        shown = json.loads((self.folder / "out/result.json").read_text())["shown"]
        self.assertEqual([(each["of"], each["words"], each["unit"], each["curve"]) for each in shown], [
            ("setting.scenario.mine.half_life_s", "half-life", "s", False), ("setting.scenario.mine.reach", "", "m", False), ("series.trips", "trips home", "", True),
            ("series.late", "", "", True), ("series.lit.robots", "lit", "robots", True), ("colour.site_hard", "hard 0/1 + 4/2", "", False), ("led.4", "walks", "", False)])
        self.assertEqual((self.folder / "out/a/curves.csv").read_text().splitlines(), ["time_s,trips,late", "0,2,0", "1,6,0", "2,10,0", "3,14,0", "4,18,0"])
        self.assertIn(b"hard 0/1 + 4/2", (self.folder / "out/a/log.lcm").read_bytes())
        for line, wanted in (("lab.show('a,b')", "mine.py:4: ValueError: 'series.a,b': names"), ("lab.show('a', 'x' * 121)", "must be one line of at most 120 bytes"),
                             ("lab.legend('mauve', 'x')", "mine.py:4: ValueError: legend of 'mauve': must be an LED, 0 to 8, or one of note, other"), ("lab.legend(9, 'x')", "legend of 9")):
            shutil.rmtree(self.folder / "out")
            self.fails(FRAME.replace("frame", "begin") + line + "\n", wanted)
        shutil.rmtree(self.folder / "out")
        self.fails(FRAME + "lab.show('a')\n", "mine.py:4: RuntimeError: series.a: declare in begin()")

    def test_nothing_is_known_of_robots_that_were_never_seen(self):
        """Numbers are NaN, whole numbers -1, masks False and LEDs 8, of the lab and of each piece, until a frame holds the robot."""
        lab = self.lab_of_three()
        eyes, crowd, trail, disc = lab.eyes(2), lab.crowd(1), lab.trail("t", 1, 1, 0.1), lab.region(centre=(0, 0), radius=1)
        floor, home, gps, light, voices = lab.floor("f", 1, 1, 2, 2), lab.towards((0, 0)), lab.gps(), lab.light(), lab.voices("v", 2, 1)

        def told():
            found = [lab.xy, lab.shared_xy, lab.heading, lab.led, lab.seen, eyes.distance, eyes.bits, crowd.count, trail.value, trail.gradient, trail.zones, disc.inside,
                     floor.level, home.bearing, home.distance, home.sector(4), gps.column, gps.row, gps.heading, light.level, voices.heard]
            return [numpy.atleast_2d(each.T) for each in found]

        unknown = {"f": numpy.isnan, "i": lambda v: v == -1, "b": lambda v: v == 0, "u": lambda v: v == 8}
        kinds = "".join(each.dtype.kind for each in told())
        self.assertEqual(kinds, "fffubfiiffibiffiiiiii")
        self.assertTrue(all(unknown[each.dtype.kind](each).all() for each in told()))
        robots = {"ids": numpy.array([0, 2]), "xy": numpy.zeros((2, 2)), "shared_xy": numpy.zeros((2, 2)), "heading": numpy.zeros(2), "led": numpy.zeros(2, numpy.uint8)}
        lab._see(0, robots, numpy.zeros(0), numpy.zeros(0), [numpy.ones((2, piece.columns)) for piece in lab._pieces])
        self.assertEqual("".join(each.dtype.kind for each in told()), kinds)
        for each in told():
            self.assertEqual(unknown[each.dtype.kind](each).all(axis=0).tolist(), [False, True, False])

    def test_what_is_printed_beyond_the_logs_bound_is_said(self):
        """scenario.log holds 256 KiB; how many bytes it lacks is told at the end."""
        code, said = self.run_it("import arkmesh\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n    print('x' * (300 << 10), flush=True)\n")
        self.assertEqual(code, 0, said)
        self.assertIn(f"scenario.log lacks the last {(44 << 10) + 1} bytes that mine.py printed", said)
        self.assertEqual((self.folder / "out/a/scenario.log").stat().st_size, 256 << 10)

    def test_former_names_of_arguments_work_and_warn(self):
        """In the user's own line; both names at once are refused; the scenario's log has the warning."""
        lab = self.lab_of_three()
        for former, now in ((lambda: lab.crowd(range=0.2), "crowd(): is now called reach="), (lambda: lab.voices("v", 2, range=0.2), "voices(): is now called reach="),
                            (lambda: lab.message(bytes(9), type=5), "message(): is now called message_type="),
                            (lambda: lab.parameters(bytes(9), type=5), "parameters(): is now called message_type="),
                            (lambda: lab.setting("reach", 0.1, help="how near"), "setting(): is now called about="), (lambda: arkmesh.open, "arkmesh.open is now called arkmesh.open_run")):
            with self.assertWarnsRegex(DeprecationWarning, ".*".join(map(re.escape, now.split(": ")))) as warned:
                former()
            self.assertEqual(warned.filename, __file__)
        _, said = lab._take()
        self.assertEqual([piece["range"] for piece in said["kit"]], [0.2, 0.2])
        self.assertEqual([message["type"] for message in said["whole"] + said["parameters"]], [5, 5])
        with self.assertRaisesRegex(TypeError, "reach twice, once as range"):
            lab.crowd(range=0.1, reach=0.1)
        with self.assertRaises(AttributeError):
            arkmesh.openn  # pylint: disable=pointless-statement,no-member
        self.assertEqual(self.run_it("import arkmesh\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n    lab.setting('near', 1, help='x')\n")[0], 0)
        self.assertRegex((self.folder / "out/a/scenario.log").read_text(), r"mine.py:4: DeprecationWarning: help= of setting\(\) is now called about=")

    def test_what_a_region_has_is_alike_in_all_labs(self):
        """Also in a lab without robots, before the first boundary, and in finished()."""
        (self.folder / "mine.py").write_text("""import arkmesh
class Mine(arkmesh.Scenario):
    def begin(self, lab):
        self.food = lab.region(centre=(0, 0), radius=1, resource={"rate": 0.01, "capacity": 2})
        assert (self.food.stock, self.food.robots) == (2, 0)
    def period(self, lab):
        print(f"{self.food.stock:.6f} {self.food.robots}")
    def finished(self, lab):
        return self.food.stock <= 1.5
""")
        for name, robots in (("a", 5), ("b", 0)):
            (self.folder / f"{name}.toml").write_text(LAB.replace('"a"', f'"{name}"').replace("robots = 5", f"robots = {robots}").replace("duration_s = 4", "duration_s = 40")
                                                      .replace('use = "null"', f'ode.controller = "{ROOT}/tests/programs/labs_random_walk.c"') + '[shared]\nlabs = ["a", "b"]\n')
        done = subprocess.run([*self.command(), self.folder / "b.toml"], capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        said = [(self.folder / f"out/{name}/scenario.log").read_text() for name in "ab"]
        self.assertEqual(said[0], said[1])
        self.assertRegex(said[0], r"\A2.000000 5\n1.800000 5\n1.600000 5\n1.400000 5\n\Z")

    def test_pieces_that_labs_do_not_have_alike_are_refused(self):
        for kind, piece in (("trail.t", "lab.trail('t', 1, 1, 0.02, half_life=10 + len(lab.name))"), ("voices.v", "lab.voices('v', 2, len(lab.name))"),
                            ("resource.0", "lab.region(centre=(0, 0), radius=1, resource={'rate': len(lab.name)})"),
                            ("floor.f", "lab.floor('f', 1, 1, 2, 1, tiles=[[0, len(lab.name)]])")):
            with self.subTest(kind):
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                (self.folder / "mine.py").write_text(f"import arkmesh\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n    {piece}\n")
                for name in ("a", "bb"):
                    (self.folder / f"{name}.toml").write_text(LAB.replace('"a"', f'"{name}"') + '[shared]\nlabs = ["a", "bb"]\n')
                done = subprocess.run([*self.command(), self.folder / "bb.toml"], capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(f"scenario.mine.{kind}", done.stdout + done.stderr)

    def test_images_of_a_floor(self):
        """Of 8 and 16 bits, and transparent, which is white; they are kept, so that the run can be repeated without them."""
        grey = numpy.array([[0, 255], [100, 200]], dtype=numpy.uint8)  # the upper row first
        Image.fromarray(grey).save(self.folder / "g8.png")
        Image.fromarray(grey.astype(numpy.uint16) * 257).save(self.folder / "g16.png")
        Image.fromarray(numpy.dstack([grey * 0, grey * 0, grey * 0, 255 - grey])).save(self.folder / "clear.png")
        (self.folder / "mine.py").write_text("""import arkmesh
class Mine(arkmesh.Scenario):
    def begin(self, lab):
        self.floors = [lab.floor(name, 0.5, 0.5, 2, 2, image=name + ".png", levels=256) for name in ("g8", "g16", "clear")]
    def frame(self, lab):
        x, y = lab.xy.T > 0
        for floor in self.floors:
            assert abs(floor.level - (255 - ((~y) * (100 + 100 * x) + y * 255 * x))).max() <= 1
""")
        (self.folder / "a.toml").write_text(LAB.replace('use = "null"', f'width_m = 0.5\nheight_m = 0.5\node.controller = "{ROOT}/tests/programs/labs_random_walk.c"'))
        code, said = self.run_it(None)
        self.assertEqual(code, 0, said)
        for image in self.folder.glob("*.png"):
            image.unlink()
        again = subprocess.run([ARKMESH, "rerun", self.folder / "out"], capture_output=True, text=True, timeout=600, env=ENVIRONMENT)
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)

    def test_a_name_that_means_something_else_is_refused_where_it_is_given(self):
        """In the class as in a method: `every` that is no whole number, and what hides what the lab calls."""
        begin = "import arkmesh, numpy\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n    "
        for text, wanted in ((begin + "self.every = lab.setting('gps_s', 1.5)", "mine.py:4: ValueError: `every` must be a whole number (frame() gets each k-th frame; 0: none)"),
                             (begin + "self.every = -1", "mine.py:4: ValueError: `every` must be"), (begin + "self.every = True", "mine.py:4: ValueError: `every` must be"),
                             ("import arkmesh\nclass Mine(arkmesh.Scenario):\n  every = 0.5\n", "mine.py:2: ValueError: `every` must be"),
                             (begin + "self.period = 2.0", "mine.py:4: ValueError: the lab calls `period`; give 2.0 another name"),
                             (begin + "self.finished = False", "mine.py:4: ValueError: the lab calls `finished`"),
                             ("import arkmesh\nclass Mine(arkmesh.Scenario):\n  frame = 3\n", "mine.py:2: ValueError: the lab calls `frame`")):
            with self.subTest(text):
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                self.fails(text, wanted)
        shutil.rmtree(self.folder / "out")
        code, said = self.run_it(begin + "self.every = numpy.int64(5)\n  def frame(self, lab):\n    lab.count('frames')\n")
        self.assertEqual(code, 0, said)
        self.assertEqual(json.loads((self.folder / "out/a/result.json").read_text())["counts"]["frames"], 9)
        shutil.rmtree(self.folder / "out")
        code, said = self.run_it(begin + "self.every = 0\n  def frame(self, lab):\n    lab.count('frames')\n  def period(self, lab):\n    lab.count('boundaries')\n")
        self.assertEqual(code, 0, said)
        counts = json.loads((self.folder / "out/a/result.json").read_text())["counts"]
        self.assertNotIn("frames", counts)
        self.assertGreater(counts["boundaries"], 0)

    def test_an_initial_field_stays_readable(self):
        """Of the own lab and of others, in each period; one that is told in each period is as told last."""
        (self.folder / "mine.py").write_text("""import arkmesh
class Mine(arkmesh.Scenario):
    def begin(self, lab):
        lab.declare("places", 2, 0, 10, owner_only=True, initial_only=True)
        lab.declare("size", 1, 0, 10, initial_only=True)
        lab.declare("now", 1, 0, 10)
        if lab.is_owner:
            lab.publish("places", [3, 4])
        lab.publish("size", 1 + (lab.name == "b"))
    def period(self, lab):
        lab.publish("now", lab.periods)
        print(lab.periods, lab.field(lab.owner, "places").tolist(), [lab.field(each, "size").tolist() for each in lab.labs], lab.field("b", "now").tolist())
""")
        for name in "ab":
            (self.folder / f"{name}.toml").write_text(LAB.replace('"a"', f'"{name}"') + '[gate]\nperiod_s = 1.0\n[shared]\nlabs = ["a", "b"]\n')
        done = subprocess.run([*self.command(), self.folder / "b.toml"], capture_output=True, text=True, timeout=60, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for name in "ab":
            said = (self.folder / f"out/{name}/scenario.log").read_text().splitlines()
            self.assertEqual(said, [f"{k} [3, 4] [[1], [2]] {[k - 1] if k else []}" for k in range(5)])

    def test_a_table_that_nobody_asks_for_is_refused(self):
        code, said = self.run_it("import arkmesh\nclass Mine(arkmesh.Scenario):\n  pass\n", "--set", "sensors.mine.x=1")
        self.assertEqual(code, 2)
        self.assertIn("sensors.mine", said)

    def test_pieces_that_are_none(self):
        begin = "import arkmesh, math\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n    "
        for text, wanted in [(begin + "lab.region(corners=[(0, 0), (1, 1), (1, 0), (0, 1)])", "mine.py:4: a polygon's sides cross; give its corners in order"),
                             (begin + "lab.region(centre=(0, 0), radius=0)", "mine.py:4: a disc of radius 0 m is not a region"),
                             (begin + "lab.region(centre=(0, 0), radius=1, resource={'size': 1})", "mine.py:4: ValueError: a resource must be a dict with any of capacity"),
                             (begin + "lab.floor('f', 1, 1, 5000, 2)", "mine.py:4: ValueError: columns must be 1 to 1000, not 5000"),
                             (begin + "lab.floor('f', 1, 1, 2, 2, tiles=[1])", "mine.py:4: ValueError: tiles must be 2 x 2 levels"),
                             (begin + "lab.voices('v', 65, 1)", "mine.py:4: ValueError: values must be 1 to 64"),
                             (begin + "lab.eyes(0)", "mine.py:4: ValueError: sectors must be 1 to 16, not 0"),
                             (begin + "lab.crowd(math.nan)", "mine.py:4: ValueError: reach must be"),
                             (begin + "lab.trail('a b', 1, 1, 0.1)", "ValueError: the name of a trail must be a word"),
                             (begin + "lab.trail('t', 1, 1, 1e-6)", "mine.py:4: cell = 1e-06 of a pheromone: makes 1000000 x 1000000 cells"),
                             (begin + "lab.trail('t', 1, 1, 0.1, zones=(0, 1, 1, 1))", "mine.py:4: ValueError: the number of zones must be 1 to 32, not 0"),
                             (begin + "lab.trail('t', 1, 1, 0.1, zones=(4,))", "mine.py:4: ValueError: zones must be a number"),
                             (begin + "lab.trail('t', 1, 1, 0.1, zones=(4, 3, 50, 0))", "mine.py:4: zones of 50 m cover 500 cells"),
                             (begin + "lab.trail('t', 1, 1, 0.1, cap=math.inf)", "mine.py:4: ValueError: cap must be 0 to 1e+12, not inf"),
                             (begin + "lab.trail('t', 2, 2, 0.002, diffusion=4e-3)", "mine.py:4: a pheromone with this diffusion or wind needs"),
                             (begin + "lab.trail('t', 1, 1, 0.1); lab.voices('t', 2, 1)", "mine.py:4: ValueError: there is a trail or voices 't' already"),
                             (begin + "lab.floor('f', 1, 1, 2, 2); lab.floor('f', 1, 1, 2, 2)", "mine.py:4: ValueError: there is a floor 'f' already"),
                             (begin + "lab.declare('x'); lab.declare('x')", "mine.py:4: ValueError: field 'x' is declared already"),
                             (begin + "lab.declare('kit.x')", "mine.py:4: ValueError: field 'kit.x' is one of the kit"),
                             (begin + "lab.eyes(2.7)", "mine.py:4: ValueError: sectors must be a whole number, not 2.7"),
                             (begin + "lab.eyes(robots=True)", "mine.py:4: ValueError: robots must be a number, not True"),
                             (begin + "lab.floor('f', 1, 1, 2, 1, tiles=[[math.nan, 1]])", "mine.py:4: ValueError: tiles must be whole numbers from 0 to 255"),
                             (begin + "lab.region(centre=(0, 0), radius=1, resource={'rate': 'fast'})", "mine.py:4: ValueError: rate of a resource must be a number"),
                             (begin + "lab.voices('v', 2, graph=[(('a', 1), ('a', 99))])", "mine.py:4: ValueError: a graph joins robot 99 of a"),
                             (FRAME + "lab.eyes(4)", "mine.py:4: RuntimeError: eyes: ask for pieces of the kit in begin()")]:
            with self.subTest(text):
                shutil.rmtree(self.folder / "out", ignore_errors=True)
                self.fails(text, wanted)

    def test_ctrl_c_ends_both_at_once(self):
        """Also while the child computes: the run is stopped, not failed, and no process is left."""
        (self.folder / "mine.py").write_text(FRAME + f"open({str(self.folder / 'pid')!r}, 'w').write(str(os.getpid())); time.sleep(600)\n")
        with subprocess.Popen(self.command("--set", "scenario.answer_s=500"), env=ENVIRONMENT, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT) as lab:
            until = time.monotonic() + 300
            while not (self.folder / "pid").exists() or not (self.folder / "pid").read_text():
                self.assertLess(time.monotonic(), until)
                time.sleep(0.02)
            lab.send_signal(signal.SIGINT)
            lab.communicate(timeout=300)
        self.assertEqual(json.loads((self.folder / "out/a/result.json").read_text())["state"], "stopped")
        with self.assertRaises(ProcessLookupError):
            os.kill(int((self.folder / "pid").read_text()), 0)


if __name__ == "__main__":
    unittest.main()
