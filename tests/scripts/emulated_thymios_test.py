"""A lab of Thymios on an emulated testbed, all processes of their own: the team formation of experiments/makes, its roll call, STOP, and faults."""
import contextlib
import csv
import itertools
import math
import os
import pty
import re
import select
import socket
import subprocess
import threading
import tty
import unittest

from aseba_test import to_segment
from emulated_lab import EmulatedLab
from lab_processes import PROGRAM, ROOT

LAB = """include = ["{root}/experiments/makes/dhtf_testbed.toml"]
[bus]
url = "udpm://239.255.76.67:7794?ttl=0&recv_buf_size=4194304"
[arena.aseba]
connect = "{nodes}"
[[arena.aseba.cameras]]
source = "{camera}"
calibration = "{folder}/testbed.yaml"
"""


class Dongle:
    """A serial device by a name that stays, as of a radio dongle. It is unplugged when the nodes' end is cut, and plugged in again after a second."""

    def __init__(self, name, host, port):
        self.name, self.address, self.ended = name, (host, int(port)), threading.Event()
        threading.Thread(target=self.run, daemon=True).start()

    def run(self):
        while not self.ended.wait(1):
            with contextlib.suppress(OSError), socket.create_connection(self.address) as nodes:
                ours, device = pty.openpty()
                tty.setraw(device)
                self.name.symlink_to(os.ttyname(device))
                try:
                    self.pass_on(ours, nodes)
                finally:
                    self.name.unlink()
                    os.close(device)
                    os.close(ours)

    def pass_on(self, ours, nodes):
        while not self.ended.is_set():
            ready, _, _ = select.select([ours, nodes], [], [], 0.2)
            if ours in ready:
                nodes.sendall(os.read(ours, 4096))
            if nodes in ready:
                if not (said := nodes.recv(4096)):
                    return
                while said:
                    said = said[os.write(ours, said):]


class EmulatedThymios(EmulatedLab):
    def test_lab(self):
        self.start("emulator", "emulator", ROOT / "experiments/makes/testbed.toml", "--calibration", self.folder / "testbed.yaml", "--truth",
                   self.folder / "truth.csv", "--set", "emulator.camera_port=0", "--set", "emulator.nodes_port=0", "--set", "emulator.control_port=0")
        where = self.until(300, lambda: re.search(r"(http://\S+)\nnodes: tcp:(\S+)\ncommands: ([\d.]+):(\d+)", self.said("emulator")), "the emulator's start")
        self.control = where[3], int(where[4])
        lab = self.folder / "lab.toml"
        written = LAB.format(root=ROOT, camera=where[1], nodes="tcp:" + where[2], folder=self.folder)
        lab.write_text(written)
        # the roll call, over TCP; then all over a serial line
        done = subprocess.run([PROGRAM, "doctor", lab], capture_output=True, text=True, timeout=120)
        self.assertIn(f"robot 6: node 6 of tcp:{where[2]}, thymio-II with 7 variables", done.stdout + done.stderr)
        self.assertNotIn("run no program", done.stdout + done.stderr)
        dongle = Dongle(self.folder / "dongle", *where[2].split(":"))
        self.addCleanup(dongle.ended.set)
        self.until(10, dongle.name.exists, "the dongle's device")
        lab.write_text(written.replace("tcp:" + where[2], str(dongle.name)))
        self.start("lab", "lab", lab, "--set", "run.duration_s=10000", "--set", 'shared.labs=["thymios"]', "--set", "shared.owner=thymios", "--out",
                   self.folder / "run")
        self.until(300, lambda: re.search(r"period [1-9]", self.said("lab")), "the naming of everybody")
        self.until(300, lambda: self.moved_m(2) > 0.05, "robots that drive")
        # STOP, and on
        self.assertEqual(subprocess.run([PROGRAM, "pause", lab], capture_output=True, timeout=120, check=False).returncode, 0)
        self.until(60, lambda: self.moved_m(2) == 0, "robots that stand")
        self.assertEqual(subprocess.run([PROGRAM, "resume", lab], capture_output=True, timeout=120, check=False).returncode, 0)
        self.until(60, lambda: self.moved_m(2) > 0.05, "robots that drive on")
        for line, said in (("robot 2 kill", "robot 3, node 3"), ("nodes garbage 1000000", "received bytes that belong to no Aseba message"),
                           ("nodes cut", "is gone with its connection")):
            self.command(line)
            self.until(120, lambda said=said: said in self.said("lab"), line)
        self.command("robot 2 revive")
        self.until(120, lambda: self.said("lab").count("robot 3 is node 3") == 2, "a robot that is back")
        # a lab that is killed leaves robots that stop by themselves
        code, result = self.end_lab()
        self.assertEqual((code, result["counters"].get("arena.nodes.lost", 0) >= 6), (3, True), result["counters"])
        self.until(60, lambda: self.moved_m(2) == 0, "robots that stand at the end")
        self.judge()

    def rows(self):
        with open(self.folder / "truth.csv", newline="") as table:
            return [row for row in csv.DictReader(line for line in table if line.endswith("\n")) if row["in_arena"]]

    def moved_m(self, seconds):
        """The farthest that any robot went in the last seconds of the truth."""
        rows = self.rows()
        late = [row for row in rows if float(row["time_s"]) > float(rows[-1]["time_s"]) - seconds]
        far = 0
        for robot in range(6):
            path = [(float(row["x_m"]), float(row["y_m"])) for row in late if int(row["robot"]) == robot]
            far = max(far, *(math.dist(path[0], place) for place in path))
        return far

    def judge(self):
        """Each pose that the lab recorded lies on its robot's true path, to within 5 mm."""
        subprocess.run([PROGRAM, "export", self.folder / "run", "--csv", "--out", self.folder / "csv"], capture_output=True, timeout=120, check=True)
        paths = {}
        for row in self.rows():
            paths.setdefault(int(row["id"]), []).append((float(row["x_m"]), float(row["y_m"])))
        with open(self.folder / "csv/thymios/poses.robots.csv", newline="") as table:
            poses = [(int(row["robot"]), (float(row["x_m"]), float(row["y_m"]))) for row in csv.DictReader(table)]
        self.assertGreater(len(poses), 20)
        self.assertLess(max(min(to_segment(place, *ends) for ends in itertools.pairwise(paths[robot])) for robot, place in poses), 0.005)


if __name__ == "__main__":
    unittest.main()
