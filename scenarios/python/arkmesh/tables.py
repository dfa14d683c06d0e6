"""Tables of recorded runs and batches."""
from __future__ import annotations

import csv
import os
from typing import Any, Union

import numpy
from numpy.typing import NDArray

PathLike = Union[str, "os.PathLike[str]"]


def read_table(path: PathLike) -> NDArray[Any]:
    """Reads a CSV file with a header.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    numpy.ndarray
        Structured, one row per line; columns hold int64, else float64 (empty cells are NaN), else texts.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it has no header.
    """
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
