"""Batches of runs as tables and figures, and whatever a folder holds."""
from __future__ import annotations

import collections.abc
import pathlib
from typing import Any, Iterator, Optional, Union

from numpy.typing import NDArray

from .recorded import Run, _drawing, _library, _saved
from .tables import PathLike, read_table


class Batch:
    """A batch of runs over seeds, or over settings and seeds; `batch["lit"]` is a column of its table, with a value for each run.

    Attributes
    ----------
    table : numpy.ndarray
        runs.csv as a structured array, a row per run.
    settings : list of str
        Columns of the settings that vary.
    runs : mapping
        `runs[seed]`, or `runs[value, ..., seed]` if settings vary, is a Run.
    folder : pathlib.Path
        The batch's folder.
    """

    def __init__(self, folder: PathLike):
        self.folder = pathlib.Path(folder)
        self.table = read_table(self.folder / "runs.csv")
        names = self.table.dtype.names or ()
        self.settings = list(names[2:names.index("seed")])
        keys = [(*(row[name].item() for name in self.settings), int(row["seed"])) for row in self.table]
        self.runs = Runs(self.folder, {key if self.settings else key[0]: int(row["run"]) for key, row in zip(keys, self.table)})

    def __getitem__(self, column: str) -> NDArray[Any]:
        return self.table[column]

    def __len__(self) -> int:
        return len(self.table)

    def to_dataframe(self) -> Any:
        """Returns the table for pandas.

        Returns
        -------
        pandas.DataFrame
            A row per run.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return _library("pandas").DataFrame(self.table)

    def plot(self, x: str, y: str, by: str = "", kind: str = "", width: str = "page", xlabel: Optional[str] = None, ylabel: Optional[str] = None,
             title: Optional[str] = None, axes: Any = None, out: Optional[PathLike] = None) -> Any:
        """Draws a column over a setting: lines with 95 % intervals over numbers, boxes otherwise.

        Parameters
        ----------
        x, y
            The setting and the column. A setting of the scenario may be given by its own name, `gain` for `scenario.follow.gain`.
        by
            A setting; each of its values gets a line or colour.
        kind
            "line" or "box" instead of the default.
        width, title, out
            As in `Run.plot()`.
        xlabel, ylabel
            Labels instead of the scenario's.
        axes
            Axes to draw on, instead of a new figure.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn on.

        Raises
        ------
        ValueError
            If there is no such column, or no finished run with a number in it.
        """
        with _drawing("batch_figure") as drawer:
            axes = drawer.draw(self.folder, y, x, by, kind, width, xlabel, ylabel, title, axes)
            _saved(axes.figure, out)
        return axes

    def __repr__(self) -> str:
        return f"<arkmesh.Batch {self.folder}: {len(self)} runs; columns {', '.join(self.table.dtype.names or ())}>"


class Runs(collections.abc.Mapping):
    """The runs of a batch, each read on access."""

    def __init__(self, folder: pathlib.Path, numbers: dict[Any, int]):
        self.folder, self.numbers = folder, numbers

    def __getitem__(self, key: Any) -> Run:
        if key not in self.numbers:
            raise KeyError(f"no run of {key!r} has a result; there are {', '.join(map(repr, list(self.numbers)[:3]))}, ...")
        return Run(self.folder / f"runs/{self.numbers[key]:05}")

    def __iter__(self) -> Iterator[Any]:
        return iter(self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)


def open_run(folder: PathLike) -> Union[Run, Batch]:
    """Opens the folder of a run or of a batch.

    Parameters
    ----------
    folder
        Folder of a run, or of `arkmesh batch`.

    Returns
    -------
    Run or Batch
        The recorded run or batch.

    Raises
    ------
    FileNotFoundError
        If it holds neither.
    """
    folder = pathlib.Path(folder)
    return Batch(folder) if (folder / "runs.csv").is_file() else Run(folder)
