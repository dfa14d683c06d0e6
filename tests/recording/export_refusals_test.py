#!/usr/bin/python3
"""What exports do when something is wrong: a full disk, Ctrl-C, two at once, names that nobody expected. Nothing that looks whole is left.

    export_refusals_test.py ARKMESH

Logs are made here, byte by byte, of messages of a short run.
"""
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import h5py

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ARKMESH = os.environ.get("ARKMESH") or sys.argv.pop(1)
KINDS = ("csv", "hdf5", "mcap")


def export(run, kind, out, *more, **how):
    return subprocess.run([ARKMESH, "export", run, f"--{kind}", "--out", out, *more], capture_output=True, text=True, timeout=600, **how)


def event(channel, utime, data):
    return struct.pack(">IqqII", 0xEDA1DA01, 0, utime, len(channel), len(data)) + channel + data


def events(log):
    at = 0
    while at + 28 <= len(log):
        utime, channel, data = struct.unpack(">12xqII", log[at:at + 28])
        yield log[at + 28:at + 28 + channel], utime, log[at + 28 + channel:at + 28 + channel + data]
        at += 28 + channel + data


class Refusals(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.scratch = pathlib.Path(scratch.name)
        cls.run_folder = cls.scratch / "run"
        subprocess.run([ARKMESH, "run", ROOT / "experiments/dhtf/shark.toml", "--set", "run.duration_s=10", "--out", cls.run_folder], check=True, capture_output=True)
        cls.log = (cls.run_folder / "shark/log.lcm").read_bytes()

    def test_film_without_its_programs(self):
        """What a film needs and this machine lacks is named, with the way to get it."""
        said = export(self.run_folder, "mp4", self.scratch / "film.mp4", env={**os.environ, "PATH": "/nonexistent"})
        self.assertEqual(said.returncode, 1, said)
        self.assertIn("film: this machine lacks ffmpeg", said.stderr)
        self.assertNotIn("Traceback", said.stderr)

    def test_the_length_of_trails(self):
        """It goes to what draws the film, here a stand-in of an installation; what has no trails refuses it."""
        programs, share = self.scratch / "installed/bin", self.scratch / "installed/share/arkmesh"
        for folder in (programs, share):
            folder.mkdir(parents=True)
        for name in ("arkmesh", "arkmesh-recording"):
            shutil.copy(pathlib.Path(ARKMESH).with_name(name), programs)
        (share / "film").write_text("#!/bin/sh\necho $3: drawn with $6 $7\n")
        (share / "film").chmod(0o755)
        film = [programs / "arkmesh", "export", self.run_folder, "--mp4", "--out", self.scratch / "trails.mp4"]
        for trails, drawn in ((["--trails", "2.5"], "--trails 2.5"), ([], "")):
            done = subprocess.run([*film, *trails], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout.strip()), (0, f"wrote {film[-1]}: drawn with {drawn}".strip()), done.stderr)
        self.assertIn("--trails: Value -1 not in range", subprocess.run([*film, "--trails", "-1"], capture_output=True, text=True).stderr)
        self.assertEqual(export(self.run_folder, "csv", self.scratch / "none", "--trails", "5").stderr, "arkmesh: --trails requires --mp4 (see arkmesh export --help)\n")

    def copy(self, name, log=None):
        folder = self.scratch / name
        shutil.copytree(self.run_folder, folder)
        (folder / "shark/log.index").unlink(missing_ok=True)
        if log is not None:
            (folder / "shark/log.lcm").write_bytes(log)
        return folder

    def long_run(self, name, times):
        """A run with the same messages again and again, so that an export of it takes a while."""
        poses = b"".join(event(channel, utime, data) for channel, utime, data in events(self.log) if channel == b"poses")
        return self.copy(name, self.log + poses * times)

    def test_a_full_disk_leaves_nothing(self):
        """Every export says so in one sentence and ends with exit code 1; no file is left, and no folder that keeps the next one from beginning."""
        disk = self.scratch / "disk"
        disk.mkdir()
        for kind in KINDS:
            commands = f"mount -t tmpfs -o size=24k none {disk} && {ARKMESH} export {self.run_folder} --{kind} --out {disk}/out; echo code $?; find {disk} -mindepth 1"
            said = subprocess.run(["unshare", "-m", "sh", "-c", commands], capture_output=True, text=True, timeout=600)
            self.assertEqual(said.stdout, "code 1\n", said.stderr)
            self.assertIn("No space left on device", said.stderr)
            self.assertEqual(said.stderr.count("\n"), 1, said.stderr)

    @unittest.skipUnless(os.path.exists("/usr/bin/chromedriver"), "there is no Chromium here")
    def test_a_film_on_a_full_disk(self):
        """ffmpeg may end with 0 when it could not write the end of a film."""
        disk = self.scratch / "film_disk"
        disk.mkdir()
        commands = f"mount -t tmpfs -o size=8k none {disk} && {ARKMESH} export {self.run_folder} --mp4 --out {disk}/out.mp4; echo code $?; find {disk} -mindepth 1"
        said = subprocess.run(["unshare", "-m", "sh", "-c", commands], capture_output=True, text=True, timeout=600)
        self.assertEqual(said.stdout, "code 1\n", said.stderr)
        self.assertIn("out.mp4 cannot be written: ", said.stderr)

    def test_ctrl_c_leaves_nothing(self):
        """Exit code 3, a sentence, and the folder as it was."""
        run = self.long_run("long", 400)
        for kind in KINDS:
            out = self.scratch / f"stopped-{kind}" / "out"
            out.parent.mkdir()
            with subprocess.Popen([ARKMESH, "export", run, f"--{kind}", "--out", out], stderr=subprocess.PIPE, text=True) as process:
                end = time.monotonic() + 300
                while not list(out.parent.rglob("*.part")) and time.monotonic() < end:
                    time.sleep(0.005)
                process.send_signal(signal.SIGINT)
                said = process.communicate(timeout=600)[1]
            self.assertEqual(process.returncode, 3, said)
            self.assertIn("stopped; nothing was written", said)
            self.assertEqual(list(out.parent.iterdir()), [])

    def test_two_at_once_are_both_whole(self):
        """The later one wins, and what is there is whole."""
        run = self.long_run("twice", 40)
        for kind in KINDS:
            out = self.scratch / f"both-{kind}"
            alone = self.scratch / f"alone-{kind}"
            both = [subprocess.Popen([ARKMESH, "export", run, f"--{kind}", "--out", out, "--force"], stdout=subprocess.DEVNULL) for _ in range(2)]
            self.assertEqual([process.wait(300) for process in both], [0, 0])
            self.assertEqual(export(run, kind, alone).returncode, 0)
            if kind == "hdf5":
                with h5py.File(out) as a, h5py.File(alone) as b:
                    self.assertTrue((a["shark/poses.robots"][:] == b["shark/poses.robots"][:]).all())
            else:
                self.assertEqual(subprocess.run(["diff", "-r", out, alone]).returncode, 0)

    def test_any_names_are_exported(self):
        """Channels and tables with names that are none, long, the same, or of what is there already, in every format."""
        some = {channel: (utime, data) for channel, utime, data in events(self.log)}
        utime, poses = some[b"poses"]
        channels = [b"../../evil", b"/etc/x", b"a\0b", b"=cmd|' /C calc'!A0", b"\xff\xfe", b"", b"..", b"x" * 255, b"y/" * 100, b"poses/robots", b"poses.robots",
                    b"tables", b"config.toml", b"scene"]
        log = b"".join(event(channel, utime, poses) for channel in channels) + self.log
        run = self.copy("names", log)
        (run / "shark/a b.csv").write_text("a,a,,b\n1,2,3,4\n")
        (run / "shark/a_b.csv").write_text("name\n" + "long " * 9 + "\n")
        for kind in KINDS:
            done = export(run, kind, self.scratch / f"names-{kind}")
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertFalse((self.scratch / "evil").exists())
        with h5py.File(self.scratch / "names-hdf5") as data:
            frames = len([channel for channel, _, _ in events(self.log) if channel == b"poses"])
            self.assertEqual(len(data["shark/poses"]), frames, "a lab's own channel has its own name")
            self.assertEqual(data["shark/tables/a_b"].dtype.names, ("a", "a_2", "column", "b"))
            self.assertEqual(data["shark/tables/a_b_2"][0]["name"], b"long " * 9)

    def test_what_lies_about_is_not_read(self):
        """Pipes and endless files in the place of a result, a configuration and a table do not hold an export up."""
        run = self.copy("pipes")
        for name in ("result.json", "config.toml", "more.csv"):
            (run / "shark" / name).unlink(missing_ok=True)
            os.mkfifo(run / "shark" / name)
        self.assertEqual(export(run, "hdf5", self.scratch / "pipes.h5").returncode, 0)

    def test_two_folders_of_one_lab(self):
        """Runs of the same lab that lie side by side are told apart by their folders."""
        run = self.copy("side_by_side")
        shutil.copytree(run / "shark", run / "tuesday")
        done = export(run, "hdf5", self.scratch / "side_by_side.h5")
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(self.scratch / "side_by_side.h5") as data:
            self.assertEqual(sorted(data), ["shark", "tuesday"])

    def test_places_that_are_none(self):
        """A folder where a file belongs, and a file where a folder does, are refused in words."""
        place = self.scratch / "place"
        place.mkdir()
        done = export(self.run_folder, "hdf5", place)
        self.assertEqual((done.returncode, f"name the file, as {place}/run.h5" in done.stderr), (2, True), done.stderr)
        (place / "file").touch()
        done = export(self.run_folder, "csv", place / "file/csv")
        self.assertEqual((done.returncode, "Not a directory" in done.stderr), (1, True), done.stderr)


if __name__ == "__main__":
    unittest.main()
