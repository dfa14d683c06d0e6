"""One cell: a day with robots as docs/your-first-testbed.md has it, in an emulated room, from the chessboard to ten minutes of an experiment. One robot is dead, and
the controller's cable is pulled once. The emulator's truth judges; see tests/campaign/campaign."""
import bisect
import collections
import dataclasses
import json
import math
import re
import time
import urllib.request

import campaign_files
import read_log
from campaign_cell import LINE_AWAY_S, Cell, Pace

ROBOTS, DEAD, SIDE_M, SECONDS = 12, 5, 0.5, 600
ON_ROBOT_M = 0.012  # a pose that is farther from the robot of its name is that of another
ROOMS = {  # of the emulator's scene and camera; none was used to train or to set the tracker
    "bright room": ("arena_grey = 215, wall_grey = 120, glare = 0.45, light_slope = 0.35, light_from_deg = 130, texture = 0.02, cell_brightness = 1.6, distractors = true", "noise = 3, blur_px = 0.8, roll_deg = -2"),
    "dim room": ("arena_grey = 150, wall_grey = 60, glare = 0.3, light_slope = 0.5, light_from_deg = 20, texture = 0.1, shadow = 0.5, cell_radius = 0.7", "noise = 6, vignetting = 0.3, x_m = 0.06, y_m = -0.05"),
    "blurred room": ("arena_grey = 180, wall_grey = 90, glare = 0.5, light_slope = 0.2, light_from_deg = -80, domes = 0.5, distractors = true", "noise = 4, blur_px = 1.6, roll_deg = 3, look_x_m = 0.03")}
EMULATOR_TEXT = """emulator = {{frames_per_s = 10.0, ids = "in_order", scene = {{{scene}}}, camera = [
  {{name = "camera0", width_px = 960, height_px = 720, z_m = 0.95, latency_s = 0.15, distortion = [-0.08, 0.02, 0.0005, -0.0004, 0.0], {camera}}}]}}
arena = {{robots = {robots}, width_m = {side}, height_m = {side}, ode = {{preset = "measured", controller = "{controller}", overhead_loss = 0.02}}}}
"""


class RehearsalCell(Cell):
    robots = ROBOTS

    def __init__(self, *what):
        super().__init__(*what)
        divide = what[-1]
        self.pace, self.patience_s = Pace(2.0, float(SECONDS // divide), SECONDS // divide // 6), 60

    def write_files(self):
        scene, camera = ROOMS[self.fault]
        (self.out / "emulator.toml").write_text(EMULATOR_TEXT.format(camera=camera, scene=scene, robots=ROBOTS, side=SIDE_M, controller=campaign_files.DHTF))
        text = campaign_files.lab("roark", duration_s=self.pace.duration_s, period_s=self.pace.period_s, robots=ROBOTS, out=self.out, patience_s=self.patience_s,
                                  use="kilobot", pace=1.0, side_m=SIDE_M, controller=campaign_files.DHTF)
        text = text[:text.index("[gateway]")].replace("kilobot = {", "kilobot = {may_miss = 1, ").replace('testbed.yaml"', 'testbed.yaml", latency_ms = 150')
        text += 'shared = {labs = ["roark"], owner = "roark"}\n'
        (self.out / "roark.toml").write_text(text)
        return [self.out / "roark.toml"]

    def calibrate(self):
        """As on the day: pictures of a chessboard, and one of the arena."""
        self.step("emulator", self.out / "emulator.toml", "--chessboard", "15", self.out / "boards")
        with urllib.request.urlopen("http://127.0.0.1:8090/camera0.jpg", timeout=60) as answer:
            (self.out / "arena.jpg").write_bytes(answer.read())
        (self.out / "testbed.yaml").unlink(missing_ok=True)
        self.step("calibrate", *sorted((self.out / "boards").glob("*.png")), "--board", "9x6", "--square-mm", "25", "--corners", self.out / "arena.jpg",
                  "--arena", f"{SIDE_M}x{SIDE_M}", "--out", self.out / "testbed.yaml", codes=(0,))

    def identify(self):
        """All but the dead one are named, and that one is named as missing."""
        self.tell_emulator(f"robot {DEAD} kill")
        said = self.step("identify", self.out / "roark.toml", codes=(0, 1, 3, 4))
        if f"{ROBOTS - 1} of {ROBOTS} robots named" not in said or not re.search(rf"\b{DEAD}\b", said.replace(f"{ROBOTS - 1} of {ROBOTS}", "")):
            self.problems.append(f"identify says: {said.strip()[-300:]}")

    def experiment(self):
        self.start_lab("roark")
        self.until(300 + SECONDS, lambda: self.ears["roark"].period() >= self.pace.fault_at or not self.lives(), "a third of the run")
        self.tell_emulator("ohc unplug")
        time.sleep(LINE_AWAY_S)
        self.tell_emulator("ohc plug")
        self.until(2 * SECONDS, lambda: not self.lives(), "the end of the run")
        self.ended["roark"] = self.emulator_time_s()
        unseen = {robot["why"] for robot in self.result_of("roark").get("not_standing", [])}
        if self.process().poll() == 4 and unseen <= {"not yet", "not in sight", "not named"}:  # pictures came too late to tell; the truth does
            self.promise = dataclasses.replace(self.promise, code=4)
        self.judge_lab("roark", "finished", "")
        self.judge_stillness(self.ended["roark"])

    def judge_names(self):
        """Poses of the record beside the truth: the lab's clock began at a moment of the emulator's that fits them best."""
        at_time = {}
        for row in self.truth():
            at_time.setdefault(float(row["time_s"]), {})[int(row["robot"])] = float(row["x_m"]), float(row["y_m"])
        times, places = list(at_time), list(at_time.values())
        frames = [message for _, channel, data in read_log.events(read_log.log_in(self.folders["roark"])) if channel == "poses" and (message := read_log.decode(data)).robots]

        def offs(frame, began_s):
            at = places[min(bisect.bisect_left(times, began_s + frame.stamp_us / 1e6), len(times) - 1)]
            return [(math.dist(at[robot.robot], (robot.x_m, robot.y_m)), robot.robot) for robot in frame.robots if robot.age_us < 400_000]
        some = frames[::max(1, len(frames) // 60)]
        began = min((step / 10 for step in range(int(times[-1] * 10))), key=lambda began: sum(min(off, 0.05) for frame in some for off, _ in offs(frame, began)))
        judged = [off for frame in frames for off in offs(frame, began)]
        wrong = collections.Counter(robot for off, robot in judged if off > ON_ROBOT_M)
        named = {robot for _, robot in judged}
        if not named:
            self.problems.append(f"no robot has a pose in the {len(frames)} frames of poses in the record")
            return
        walked = max(math.dist(places[0][robot], places[-1][robot]) for robot in named)
        self.figures.update(poses=len(judged), wrong=sum(wrong.values()), named=len(named), seen_percent=round(100 * len(judged) / (len(frames) * (ROBOTS - 1)), 1), walked_m=round(walked, 3))
        self.wrong_if(wrong, f"{sum(wrong.values())} of {len(judged)} poses are those of another robot: {dict(wrong)}")
        self.wrong_if(named != set(range(ROBOTS)) - {DEAD}, f"named in the record are {sorted(named)}")
        self.wrong_if(walked < 0.05, "no robot has walked 5 cm")
        result = json.loads((self.folders["roark"] / "result.json").read_text())
        self.figures["tasks"] = result["counts"]
        self.figures["followed"] = result["notes"][-1] if result["notes"] else ""

    def play(self):
        self.calibrate()
        self.identify()
        self.experiment()
        self.judge_names()
