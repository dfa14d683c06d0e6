"""A lab on an emulated testbed, both processes of their own: faults given over the emulator's command port are noticed by the lab, which comes
through them, and are in its counters afterwards."""
import json
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import time
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
import campaign_files
from lab_processes import PROGRAM, ROOT, end_with_parent

LAB = """include = ["{root}/experiments/dhtf/common.toml", "{root}/experiments/dhtf/presets/paper.toml"]
[lab]
name = "roark"
[bus]
url = "udpm://239.255.76.67:7792?ttl=0&recv_buf_size=4194304"
[shared]
labs = ["roark"]
owner = "roark"
[arena]
use = "kilobot"
width_m = 0.5
height_m = 0.5
robots = 4
[arena.kilobot]
port = "tcp://{ohc}"
[[arena.kilobot.cameras]]
source = "{camera}"
calibration = "{folder}/testbed.yaml"
"""


class EmulatorFaults(unittest.TestCase):
    def setUp(self):
        if not PROGRAM.exists():
            self.skipTest("scripts/build has not been run")
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)
        self.processes = {}

    def start(self, name, *command):
        with open(self.folder / f"{name}.txt", "wb") as said:
            process = subprocess.Popen([PROGRAM, *command], stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT, preexec_fn=end_with_parent)
        self.addCleanup(self.end, process)
        self.processes[name] = process

    def end(self, process):
        if process.poll() is None:
            process.kill()
            process.wait()

    def said(self, name):
        file = self.folder / f"{name}.txt"
        return file.read_text(errors="replace") if file.exists() else ""

    def until(self, seconds, condition, what):
        end = time.monotonic() + seconds
        while not (found := condition()):
            for name, process in self.processes.items():
                self.assertIsNone(process.poll(), f"{name} has ended: {self.said(name)[-500:]}")
            self.assertLess(time.monotonic(), end, f"{what} has not happened; emulator: {self.said('emulator')[-500:]} lab: {self.said('lab')[-1500:]}")
            time.sleep(0.1)
        return found

    def command(self, line):
        with socket.create_connection(self.control, timeout=300) as port:
            port.sendall(line.encode() + b"\n")
            self.assertEqual(port.makefile().readline().strip(), "ok", line)

    def test_faults(self):
        (self.folder / "emulator.toml").write_text(campaign_files.emulator(4, ports="camera_port = 0\nohc_port = 0\ncontrol_port = 0\n"))
        self.start("emulator", "emulator", self.folder / "emulator.toml", "--calibration", self.folder / "testbed.yaml")
        where = self.until(300, lambda: re.search(r"(http://\S+)(?:.|\n)*tcp://(\S+)[^\n]*\ncommands: ([\d.]+):(\d+)", self.said("emulator")), "the emulator's start")
        self.control = where[3], int(where[4])
        (self.folder / "lab.toml").write_text(LAB.format(root=ROOT, camera=where[1], ohc=where[2], folder=self.folder))
        self.start("lab", "lab", self.folder / "lab.toml", "--set", "run.duration_s=10000", "--out", self.folder / "run")
        self.until(300, lambda: re.search(r"period [1-9]", self.said("lab")), "the naming of everybody")

        def sees_again(times):
            return lambda: self.said("lab").count("the cameras see the testbed again") >= times
        self.command("camera camera0 gone")
        self.until(300, lambda: "the cameras have given no picture" in self.said("lab"), "a camera that is gone")
        self.command("camera camera0 ok")
        self.until(300, sees_again(1), "a camera that is back")
        self.command("camera camera0 frozen")
        self.until(300, lambda: self.said("lab").count("the cameras have given no picture") == 2, "a camera that is frozen")
        self.command("camera camera0 ok")
        self.until(300, sees_again(2), "a camera that is frozen no more")
        self.command("camera camera0 move 0.02 0")
        self.until(300, lambda: "was moved" in self.said("lab"), "a camera that is knocked about")
        self.until(300, sees_again(3), "a calibration that follows")
        self.command("ohc unplug")
        self.until(300, lambda: "the overhead controller is gone" in self.said("lab"), "a controller that is unplugged")
        self.command("ohc plug")
        self.command("ohc garbage 500")
        self.until(300, lambda: self.said("lab").count("the overhead controller listens") == 2, "a controller that is plugged in")
        lab = self.processes.pop("lab")
        lab.send_signal(signal.SIGINT)
        lab.wait(300)
        result = json.loads((self.folder / "run/result.json").read_text())
        for name in ("camera.gone", "camera.frozen", "camera.moved", "camera.realigned", "overhead.port_lost", "poses.lost.no_picture"):
            self.assertGreater(result["counters"].get(f"arena.{name}", 0), 0, f"{name} of {result['counters']}")


if __name__ == "__main__":
    unittest.main()
