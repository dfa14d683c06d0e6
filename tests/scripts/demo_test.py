"""The demo: what it does when something goes wrong, with a stand-in for the program."""
import argparse
import contextlib
import io
import json
import os
import pathlib
import signal
import stat
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

import run_folder  # noqa: F401  (makes the scripts importable)
import demo_run
import joined_networks
from lab_processes import PROGRAM, ROOT, Failed

# Behaves as `arkmesh lab FILE --out DIR` and `arkmesh gateway FILE` do; `run.seed` says which misfortune happens.
STAND_IN = """#!/usr/bin/python3
import json, pathlib, sys, time
sys.path.insert(0, {tests!r})
import run_folder
what, file = sys.argv[1], pathlib.Path(sys.argv[2])
seed = next(int(a[9:]) for a in sys.argv if a.startswith("run.seed="))
lab = file.stem
pathlib.Path({pids!r}, f"{{what}}-{{lab}}").write_text("")
if what == "gateway":
    if seed == 3:
        sys.exit("arkmesh: gateway.listen: the port is taken")
    time.sleep(600)
print(f"see it at http://127.0.0.1:8800/#token={{lab}}", file=sys.stderr)
print(f"{{lab}}  period 1/4  25.0 %  10x  eta 3 s", file=sys.stderr)
if seed == 2 and lab == "roark":
    sys.exit("arkmesh: lab roark ended early: shark is gone at period 1")
if seed == 5:
    time.sleep(600)
if seed == 6:
    while not pathlib.Path({pids!r}, "go-on").exists():
        time.sleep(0.05)
out = pathlib.Path(sys.argv[sys.argv.index("--out") + 1])
run_folder.make_lab(out, lab)
(out / "hash.csv").write_text("period,hash\\n0,00\\n1,0a\\n")
wall = dict(total_s=1, computing_s=0.5, waiting_s=0.5, per_period_ms=dict(computing=1, waiting=1), speed=300)
final = "b" * 16 if seed == 4 and lab == "roark" else "a" * 16
other = "shark" if lab == "roark" else "roark"
(out / "result.json").write_text(json.dumps(dict(arkmesh="0", versions=dict(), labs=["roark", "shark"], scenario="dhtf", seed=seed, gate="strict",
    ended="finished", periods=4, duration_s=8, final_hash=final, hash_by_lab=dict(), counts=dict(completed=7), drops=dict(x=2), counters=dict(x=2),
    wall=wall, between_labs={{other: dict(received_messages=5, received_bytes=1234)}})))
"""


class Demo(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)
        self.program = self.folder / "arkmesh"
        self.program.write_text(STAND_IN.format(tests=str(pathlib.Path(__file__).parent), pids=str(self.folder)))
        self.program.chmod(self.program.stat().st_mode | stat.S_IXUSR)

    def demo(self, seed):
        with contextlib.redirect_stdout(io.StringIO()) as self.said, contextlib.redirect_stderr(io.StringIO()):
            demo_run.run(argparse.Namespace(seconds=8, seed=seed, out=self.folder / f"run{seed}", emulated=False, remote=False, federation=False), program=self.program)
        return self.folder / f"run{seed}"

    def left(self):
        """Processes of the stand-in that still run."""
        found = []
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                words = (process / "cmdline").read_bytes().split(b"\0")
            except OSError:  # ended meanwhile
                continue
            found += [process.name for word in words[:2] if word == os.fsencode(self.program)]
        return found

    def test_joins_results(self):
        """Both labs' results are joined, hashes stand side by side, the picture is there, and no process is left."""
        run = self.demo(seed=1)
        joint = json.loads((run / "result.json").read_text())
        self.assertEqual((joint["final_hash"], joint["drops"]), ("a" * 16, {"roark.x": 2, "shark.x": 2}))
        self.assertEqual((run / "hash.csv").read_text(), "period,roark,shark\n0,00,00\n1,0a,0a\n")
        self.assertTrue((run / "picture.png").is_file())
        self.assertEqual(self.left(), [])

    def test_names_pages_that_are_there(self):
        """Of labs that are done at once no page is named, which would be gone, but how to see the run again; of labs that go on their pages."""
        with unittest.mock.patch.object(time, "monotonic", lambda: 0.0):  # at once, however slow the machine
            run = self.demo(seed=1)
        self.assertNotIn("http://", self.said.getvalue())
        self.assertIn(f"arkmesh view {run}\n", self.said.getvalue())
        goes_on = threading.Thread(target=self.until, args=(lambda: "roark at http" in self.said.getvalue() and ((self.folder / "go-on").touch(), True)[1],))
        goes_on.start()
        self.demo(seed=6)
        goes_on.join()
        for lab in ("roark", "shark"):
            self.assertIn(f"demo: see {lab} at http://127.0.0.1:8800/#token={lab}\n", self.said.getvalue())

    def test_failures_are_said(self):
        """A lab that ends early, a gateway that ends, and labs that disagree: one sentence each, and no process is left."""
        for seed, words in ((2, "The lab process of roark ended with code 1: arkmesh: lab roark ended early: shark is gone"),
                            (3, "ended with code 1: arkmesh: gateway.listen: the port is taken"), (4, "do not agree on the final hash")):
            with self.subTest(seed=seed):
                with self.assertRaisesRegex(Failed, words):
                    self.demo(seed)
                self.assertEqual(self.left(), [])

    def test_interrupt_leaves_nothing(self):
        """After Ctrl-C, and after a SIGKILL of the demo itself, no lab or gateway is left."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            with self.subTest(signal=number):
                code = (f"import sys; sys.path.insert(0, {str(ROOT / 'scripts')!r}); import demo_run, argparse, pathlib; demo_run.run(argparse.Namespace("
                        f"seconds=8, seed=5, out=pathlib.Path({str(self.folder / str(int(number)))!r}), emulated=False, remote=False, federation=False), program=pathlib.Path({str(self.program)!r}))")
                for flag in self.folder.glob("*-*"):
                    flag.unlink()
                # A shell's background job, as tests may be, ignores SIGINT; the demo under test shall not.
                demo = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
                self.addCleanup(demo.kill)
                self.until(lambda: len(list(self.folder.glob("*-*"))) == 4)
                demo.send_signal(number)
                demo.wait(300)
                self.until(lambda: not self.left())

    def test_remote_labs_have_the_hash_of_local_ones(self):
        """Two labs in networks of their own, joined over TLS, play strict DHTF as in one process; neither network is left."""
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            demo_run.run(argparse.Namespace(seconds=40, seed=1, out=self.folder / "remote", emulated=False, remote=True, federation=False))
        joint = json.loads((self.folder / "remote/result.json").read_text())
        self.assertEqual(joint["final_hash"], self.local_hash())
        self.assertIn("gateway of shark: listening on tls://", (self.folder / "remote/shark-gateway.txt").read_text())
        self.assertGreater(joint["by_lab"]["shark"]["between_labs"]["roark"]["received_messages"], 15)

    def test_labs_behind_routers_have_the_hash_of_local_ones(self):
        """Two labs behind routers, which meet at a server outside, play strict DHTF as in one process; neither listens, and nothing leads from one to the other."""
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            demo_run.run(argparse.Namespace(seconds=40, seed=1, out=self.folder / "away", emulated=False, remote=False, federation=True))
        joint = json.loads((self.folder / "away/result.json").read_text())
        self.assertEqual(joint["final_hash"], self.local_hash())
        self.assertNotIn("listening", (self.folder / "away/shark-gateway.txt").read_text())
        self.assertGreater(joint["by_lab"]["shark"]["between_labs"]["roark"]["received_messages"], 15)

    def test_routers_let_nobody_in(self):
        """Of two labs behind routers each reaches the server, and nobody reaches a lab, though it listens."""
        door = "import socket; door = socket.create_server(('0.0.0.0', 9)); print(flush=True); import time; time.sleep(600)"
        knock = "import socket; socket.create_connection(('{}', 9), {})"
        with joined_networks.networks_behind_routers(["a", "b"]) as (enter, hall), contextlib.ExitStack() as ending:
            for words in (hall, *enter.values()):
                listener = ending.enter_context(subprocess.Popen([*words, sys.executable, "-c", door], stdout=subprocess.PIPE))
                ending.callback(listener.kill)
                listener.stdout.readline()

            def reaches(words, address, patience_s=60):
                return subprocess.run([*words, sys.executable, "-c", knock.format(address, patience_s)], stderr=subprocess.DEVNULL).returncode == 0
            for number, lab in enumerate("ab", 1):
                self.assertTrue(reaches(enter[lab], "192.168.1.2"), lab)  # itself
                self.assertTrue(reaches(enter[lab], joined_networks.HALL), lab)
                subprocess.run([*hall, "ip", "route", "replace", "192.168.1.0/24", "via", f"10.78.{number}.2"], check=True)
                self.assertFalse(reaches(hall, "192.168.1.2", 1.5), lab)

    def local_hash(self):
        subprocess.run([PROGRAM, "run", *demo_run.LABS, "--out", self.folder / "local", "--set", "run.duration_s=40"], check=True, capture_output=True)
        return json.loads((self.folder / "local/result.json").read_text())["final_hash"]

    def until(self, condition):
        end = time.monotonic() + 300
        while not condition():
            self.assertLess(time.monotonic(), end, "the deadline has passed")
            time.sleep(0.02)


if __name__ == "__main__":
    unittest.main()
