"""A lab on an emulated testbed, both processes of their own, for tests that disturb it."""
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


class EmulatedLab(unittest.TestCase):
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

    def begin(self, camera=lambda url: url):
        """Both, until every robot has a name. `camera` makes the address of the lab's camera from that of the emulator's."""
        (self.folder / "emulator.toml").write_text(campaign_files.emulator(4, more="emulator.camera_port = 0\nemulator.ohc_port = 0\nemulator.control_port = 0\n"))
        self.start("emulator", "emulator", self.folder / "emulator.toml", "--calibration", self.folder / "testbed.yaml")
        where = self.until(300, lambda: re.search(r"(http://\S+)(?:.|\n)*tcp://(\S+)[^\n]*\ncommands: ([\d.]+):(\d+)", self.said("emulator")), "the emulator's start")
        self.control = where[3], int(where[4])
        (self.folder / "lab.toml").write_text(LAB.format(root=ROOT, camera=camera(where[1]), ohc=where[2], folder=self.folder))
        self.start("lab", "lab", self.folder / "lab.toml", "--set", "run.duration_s=10000", "--out", self.folder / "run")
        self.until(300, lambda: re.search(r"period [1-9]", self.said("lab")), "the naming of everybody")

    def end_lab(self):
        """As an operator does. Its exit code, and its result."""
        lab = self.processes.pop("lab")
        lab.send_signal(signal.SIGINT)
        return lab.wait(300), json.loads((self.folder / "run/result.json").read_text())
