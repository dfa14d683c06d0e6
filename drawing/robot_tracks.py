"""Robots' tracks: of a recorded run, or of a table that `arkmesh fit robots LAB.toml` or `arkmesh track --csv` writes. As arrays, for robot_fit.py."""
import csv
import pathlib
import tomllib

import numpy

import read_log
from figure_style import LED_NAMES, Refused

COLUMNS = ["time_s", "robot", "x_m", "y_m", "direction_rad", "led"]


def of_rows(rows):
    """{robot: track} of rows in the order of COLUMNS."""
    rows = numpy.array(rows, float).reshape(-1, len(COLUMNS))
    rows = rows[numpy.isfinite(rows[:, :4]).all(1)]
    out = {}
    for robot in numpy.unique(rows[:, 1]):
        mine = rows[rows[:, 1] == robot]
        mine = mine[numpy.unique(mine[:, 0], return_index=True)[1]]
        out[int(robot)] = {"t": mine[:, 0], "z": mine[:, 2] + 1j * mine[:, 3], "direction": mine[:, 4], "led": mine[:, 5].astype(int)}
    return out


def of_table(file):
    """Tracks, the arena's sides, and whose directions there are, "led" or "body"; the table's first line tells them."""
    try:
        with open(file, newline="") as text:
            if text.readline().startswith("frame,time_s,track,"):
                text.seek(0)
                seen = [row for row in csv.DictReader(text) if float(row["age_s"]) == 0 and row["doubtful"] == "0"]
                rows = [(row["time_s"], row["track"], row["x_m"], row["y_m"], row["heading_rad"] if float(row["heading_sigma_rad"]) < 0.5 else "nan", LED_NAMES.index(row["led"])) for row in seen]
                return of_rows(rows), 0.0, 0.0, "body"
            text.seek(0)
            width_m, height_m, what = text.readline().removeprefix("#").split()
            header, *rows = csv.reader(text)
            if header != COLUMNS:
                raise ValueError
            return of_rows([[float(cell) for cell in row] for row in rows if len(row) == len(COLUMNS)]), float(width_m), float(height_m), what
    except (KeyError, TypeError, ValueError):
        raise Refused(f"{file} is not a table of tracks; give one written by arkmesh fit robots or arkmesh track --csv, or a run's folder") from None
    except OSError as why:
        raise Refused(f"{file} cannot be read: {why.strerror}") from None


def folder_of(run, lab):
    """Of the lab's log in a run."""
    folders = [folder for folder in [run, *sorted(path for path in run.iterdir() if path.is_dir())] if read_log.log_in(folder).is_file()]
    if lab:
        folders = [folder for folder in folders if folder.name == lab]
    if len(folders) != 1:
        names = ", ".join(folder.name for folder in folders)
        raise Refused(f"{run} holds recordings of several labs: choose one with --lab: {names}" if folders else
                      f"{run} holds no recording of {f'the lab {lab}' if lab else 'a lab'}; give the folder of a recorded run")
    return folders[0]


def read(source, lab=None):
    """(tracks, width_m, height_m, what directions are: "led", "body", or headings that assume this bearing of each LED, in degrees)"""
    source = pathlib.Path(source)
    if not source.is_dir():
        return of_table(source)
    rows, width_m, height_m, folder = [], 0.0, 0.0, folder_of(source, lab)
    arena = tomllib.loads((folder / "config.toml").read_text())["arena"] if (folder / "config.toml").is_file() else {}
    kilobot, cameras = arena.get("kilobot", {}), arena.get("use") in ("kilobot", "emulated")
    for _, channel, data in read_log.events(read_log.log_in(folder)):
        message = read_log.decode(data) if channel in ("poses", "arena") else None
        if message and channel == "arena":
            width_m, height_m = message.width_m, message.height_m
        elif message and message.robots:
            fresh = min(robot.age_us for robot in message.robots) + 50_000  # a camera's latency ages all; who is older was out of sight
            rows += [(message.stamp_us / 1e6, robot.robot, robot.x_m, robot.y_m, robot.heading_rad, robot.led) for robot in message.robots if robot.age_us <= fresh]
    if not rows:
        raise Refused(f"{source} holds no positions of robots; give the folder of a run that recorded its log")
    return of_rows(rows), width_m, height_m, -kilobot.get("led_offset_deg", 44.0) if cameras and not kilobot.get("robots_file") else "body"
