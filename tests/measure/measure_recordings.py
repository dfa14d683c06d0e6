"""Figures of recorded runs: how long it takes to open one, to go to a moment, and to export it. See scripts/measure."""
import contextlib
import functools
import json
import random
import re
import shutil
import struct
import subprocess
import time

from lab_processes import PROGRAM, Failed, end_all
from page_viewers import join


class Viewer:
    """A viewer of a page, on its WebSocket."""

    def __init__(self, port):
        self.socket = join(port)
        self.stream = self.socket.makefile("rb")
        while self.stream.readline() not in (b"\r\n", b""):
            pass

    def say(self, what):
        payload = json.dumps(what).encode()
        length = struct.pack("!B", 0x80 | len(payload)) if len(payload) < 126 else struct.pack("!BH", 0x80 | 126, len(payload))
        self.socket.sendall(b"\x81" + length + b"\0\0\0\0" + payload)

    def next(self):
        """(is text, payload)"""
        head, length = self.stream.read(2)
        length &= 127
        if length > 125:
            length = int.from_bytes(self.stream.read(2 if length == 126 else 8), "big")
        return head & 15 == 1, self.stream.read(length)

    def ask(self, request, what):
        """The recorded messages that answer a request, each with its header."""
        self.say({"request": request, **what})
        messages = []
        while True:
            is_text, payload = self.next()
            if not is_text:
                messages.append(payload)
            elif (done := json.loads(payload)).get("done", {}).get("request") == request:
                return messages
            elif done.get("refused"):
                raise Failed(f"the page refused: {done}")

    def until(self, member):
        while True:
            is_text, payload = self.next()
            if is_text and member in (said := json.loads(payload)):
                return said[member]


@functools.cache
def hour(bench):
    """A recorded hour of 48 + 12 robots."""
    return bench.run(*bench.pair_files, "--seconds", 3600, keep=True)["folder"]


@contextlib.contextmanager
def opened(folder):
    """(seconds from the start of `arkmesh view` to the run's length in a viewer's hands, the viewer)"""
    begin = time.monotonic()
    process = subprocess.Popen([PROGRAM, "view", folder, "--port", "18800"], stderr=subprocess.PIPE, text=True)
    try:
        port = next((found[1] for line in process.stderr if (found := re.search(r"http://127\.0\.0\.1:(\d+)/", line))), None)
        if port is None:
            raise Failed("arkmesh view printed no address")
        viewer = Viewer(int(port))
        if viewer.until("hello")["length_us"] <= 0:
            raise Failed("the run has no length")
        yield time.monotonic() - begin, viewer
    finally:
        end_all([process])


def recording_open(bench):
    """From `arkmesh view` of an hour's run to its length at a viewer: the first time, when the index is made, and later."""
    run = hour(bench)
    took = []
    for index in run.glob("*/log.index"):
        index.unlink()
    for _ in range(2):
        with opened(run) as (seconds, _):
            took.append(seconds)
    return max(took) < 1, f"{took[0]:.2f} s without an index, {took[1]:.2f} s with one", "below 1 s"


def recording_seek(bench):
    """The slowest of 200 jumps to any moment of an hour's run, at a viewer."""
    with opened(hour(bench)) as (_, viewer):
        slowest, length_s = 0.0, 3600
        for n in range(1, 201):
            begin = time.monotonic()
            messages = viewer.ask(n, {"seek": {"t_us": random.randrange(length_s * 1_000_000)}})
            slowest = max(slowest, time.monotonic() - begin)
            if len(messages) < 10:
                raise Failed(f"a jump gave {len(messages)} messages")
    return slowest < 0.1, f"{slowest * 1e3:.1f} ms", "below 100 ms"


def recording_export(bench):
    """1800 s of 60 robots to CSV, HDF5 and MCAP."""
    run = bench.run(*bench.pair_files, "--seconds", 1800, keep=True)["folder"]
    took = {}
    for kind in ("csv", "hdf5", "mcap"):
        begin = time.monotonic()
        bench.say(PROGRAM, "export", run, f"--{kind}")
        took[kind] = time.monotonic() - begin
    shutil.rmtree(run)
    return max(took["csv"], took["hdf5"]) < 2, ", ".join(f"{kind} {s:.2f} s" for kind, s in took.items()), "CSV and HDF5 below 2 s"


MEASURES = [recording_open, recording_seek, recording_export]
NOT_JUDGED_SHORT = set(MEASURES)
