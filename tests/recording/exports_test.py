#!/usr/bin/python3
"""Whether CSV, HDF5 and MCAP exports of a run have the values of its logs, as scripts/read_log.py reads them.

    exports_test.py ARKMESH LCM_TYPES_FOLDER

Makes a short run, exports it in every way, and reads all back with other programs: csv, h5py, and MCAP's reference reader in node.
"""
import base64
import csv
import hashlib
import json
import math
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

import h5py
import numpy
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import read_log

ARKMESH = sys.argv[1]
read_log.TYPES_DIR = pathlib.Path(sys.argv[2])
LABS = ("roark", "shark")


def plain(value):
    """A decoded message as lists and dicts; bytes as lists of numbers, single precision as it is."""
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    return value


def same(a, b):
    """Equal; numbers of single precision, which one side may have rounded to their shortest decimal form, as such."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, float) and not isinstance(b, str):
        return a == b or (math.isnan(a) and b is None) or struct.pack("f", a) == struct.pack("f", b)
    return a == b


def messages(lab_folder):
    """{channel: [decoded message, ...]} of a log."""
    out = {}
    for _, channel, data in read_log.events(read_log.log_in(lab_folder)):
        message = read_log.decode(data)
        assert message is not None, channel
        out.setdefault(channel, []).append(plain(message))
    return out


def expected_robots(log):
    return [(number, robot) for number, frame in enumerate(log["poses"]) for robot in frame["robots"]]


def check_table(rows, expected, names, where):
    """Rows of a table, as dicts of numbers, against (message, record) pairs."""
    assert len(rows) == len(expected), f"{where}: {len(rows)} rows, and the log has {len(expected)}"
    for row, (number, record) in zip(rows, expected):
        assert int(row["message"]) == number, where
        for name in names:
            assert same(record[name], type(record[name])(row[name])), f"{where}: {name} is {row[name]}, and in the log {record[name]}"


def check_csv(folder, logs):
    for lab in LABS:
        log = logs[lab]
        with open(folder / lab / "poses.robots.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        check_table(rows, expected_robots(log), ("robot", "x_m", "y_m", "heading_rad", "led", "confidence", "age_us"), f"{lab} poses.robots.csv")
        for row in rows:
            assert float(row["time_s"]) == log["poses"][int(row["message"])]["stamp_us"] / 1e6, "the time of a frame is its stamp"
        with open(folder / lab / "to_robots.messages.csv", newline="") as file:
            expected = [(n, each) for n, message in enumerate(log["to_robots"]) for each in message["messages"]]
            check_table(list(csv.DictReader(file)), expected, ("robot", "slot", "kind", "value"), f"{lab} to_robots.messages.csv")
        with open(folder / lab / "shared.labs.fields.values.csv", newline="") as file:
            values = [(row["lab"], row["name"], int(row["values"])) for row in csv.DictReader(file)]
        assert values == [(view["lab"], field["name"], value) for shared in log["shared"] for view in shared["labs"] for field in view["fields"]
                          for value in field["values"]]
        other = next(name for name in LABS if name != lab)
        with open(folder / lab / other / "world.csv", newline="") as file:
            assert [int(row["nonce"]) for row in csv.DictReader(file)] == [world["nonce"] for world in log[f"{other}/world"]]
        with open(folder / lab / "tables/hash.csv", newline="") as ours, open(folder.parent / "run" / lab / "hash.csv", newline="") as theirs:
            assert list(csv.reader(ours)) == list(csv.reader(theirs))


def check_hdf5(file, logs):
    with h5py.File(file) as data:
        for lab in LABS:
            table = data[f"{lab}/poses.robots"]
            units = dict(zip([c.decode() for c in table.attrs["columns"]], [u.decode() for u in table.attrs["units"]]))
            assert units["x_m"] == "m" and units["heading_rad"] == "rad" and units["time_s"] == "s" and units["led"] == ""
            rows = table[:]
            expected = expected_robots(logs[lab])
            assert len(rows) == len(expected)
            for name in ("robot", "x_m", "y_m", "heading_rad", "led", "confidence", "age_us"):
                assert numpy.array_equal(rows[name], numpy.array([robot[name] for _, robot in expected]).astype(rows.dtype[name])), f"{lab}: {name}"
            assert numpy.array_equal(rows["time_s"], [logs[lab]["poses"][n]["stamp_us"] / 1e6 for n, _ in expected])
            status = data[f"{lab}/status"][:]
            assert [text.decode() for text in status["state"]] == [each["state"] for each in logs[lab]["status"]]
            values = data[f"{lab}/world.window.fields.values"][:]
            assert list(values["values"]) == [value for world in logs[lab]["world"] for state in world["window"] for field in state["fields"]
                                              for value in field["values"]]
            config = data[f"{lab}/config.toml"][()].decode()
            assert config == (file.parent / "run" / lab / "config.toml").read_text()
            with open(file.parent / "run" / lab / "hash.csv", newline="") as theirs:
                assert [row["hash"].decode() for row in data[f"{lab}/tables/hash"][:]] == [row["hash"] for row in csv.DictReader(theirs)]


def message_type(channel):
    """Of a channel's messages, by nothing but the file's own schema."""
    assert channel["encoding"] == channel["schema_encoding"] == "protobuf"
    pool, files = descriptor_pool.DescriptorPool(), descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(channel["descriptors"]))
    for each in files.file:
        pool.Add(each)
    return message_factory.MessageFactory(pool).GetPrototype(pool.FindMessageTypeByName(channel["schema"]))


def fields_of(message):
    def one(field, value):
        return fields_of(value) if field.message_type else list(value) if isinstance(value, bytes) else value
    return {field.name: [one(field, each) for each in getattr(message, field.name)] if field.label == field.LABEL_REPEATED else one(field, getattr(message, field.name))
            for field in message.DESCRIPTOR.fields}


def check_robots(clouds, frames):
    """Points are where robots are, to 0.01 mm and degrees."""
    formats = {1: "u1", 3: "<u2", 7: "<f4"}  # of PackedElementField
    assert len(clouds) == len(frames)
    for cloud, frame in zip(clouds, frames):
        layout = numpy.dtype({"names": [f.name for f in cloud.fields], "formats": [formats[f.type] for f in cloud.fields],
                              "offsets": [f.offset for f in cloud.fields], "itemsize": cloud.point_stride})
        robots = numpy.frombuffer(cloud.data, layout)
        assert list(robots["robot"]) == [robot["robot"] for robot in frame["robots"]]
        assert list(robots["led"]) == [robot["led"] for robot in frame["robots"]]
        for name, key in (("x", "x_m"), ("y", "y_m"), ("heading", "heading_rad")):
            assert numpy.abs(robots[name] - [robot[key] for robot in frame["robots"]]).max() < (1e-5 if key != "heading_rad" else 2e-4)


def check_mcap(file, logs, scratch):
    reader = pathlib.Path(__file__).resolve().parent / "mcap_reader"
    modules = {"mcap-core": "@mcap/core", "foxglove-crc": "@foxglove/crc", "heap-js": "heap-js", "tslib": "tslib"}
    for line in (reader / "SHA256SUMS").read_text().splitlines():
        digest, name = line.split()
        assert hashlib.sha256((reader / name).read_bytes()).hexdigest() == digest, f"{name} is not the archive of SHA256SUMS"
        place = scratch / "node_modules" / next(module for stem, module in modules.items() if name.startswith(stem))
        place.mkdir(parents=True)
        subprocess.run(["tar", "xzf", reader / name, "-C", place, "--strip-components=1"], check=True)
    shutil.copy(reader / "read.mjs", scratch)
    said = subprocess.run(["node", scratch / "read.mjs", file], check=True, capture_output=True, text=True).stdout.splitlines()
    about = json.loads(said[0])
    channels = {channel["topic"]: channel for channel in about["channels"]}
    types = {topic: message_type(channel) for topic, channel in channels.items()}
    got = {}
    for line in said[1:]:
        topic, time_ns, data = line.split(" ", 2)
        got.setdefault(topic, []).append((int(time_ns), types[topic].FromString(base64.b64decode(data))))
    assert about["messages"] == len(said) - 1
    assert about["compressions"] == ["zstd"]
    for lab in LABS:
        for channel, expected in logs[lab].items():
            topic = f"/{lab}/{channel}"
            if channel == "poses":
                check_robots([cloud for _, cloud in got[f"/{lab}/robots"]], expected)
                continue
            assert len(got[topic]) == len(expected), topic
            for (_, message), original in zip(got[topic], expected):
                assert same(original, fields_of(message)), f"{topic}: {message} is not {original}"
        assert f"/{lab}/poses" not in channels
        assert channels[f"/{lab}/scene"]["schema"] == "foxglove.SceneUpdate"
        assert {entity.frame_id for _, scene in got[f"/{lab}/scene"] for entity in scene.entities} == {lab}
        assert [len(poses.poses) for _, poses in got[f"/{lab}/headings"]][0] == len(logs[lab]["poses"][0]["robots"])
        (_, frames), = got[f"/{lab}/frames"]
        assert (frames.transforms[0].parent_frame_id, frames.transforms[0].child_frame_id) == ("world", lab)
    times = [int(line.split(" ", 2)[1]) for line in said[1:]]
    assert times == sorted(times), "messages come in the order of their times"


def main():
    with tempfile.TemporaryDirectory() as name:
        scratch = pathlib.Path(name)
        run = scratch / "run"
        files = [ROOT / f"experiments/dhtf/{lab}.toml" for lab in LABS]
        subprocess.run([ARKMESH, "run", *files, "--set", "run.duration_s=20", "--set", "shark:recorder.compress=true", "--out", run], check=True, capture_output=True)
        before = {lab: read_log.log_in(run / lab).read_bytes() for lab in LABS}
        assert not (run / "shark/log.lcm").exists(), "shark's recording is compressed"
        for kind, out in (("--csv", "csv"), ("--hdf5", "run.h5"), ("--mcap", "run.mcap")):
            subprocess.run([ARKMESH, "export", run, kind, "--out", scratch / out], check=True)
        assert before == {lab: read_log.log_in(run / lab).read_bytes() for lab in LABS}, "an export leaves the log as it was"
        again = subprocess.run([ARKMESH, "export", run, "--hdf5", "--out", scratch / "run.h5"], capture_output=True, text=True)
        assert again.returncode == 2 and " exists; " in again.stderr, again
        assert (run / "shark/log.index").is_file()
        logs = {lab: messages(run / lab) for lab in LABS}
        check_csv(scratch / "csv", logs)
        check_hdf5(scratch / "run.h5", logs)
        check_mcap(scratch / "run.mcap", logs, scratch)
    print("exports agree with the log")


if __name__ == "__main__":
    main()
