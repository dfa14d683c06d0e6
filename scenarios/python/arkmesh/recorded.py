"""Recorded runs as arrays, tables and figures. Figures need matplotlib; the libraries of other methods are named where they are missing."""
from __future__ import annotations

import collections.abc
import contextlib
import functools
import importlib
import json
import pathlib
import struct
import sys
from typing import Any, Iterator, Optional

import numpy
from numpy.typing import NDArray

from .session import call
from .tables import PathLike, read_table


# pose_frame_t of lcmtypes, as LCM packs it: fingerprint, stamp_us, number, part, parts, n_objects, n_robots; objects; robots.
FRAME, OBJECT_BYTES = struct.Struct(">Qqiiiii"), 32
ROBOT = numpy.dtype([("id", ">i4"), ("xy", ">f8", 2), ("heading", ">f8"), ("led", "u1"), ("confidence", ">f4"), ("age_us", ">i4")])
FRAME_FINGERPRINT = 0x8C40788702DFF821


def tool(name):
    """A module of those that draw and read runs, which lie beside this package where it is installed, and in the checkout."""
    python = pathlib.Path(__file__).resolve().parents[1]
    for folder in (python.parent, python.parents[1] / "drawing", python.parents[1] / "scripts"):
        if any((folder / file).is_file() for file in ("figure_style.py", "read_log.py")) and str(folder) not in sys.path:
            sys.path.append(str(folder))
    return importlib.import_module(name)


def _frames_of(log):
    """{"t_s", "ids", "xy", "heading", "led"} of a recording: frames are rows, robots columns."""
    numbers, stamps_us, robots = [], [], []
    for _, channel, data in tool("read_log").events(log):
        if channel == "poses":
            fingerprint, stamp_us, number, _, _, objects, count = FRAME.unpack_from(data)
            if fingerprint != FRAME_FINGERPRINT:
                raise RuntimeError(f"{log} was recorded by another version of arkmesh; read it with that version")
            numbers.append(number)
            stamps_us.append(stamp_us)
            robots.append(numpy.frombuffer(data, ROBOT, count, FRAME.size + OBJECT_BYTES * objects))
    # A frame of many robots is several messages.
    frames, first, row_of = numpy.unique(numpy.array(numbers, int), return_index=True, return_inverse=True)
    rows = numpy.repeat(row_of, [len(part) for part in robots])
    robots = numpy.concatenate(robots) if robots else numpy.zeros(0, ROBOT)
    ids, columns = numpy.unique(robots["id"].astype(numpy.uint32), return_inverse=True)
    shape = (len(frames), len(ids))
    out = {"t_s": numpy.array(stamps_us, float)[first] / 1e6, "ids": ids, "xy": numpy.full((*shape, 2), numpy.nan),
           "heading": numpy.full(shape, numpy.nan), "led": numpy.full(shape, 8, numpy.uint8)}
    for name in ("xy", "heading", "led"):
        out[name][rows, columns] = robots[name]
    return out


class Rows(collections.abc.Mapping):
    """A lab's tables by name, each a structured array."""

    def __init__(self, folder: pathlib.Path):
        self.files = {file.stem: file for file in sorted(folder.glob("*.csv")) if file.stem not in ("hash", "audit")}

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self.files:
            raise KeyError(f"this lab wrote no table {name!r}; it has: {', '.join(self.files) or 'none'}")
        return read_table(self.files[name])

    def __iter__(self) -> Iterator[Any]:
        return iter(self.files)

    def __len__(self) -> int:
        return len(self.files)


class Arrays:
    """Recorded data of a lab; for a Run, of its first lab. Arrays have a row per frame and a column per robot in the order of `ids`; positions and headings of unseen
    robots are NaN, their LEDs 8.
    """

    folder: pathlib.Path
    name: str

    @property
    def _lab(self) -> LabRun:
        raise NotImplementedError

    @property
    def t_s(self) -> NDArray[numpy.float64]:
        """Lab time of each frame, in seconds."""
        return self._lab._frames["t_s"]

    @property
    def ids(self) -> NDArray[numpy.uint32]:
        """Ids of all robots that were ever seen."""
        return self._lab._frames["ids"]

    @property
    def xy(self) -> NDArray[numpy.float64]:
        """[frame, robot, 2], metres in the lab's arena."""
        return self._lab._frames["xy"]

    @property
    def heading(self) -> NDArray[numpy.float64]:
        """[frame, robot], radians from +x counter-clockwise."""
        return self._lab._frames["heading"]

    @property
    def led(self) -> NDArray[numpy.uint8]:
        """[frame, robot]: bit 0 red, bit 1 green, bit 2 blue; 8 unknown."""
        return self._lab._frames["led"]

    @property
    def rows(self) -> Rows:
        """The lab's tables by name, each a structured array."""
        return self._lab._rows

    def to_xarray(self) -> Any:
        """Returns the poses for xarray.

        Returns
        -------
        xarray.Dataset
            x and y (m), heading (rad) and led by time (s) and robot.

        Raises
        ------
        ImportError
            If xarray is not installed.
        """
        xarray = _library("xarray")
        about = {"x": ("m", self.xy[..., 0]), "y": ("m", self.xy[..., 1]), "heading": ("rad", self.heading), "led": ("", self.led)}
        return xarray.Dataset({name: (("time", "robot"), values, {"units": unit}) for name, (unit, values) in about.items()},
                              {"time": ("time", self.t_s, {"units": "s"}), "robot": self.ids}, {"lab": self._lab.name})

    def to_dataframe(self) -> Any:
        """Returns the poses for pandas.

        Returns
        -------
        pandas.DataFrame
            A row for each robot seen in each frame: time_s, robot, x_m, y_m, heading_rad, led.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        pandas = _library("pandas")
        time, robot = (each.ravel() for each in numpy.meshgrid(self.t_s, self.ids, indexing="ij"))
        seen = ~numpy.isnan(self.xy[..., 0].ravel())
        columns = {"time_s": time, "robot": robot, "x_m": self.xy[..., 0].ravel(), "y_m": self.xy[..., 1].ravel(),
                   "heading_rad": self.heading.ravel(), "led": self.led.ravel()}
        return pandas.DataFrame({name: column[seen] for name, column in columns.items()})


class LabRun(Arrays):
    """One lab of a run.

    Attributes
    ----------
    name : str
        Name of the lab.
    run : Run
        The whole run.
    folder : pathlib.Path
        The lab's folder.
    counts : dict of str to int
        The scenario's counts in this lab.
    result : dict
        Contents of result.json.
    """

    def __init__(self, run: Run, name: str, folder: pathlib.Path):
        self.run, self.name, self.folder = run, name, folder
        self.result = json.loads((folder / "result.json").read_text())
        self.counts: dict[str, int] = self.result.get("counts", {})
        self._rows = Rows(folder)

    @property
    def _lab(self) -> LabRun:
        return self

    @functools.cached_property
    def _frames(self) -> dict[str, Any]:
        log = tool("read_log").log_in(self.folder)
        if not log.is_file():
            raise RuntimeError(f"{self.folder} has no recording of frames (recorder.log)")
        return _frames_of(log)

    def plot(self, time_s: Optional[float] = None, width: str = "page", title: Optional[str] = None, out: Optional[PathLike] = None) -> Any:
        """Draws this lab's arena at a moment.

        Parameters
        ----------
        time_s, width, title, out
            As in `Run.plot()`, with the same errors.

        Returns
        -------
        matplotlib.axes.Axes
            In metres.
        """
        return _plot(self.folder, time_s, width, title, out)[self.name]

    def __repr__(self) -> str:
        return f"<arkmesh.LabRun {self.name} in {self.folder}: counts {self.counts}; tables {', '.join(self.rows) or 'none'}>"


def _library(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        raise ImportError(f"{name} is missing; apt-get install python3-{name}, or pip install {name}") from None


@contextlib.contextmanager
def _drawing(module):
    """A module that draws. Fonts of PDFs are TrueType from here on, also of those that the caller saves: journals refuse matplotlib's default."""
    matplotlib = _library("matplotlib")
    matplotlib.rcParams.update({"pdf.fonttype": 42, "ps.fonttype": 42})
    with tool("figure_style").styled():
        yield tool(module)


def _saved(figure, out):
    if out is not None:
        tool("figure_style").save(figure, out)


def _plot(folder, time_s, width, title, out):
    with _drawing("run_figure") as drawer:
        figure, arenas = drawer.draw(drawer.labs_of(folder, time_s), width, title)
        _saved(figure, out)
    return arenas


class Run(Arrays):
    """A run's folder. The attributes of Arrays, such as `xy` and `rows`, are those of the first lab.

    Attributes
    ----------
    labs : dict of str to LabRun
        The labs by name.
    counts : dict of str to int
        Sums over all labs, and `name@lab` for each.
    hash : str
        Final hash, 16 hexadecimal digits; equal runs have equal hashes. Empty until the run has ended.
    seed : int
        Seed of the run.
    state, ended : str
        "running", "finished", "stopped", "failed" or "killed", and the reason.
    result : dict
        Contents of result.json.
    folder : pathlib.Path
        The run's folder.

    Raises
    ------
    FileNotFoundError
        If the folder holds no result.json.
    """

    def __init__(self, folder: PathLike):
        self.folder = pathlib.Path(folder)
        if not (self.folder / "result.json").is_file():
            raise FileNotFoundError(f"{self.folder} holds no result.json of a run")
        self.result = json.loads((self.folder / "result.json").read_text())
        self.hash, self.seed = self.result.get("final_hash", ""), self.result["seed"]
        self.counts = self.result.get("counts", {})
        self.state, self.ended = self.result["state"], self.result.get("ended", "")
        alone = self.result.get("lab")
        places = {alone: self.folder} if alone else {name: self.folder / name for name in self.result["labs"]}
        self.labs: dict[str, LabRun] = {name: LabRun(self, name, place) for name, place in places.items()}
        self.name = next(iter(self.labs))

    @property
    def _lab(self) -> LabRun:
        return self.labs[self.name]

    def export(self) -> pathlib.Path:
        """Exports the run's tables as CSV, unless they are exported already.

        Returns
        -------
        pathlib.Path
            Folder of the tables.

        Raises
        ------
        RuntimeError
            If they cannot be written.
        """
        out = self.folder / "export/csv"
        if self.state == "running" or not out.is_dir():
            call("export", str(self.folder), "--csv", "--force")
        return out

    def plot(self, time_s: Optional[float] = None, width: str = "page", title: Optional[str] = None, out: Optional[PathLike] = None) -> dict[str, Any]:
        """Draws all arenas at one moment.

        Parameters
        ----------
        time_s
            Lab time in seconds; by default the last frame.
        width
            "column" (3.5 inches) or "page" (7.16 inches) of a journal.
        title
            Title of the figure.
        out
            File to write: .png, .jpg, .pdf or .svg.

        Returns
        -------
        dict of str to matplotlib.axes.Axes
            Axes by lab, in metres.

        Raises
        ------
        ValueError
            If the run has no recording of that moment, or the width or file type is not one of these.
        """
        return _plot(self.folder, time_s, width, title, out)

    def curves(self, *series: str, width: str = "page", xlabel: Optional[str] = None, ylabel: Optional[str] = None,
               title: Optional[str] = None, out: Optional[PathLike] = None) -> dict[str, Any]:
        """Draws the run's counts over lab time.

        Parameters
        ----------
        series
            Names of counts; by default all.
        width, title, out
            As in `plot()`.
        xlabel, ylabel
            Labels instead of the scenario's.

        Returns
        -------
        dict of str to matplotlib.axes.Axes
            Axes by series.

        Raises
        ------
        ValueError
            If the run has no such series.
        """
        with _drawing("curve_figure") as drawer:
            figure, axes, _ = drawer.draw_all([self.folder], (), series, width, xlabel, ylabel, title)
            _saved(figure, out)
        return axes

    def film(self, out: Optional[PathLike] = None) -> pathlib.Path:
        """Writes a film of the arenas as the page draws them.

        Parameters
        ----------
        out
            The .mp4 file; by default film.mp4 in the run's folder.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        RuntimeError
            If ffmpeg or a recording is missing.
        """
        out = pathlib.Path(out or self.folder / "film.mp4")
        call("export", str(self.folder), "--mp4", "--out", str(out), "--force")
        return out

    def __repr__(self) -> str:
        return f"<arkmesh.Run {self.folder}: labs {', '.join(self.labs)}, seed {self.seed}, {self.state}, hash {self.hash}>"
