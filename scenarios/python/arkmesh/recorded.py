"""Recorded runs as arrays. Trajectories are read from what `arkmesh export --csv` writes, tables from where the run left
them."""
import collections.abc
import csv
import functools
import json
import pathlib

import numpy


def read_table(path):
    """A CSV file with a header as a structured array: a column holds whole numbers, else numbers (nothing is NaN), else texts."""
    with open(path, newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    columns = [_column(name, [row[i] for row in rows]) for i, name in enumerate(names)]
    out = numpy.zeros(len(rows), [(name, column.dtype) for name, column in zip(names, columns)])
    for name, column in zip(names, columns):
        out[name] = column
    return out


def _column(name, cells):
    texts = numpy.array(cells, dtype=str)
    if name == "why" or name.endswith("hash"):  # nothing is no number; hexadecimal digits may look like one
        return texts
    for convert in (lambda: texts.astype(numpy.int64), lambda: numpy.where(texts == "", "nan", texts).astype(float)):
        try:
            return convert()
        except (ValueError, OverflowError):
            pass
    return texts


def _numbers(path):
    """A CSV file of numbers: {name: column}."""
    with open(path, encoding="utf-8") as file:
        names = file.readline().rstrip("\n").split(",")
        data = numpy.loadtxt(file, delimiter=",", ndmin=2).reshape(-1, len(names))
    return {name: data[:, i] for i, name in enumerate(names)}


class Rows(collections.abc.Mapping):
    """A lab's tables by name."""

    def __init__(self, folder):
        self.files = {file.stem: file for file in sorted(folder.glob("*.csv")) if file.stem not in ("hash", "audit")}

    def __getitem__(self, name):
        if name not in self.files:
            raise KeyError(f"this lab wrote no table {name!r}; it has: {', '.join(self.files) or 'none'}")
        return read_table(self.files[name])

    def __iter__(self):
        return iter(self.files)

    def __len__(self):
        return len(self.files)


class LabRun:
    """One lab of a run. Frames are rows, robots columns in the order of `ids`; NaN, and an LED of 0, where a robot was not seen."""

    def __init__(self, run, name, folder):
        self.run, self.name, self.folder = run, name, folder
        self.result = json.loads((folder / "result.json").read_text())
        self.counts, self.rows = self.result.get("counts", {}), Rows(folder)

    t_s = property(lambda self: self._frames["t_s"], doc="lab time of each frame, in seconds")
    ids = property(lambda self: self._frames["ids"], doc="robots that were ever seen")
    xy = property(lambda self: self._frames["xy"], doc="[frame, robot, 2], metres in this lab's arena")
    heading = property(lambda self: self._frames["heading"], doc="[frame, robot], radians from +x counter-clockwise")
    led = property(lambda self: self._frames["led"], doc="[frame, robot]: bit 0 red, bit 1 green, bit 2 blue; 8 unknown")

    @functools.cached_property
    def _frames(self):
        folder = self.run.export() / self.name
        if not (folder / "poses.csv").is_file():
            raise RuntimeError(f"{self.folder} has no recording of frames (recorder.log)")
        frames, robots = _numbers(folder / "poses.csv"), _numbers(folder / "poses.robots.csv")
        # A frame of many robots is several messages.
        numbers, first = numpy.unique(frames["number"], return_index=True)
        row_of_message = numpy.searchsorted(numbers, frames["number"])
        rows = row_of_message[numpy.searchsorted(frames["message"], robots["message"])]
        ids, columns = numpy.unique(robots["robot"].astype(numpy.uint32), return_inverse=True)
        shape = (len(numbers), len(ids))
        out = {"t_s": frames["stamp_us"][first] / 1e6, "ids": ids, "xy": numpy.full((*shape, 2), numpy.nan),
               "heading": numpy.full(shape, numpy.nan), "led": numpy.zeros(shape, numpy.uint8)}
        out["xy"][rows, columns, 0], out["xy"][rows, columns, 1] = robots["x_m"], robots["y_m"]
        out["heading"][rows, columns], out["led"][rows, columns] = robots["heading_rad"], robots["led"]
        return out


class Run:
    """A run's folder. `labs` has each lab; what a lab has, such as `xy` and `rows`, the run has of its first lab. `counts` are
    sums of all labs, with `name@lab` of each."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        if not (self.folder / "result.json").is_file():
            raise FileNotFoundError(f"{self.folder} holds no result.json of a run")
        self.result = json.loads((self.folder / "result.json").read_text())
        self.hash, self.seed = self.result.get("final_hash", ""), self.result["seed"]
        self.counts = self.result.get("counts", {})
        self.state, self.ended = self.result["state"], self.result.get("ended", "")
        alone = self.result.get("lab")
        places = {alone: self.folder} if alone else {name: self.folder / name for name in self.result["labs"]}
        self.labs = {name: LabRun(self, name, place) for name, place in places.items()}
        self._first = next(iter(self.labs.values()))

    def export(self):
        """The folder of the run's tables as CSV, which is written when it is not there."""
        from .running import call
        out = self.folder / "export/csv"
        if self.state == "running" or not out.is_dir():
            call("export", str(self.folder), "--csv", "--force")
        return out

    def __repr__(self):
        return f"<arkmesh.Run {self.folder}: labs {', '.join(self.labs)}, seed {self.seed}, {self.state}, hash {self.hash}>"


for _name in ("t_s", "ids", "xy", "heading", "led", "rows"):
    setattr(Run, _name, property(lambda self, name=_name: getattr(self._first, name), doc=f"labs[first].{_name}"))


class Batch:
    """A batch of seeds. `table` is runs.csv: a row for each seed; `batch["lit"]` is a column, `runs[seed]` its Run."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.table = read_table(self.folder / "runs.csv")
        self.runs = Runs(self.folder, {int(row["seed"]): int(row["run"]) for row in self.table})

    def __getitem__(self, column):
        return self.table[column]

    def __len__(self):
        return len(self.table)

    def __repr__(self):
        return f"<arkmesh.Batch {self.folder}: {len(self)} runs; columns {', '.join(self.table.dtype.names)}>"


class Runs(collections.abc.Mapping):
    """The runs of a batch by seed, each read when it is asked for."""

    def __init__(self, folder, seeds):
        self.folder, self.seeds = folder, seeds

    def __getitem__(self, seed):
        if seed not in self.seeds:
            raise KeyError(f"seed {seed} has no result")
        return Run(self.folder / f"runs/{self.seeds[seed]:05}")

    def __iter__(self):
        return iter(self.seeds)

    def __len__(self):
        return len(self.seeds)


def open_run(folder):
    """The Run of a folder, whoever ran it; a Batch if it is the folder of `arkmesh batch`."""
    folder = pathlib.Path(folder)
    return Batch(folder) if (folder / "runs.csv").is_file() else Run(folder)
