"""drawing/robot_fit.py: what single robots are like is found in tracks of hidden robots, and what tracks cannot tell is named."""
import math
import pathlib
import random
import re
import sys
import tempfile
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "drawing"), str(ROOT / "scripts")]
import robot_fit
import robot_tracks

LEGS_M, AXLE_M, TICK_S = 0.0277, 0.0099, 0.05
PROGRAM = [(robot_fit.STRAIGHT, 6), (robot_fit.LEFT, None), (robot_fit.STRAIGHT, 6), (robot_fit.RIGHT, None), (robot_fit.REST, 1.5)]


def hidden(chance):
    return {"speed_m_per_s": chance.uniform(0.006, 0.013), "drift_deg_per_s": chance.gauss(0, 5), "turn_left_deg_per_s": chance.uniform(30, 50),
            "turn_right_deg_per_s": chance.uniform(30, 50), "turn_noise_deg_per_s": chance.uniform(1, 2.2), "turn_noise_s": 2, "led_bearing_deg": -chance.uniform(35, 72)}


def walk(robot, seconds, chance, seen=True, shown=True):
    """A track as cameras see it: 0.5 mm and 2 degrees off, LED mistaken now and then; rotation about the rear legs as the simulator has it."""
    t = numpy.arange(0, seconds, 2 * TICK_S)
    z, heading, wander, now, rows = complex(0, 0), chance.uniform(-3, 3), 0.0, 0.0, []
    keeps, led, left = math.exp(-TICK_S / robot["turn_noise_s"]), 0, 0.0
    steps = iter(())
    for i in range(2 * len(t)):
        if left <= 0:
            try:
                led, span = next(steps)
            except StopIteration:
                steps = iter(PROGRAM)
                led, span = next(steps)
            left = span or chance.uniform(5, 10)
        left -= TICK_S
        wander = keeps * wander + robot["turn_noise_deg_per_s"] * math.sqrt(1 - keeps**2) * chance.gauss(0, 1)
        ahead = aside = turn = 0.0
        if led == robot_fit.STRAIGHT:
            ahead, turn = robot["speed_m_per_s"], math.radians(robot["drift_deg_per_s"])
        elif led != robot_fit.REST:
            sign = 1 if led == robot_fit.LEFT else -1
            turn = sign * math.radians(robot["turn_left_deg_per_s" if sign > 0 else "turn_right_deg_per_s"])
            ahead, aside = abs(turn) * LEGS_M / 2, turn * AXLE_M
        if turn or ahead:
            turn, aside = turn + math.radians(wander), aside + math.radians(wander) * AXLE_M
        z += complex(ahead, aside) * numpy.exp(1j * (heading + turn * TICK_S / 2)) * TICK_S
        heading += turn * TICK_S
        if i % 2 == 1:
            noisy = complex(chance.gauss(0, 5e-4), chance.gauss(0, 5e-4))
            light = robot_fit.wrapped(heading + math.radians(robot["led_bearing_deg"]) + chance.gauss(0, math.radians(2)))
            rows.append((now, z + noisy, light if seen else math.nan, (led if chance.random() > 0.01 else 7) if shown else 0))
        now += TICK_S
    t, z, direction, led = zip(*rows)
    return {"t": numpy.array(t), "z": numpy.array(z), "direction": numpy.array(direction, float), "led": numpy.array(led)}


def spread_out(tracks):
    """So that none touch."""
    return {robot: {**track, "z": track["z"] + 2 * robot} for robot, track in tracks.items()}


class Fit(unittest.TestCase):
    def test_recovery(self):
        """Of hidden robots, 5 minutes each, speed and turn rates are within 5 %, drift within two standard errors, but for chance, bearings within 3 degrees."""
        offs = []
        for seed in range(3):
            chance = random.Random(seed)
            robots = {i: hidden(chance) for i in range(20)}
            told, missing, _, own = robot_fit.fit(spread_out({i: walk(robot, 300, chance) for i, robot in robots.items()}))
            self.assertTrue(own)
            self.assertFalse(any(missing.values()), missing)
            for key in ("speed_m_per_s", "turn_left_deg_per_s", "turn_right_deg_per_s"):
                worst = max(abs(told[i][key][0] / robots[i][key] - 1) for i in robots)
                self.assertLess(worst, 0.05, (seed, key))
            offs += [(told[i]["drift_deg_per_s"][0] - robots[i]["drift_deg_per_s"]) / told[i]["drift_deg_per_s"][1] for i in robots]
            self.assertLess(max(told[i]["drift_deg_per_s"][1] for i in robots), 1.0)
            self.assertLess(max(abs(told[i]["led_bearing_deg"][0] - robots[i]["led_bearing_deg"]) for i in robots), 3, seed)
            ratio = [told[i]["turn_noise_deg_per_s"][0] / robots[i]["turn_noise_deg_per_s"] for i in robots]
            self.assertAlmostEqual(sum(ratio) / 20, 1, delta=0.2, msg=f"{seed} {ratio}")
            self.assertTrue(0.8 < told[0]["turn_noise_s"][0] < 5, told[0]["turn_noise_s"])
        # 97 % of many robots are; fewer than 54 of 60 would not be chance
        self.assertGreaterEqual(sum(abs(off) < 2 for off in offs), 54, offs)

    def test_what_is_not_told(self):
        """A robot that hardly moves has a speed and turns but no drift or bearing by its path; one that is taken away nothing; a bearing that is not seen is named."""
        chance = random.Random(7)
        robots = {i: hidden(chance) for i in range(5)}
        robots[1]["speed_m_per_s"] = 0.0004
        tracks = spread_out({i: walk(robot, 20 if i == 2 else 200, chance, seen=i != 3) for i, robot in robots.items()})
        told, missing, _, _ = robot_fit.fit(tracks)
        self.assertLess(told[1]["speed_m_per_s"][0], 0.001)
        self.assertEqual(missing[1], {key: "hardly moves" for key in ("drift_deg_per_s", "turn_noise_deg_per_s", "turn_noise_s")})
        self.assertAlmostEqual(told[1]["led_bearing_deg"][0], robots[1]["led_bearing_deg"], delta=3)  # by its pivots
        self.assertEqual(told[2], {})
        self.assertEqual(set(missing[2].values()), {"too few stretches"})
        self.assertIn("led_bearing_deg", missing[3])
        self.assertAlmostEqual(told[3]["drift_deg_per_s"][0], robots[3]["drift_deg_per_s"], delta=2)  # by the path's bend
        self.assertFalse(missing[0] or missing[4])
        headings = {**tracks[0], "direction": tracks[0]["direction"] - math.radians(robots[0]["led_bearing_deg"]) + robot_fit.FOLLOWS * math.radians(robots[0]["led_bearing_deg"] + 44)}
        told, _, _, _ = robot_fit.fit({0: headings}, directions=-44.0, own_program=True)  # tracked headings that assume 44 degrees
        self.assertAlmostEqual(told[0]["led_bearing_deg"][0], robots[0]["led_bearing_deg"], delta=2)

    def test_free_walks(self):
        """Robots with a program of their own, whose LEDs say nothing: speed, drift and noise, no turns and no bearing."""
        chance = random.Random(3)
        robots = {i: {**hidden(chance), "drift_deg_per_s": chance.gauss(0, 2)} for i in range(8)}
        told, missing, _, own = robot_fit.fit(spread_out({i: walk(robot, 300, chance, shown=False) for i, robot in robots.items()}))
        self.assertFalse(own)
        for i, robot in robots.items():
            self.assertAlmostEqual(told[i]["speed_m_per_s"][0] / robot["speed_m_per_s"], 1, delta=0.05)
            self.assertAlmostEqual(told[i]["drift_deg_per_s"][0], robot["drift_deg_per_s"], delta=2.5)
            self.assertEqual(missing[i], {key: "walked freely" for key in ("turn_left_deg_per_s", "turn_right_deg_per_s", "led_bearing_deg")})

    def test_tracks_of_a_film(self):
        """The table of `arkmesh track --csv` tells what free walks tell; rows that are old or doubtful do not count, and another table is refused by name."""
        header = re.search(r'"(frame,time_s,.*?)\\n"', (ROOT / "testbed/track_outputs.cpp").read_text()).group(1)
        chance = random.Random(3)
        robots = {i: {**hidden(chance), "drift_deg_per_s": chance.gauss(0, 2)} for i in range(4)}
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder, "film.csv")
            rows = [header]
            for i, track in spread_out({i: walk(robot, 300, chance, shown=False) for i, robot in robots.items()}).items():
                for n, (t, z, heading) in enumerate(zip(track["t"], track["z"], track["direction"])):
                    rows.append(f"{n},{t:.6f},{i},{z.real:.6f},{z.imag:.6f},{heading:.5f},0.0500,unknown,1.000,0.000,0,1.00,2.00")
                    rows.append(f"{n},{t + 0.01:.6f},{i},9.0,9.0,0.0,0.0500,red,1.000,{'0.100,0' if n % 2 else '0.000,1'},1.00,2.00")
            table.write_text("\n".join(rows) + "\n")
            tracks, *arena, directions = robot_tracks.read(table)
            told, _, _, own = robot_fit.fit(tracks, *arena, directions)
            self.assertFalse(own)
            for i, robot in robots.items():
                self.assertAlmostEqual(told[i]["speed_m_per_s"][0] / robot["speed_m_per_s"], 1, delta=0.05)
            table.write_text(rows[0] + "\n0,zero\n")
            with self.assertRaisesRegex(robot_tracks.Refused, "film.csv is not a table of tracks; give one written"):
                robot_tracks.read(table)

    def test_pushed_robots(self):
        """Stretches beside another robot or a wall, and those in which a robot was stopped, do not count."""
        chance = random.Random(5)
        robot = hidden(chance)
        tracks = {0: walk(robot, 400, chance), 1: walk(robot, 400, chance)}
        tracks[1]["z"] += 2
        held = numpy.flatnonzero((tracks[0]["t"] > 100) & (tracks[0]["t"] < 160))
        tracks[0]["z"][held] = tracks[0]["z"][held[0]]
        tracks[1]["z"][held] = tracks[0]["z"][held] + 0.033
        told, _, _, _ = robot_fit.fit(tracks)
        self.assertAlmostEqual(told[0]["speed_m_per_s"][0] / robot["speed_m_per_s"], 1, delta=0.05)
        brief = {0: walk(robot, 200, chance), 1: walk(robot, 200, chance)}  # a neighbour for a moment of each stretch spoils that moment only
        brief[1]["z"] += 2
        brief[1]["z"][::45] = brief[0]["z"][::45] + 0.033
        told, _, _, _ = robot_fit.fit(brief)
        for key in ("speed_m_per_s", "turn_left_deg_per_s", "turn_right_deg_per_s"):
            self.assertAlmostEqual(told[0][key][0] / robot[key], 1, delta=0.1, msg=key)
        walls = robot_fit.apart({0: {"t": numpy.array([0.0, 0.1]), "z": numpy.array([0.2, 0.24])}}, 0.5, 0.5)
        self.assertEqual(walls[0].tolist(), [True, False])


if __name__ == "__main__":
    unittest.main()
