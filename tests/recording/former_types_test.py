#!/usr/bin/python3
"""Whether recordings of former versions are read everywhere, and whether the former definitions of all changed messages are kept.

    former_types_test.py ARKMESH LCM_TYPES_FOLDER

Records a short run, and gives its status messages the layout that they had at first: their bytes are made here, from lcmtypes/former/1/lab_status_t.lcm.
"""
import csv
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

import h5py

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "hal/layout")]
import make_types
import read_log

ARKMESH = os.environ.get("ARKMESH") or sys.argv.pop(1)
read_log.TYPES_DIR = pathlib.Path(os.environ.get("ARKMESH_LCM_TYPES") or sys.argv.pop(1))
LABS = ("roark", "shark")
FORMATS = {"int32_t": ">i", "int64_t": ">q", "double": ">d", "boolean": ">b"}


def encode(types, name, value):
    """The fields of a message, of a type without lists of lists."""
    out = b""
    for field in types[name]["fields"]:
        values = getattr(value, field["name"])
        for each in values if field["dims"] else [values]:
            if field["type"] == "string":
                out += struct.pack(">i", len(each.encode()) + 1) + each.encode() + b"\0"
            elif field["type"] in FORMATS:
                out += struct.pack(FORMATS[field["type"]], each)
            else:
                out += encode(types, field["type"], each)
    return out


def make_former(log):
    """Gives the status messages of a log their first layout; returns what they say."""
    types, out, said = make_types.tables(ROOT / "lcmtypes"), b"", []
    for number, (seconds, channel, data) in enumerate(list(read_log.events(log))):
        if channel == "status":
            message = read_log.decode(data)
            said.append((message.state, message.period, [(counter.name, counter.value) for counter in message.counters]))
            data = bytes.fromhex(types["lab_status_t-1"]["fingerprint"]) + encode(types, "lab_status_t-1", message)
        out += struct.pack(">IqqII", read_log.SYNC, number, round(seconds * 1e6), len(channel), len(data)) + channel.encode() + data
    log.write_bytes(out)
    return said


def unpacked(mcap):
    """The file's records with the chunks (opcode 6) unpacked, one behind the other."""
    out, at = b"", 8
    while at < len(mcap) - 8:
        opcode, size = struct.unpack_from("<BQ", mcap, at)
        content = mcap[at + 9:at + 9 + size]
        at += 9 + size
        if opcode == 6:
            name = struct.unpack_from("<I", content, 28)[0]
            content = subprocess.run(["zstd", "-dc"], input=content[32 + name + 8:], stdout=subprocess.PIPE, check=True).stdout
        out += content
    return out


class FormerRun(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.run_folder = cls.folder / "run"
        cls.arkmesh("run", *(ROOT / f"experiments/dhtf/{lab}.toml" for lab in LABS), "--set", "run.duration_s=10", "--out", cls.run_folder)
        cls.said = {lab: make_former(cls.run_folder / lab / "log.lcm") for lab in LABS}
        assert all(said and said[0][2] for said in cls.said.values()), "each lab has told its status and counters"

    @classmethod
    def arkmesh(cls, *words):
        done = subprocess.run([ARKMESH, *map(str, words)], capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done
        assert "left out" not in done.stderr + done.stdout, done
        return done.stdout

    def test_csv(self):
        """Tables have the rows of former messages, without the columns of fields that came later."""
        self.arkmesh("export", self.run_folder, "--csv", "--out", self.folder / "csv")
        for lab in LABS:
            with open(self.folder / "csv" / lab / "status.csv", newline="") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual([(row["state"], int(row["period"])) for row in rows], [said[:2] for said in self.said[lab]])
            self.assertNotIn("phase", rows[0])
            with open(self.folder / "csv" / lab / "status.counters.csv", newline="") as file:
                counters = [(row["name"], int(row["value"])) for row in csv.DictReader(file)]
            self.assertEqual(counters, [counter for said in self.said[lab] for counter in said[2]])

    def test_hdf5(self):
        """The same of HDF5."""
        self.arkmesh("export", self.run_folder, "--hdf5", "--out", self.folder / "run.h5")
        with h5py.File(self.folder / "run.h5") as data:
            for lab in LABS:
                self.assertEqual([text.decode() for text in data[f"{lab}/status"][:]["state"]], [said[0] for said in self.said[lab]])

    def test_mcap(self):
        """MCAP has the former messages, with a schema of their own."""
        self.arkmesh("export", self.run_folder, "--mcap", "--out", self.folder / "run.mcap")
        data = unpacked((self.folder / "run.mcap").read_bytes())
        self.assertIn(b"arkmesh.lab_status_t-1", data)
        for lab in LABS:
            for state, period, _ in self.said[lab]:
                self.assertIn(f'"state":"{state}","stamp_us"'.encode(), data)

    def test_scripts(self):
        """read_log.py decodes them, and says of a field that came later that there is none."""
        for lab in LABS:
            log = self.run_folder / lab / "log.lcm"
            messages = [read_log.decode(data) for _, channel, data in read_log.events(log) if channel == "status"]
            self.assertEqual([(m.state, m.period, [(c.name, c.value) for c in m.counters]) for m in messages], self.said[lab])
            self.assertFalse(hasattr(messages[0], "phase"))
            self.assertTrue(hasattr(read_log.new("lab_status_t"), "phase"), "a new message has the layout of today")
            shown = subprocess.run([ROOT / "scripts/read_log.py", log, "status"], capture_output=True, text=True,
                                   env=os.environ | {"ARKMESH_LCM_TYPES": str(read_log.TYPES_DIR)}, check=True).stdout
            self.assertIn(f"state = {self.said[lab][0][0]}", shown)

    def test_plot_rerun_and_replay(self):
        """The run is drawn, repeated, and its poses drive an arena."""
        picture = self.folder / "picture.png"
        self.arkmesh("plot", self.run_folder, "--out", picture)
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))
        self.arkmesh("rerun", self.run_folder)
        words = ["--set", "arena.use=replay"]
        for lab in LABS:
            words += ["--set", f"{lab}:arena.replay.log={self.run_folder / lab / 'log.lcm'}"]
        self.arkmesh("run", *(ROOT / f"experiments/dhtf/{lab}.toml" for lab in LABS), "--set", "run.duration_s=8", *words, "--out", self.folder / "again")


class KeptDefinitions(unittest.TestCase):
    def check(self, folder):
        done = subprocess.run([sys.executable, ROOT / "hal/layout/make_types.py", "--check", folder], capture_output=True, text=True)
        self.assertEqual(done.returncode == 0, not done.stderr, done)
        return done.stderr

    def test_all_are_kept(self):
        """Each layout that messages have had is known, and those of today are listed."""
        self.assertEqual(self.check(ROOT / "lcmtypes"), "")

    def test_generated_code(self):
        """Former tables have the fingerprints that lcm-gen computes."""
        for name, each in make_types.tables(ROOT / "lcmtypes").items():
            cls = read_log.types()[bytes.fromhex(each["fingerprint"])]
            self.assertEqual(cls.__name__, name.partition("-")[0])
            self.assertEqual(cls.__slots__, [field["name"] for field in each["fields"]])

    def test_a_change(self):
        """A change is refused until the former file is kept and the new layouts are listed; types that hold the changed one need no file."""
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name) / "lcmtypes"
            shutil.copytree(ROOT / "lcmtypes", folder)
            number, before = len(make_types.steps(folder)), make_types.tables(folder)
            counter = folder / "counter_t.lcm"
            former = counter.read_text()
            counter.write_text(former.replace("{", "{\n    int64_t since_us;", 1))
            said = self.check(folder)
            self.assertIn(f"keep the former file as lcmtypes/former/{number}/counter_t.lcm", said)
            new = make_types.tables(folder)["counter_t"]["fingerprint"]
            self.assertIn(f'add the line "counter_t {new}" to lcmtypes/fingerprints.txt', said)
            with open(folder / "fingerprints.txt", "a") as listed:
                listed.writelines(f"{name} {each['fingerprint']}\n" for name, each in make_types.tables(folder).items()
                                  if "-" not in name and each["fingerprint"] != before[name]["fingerprint"])
            said = self.check(folder)
            self.assertIn("keep the former file", said)
            self.assertNotIn("add the line", said)
            (folder / f"former/{number}").mkdir()
            (folder / f"former/{number}/counter_t.lcm").write_text(former)
            self.assertEqual(self.check(folder), "")
            after = make_types.tables(folder)
            self.assertLessEqual({each["fingerprint"] for each in before.values()}, {each["fingerprint"] for each in after.values()})
            self.assertEqual(after[f"peers_t-{number}"]["fingerprint"], before["peers_t"]["fingerprint"])
            kept = {field["name"]: field["type"] for field in after["lab_status_t-1"]["fields"]}
            self.assertEqual(kept["counters"], f"counter_t-{number}", "what a former type held was of its time")
            counter.write_text(former)
            shutil.rmtree(folder / "former/1")
            self.assertIn("no definition has the layout adfdc9df6603f32b of lab_status_t", self.check(folder))


if __name__ == "__main__":
    unittest.main()
