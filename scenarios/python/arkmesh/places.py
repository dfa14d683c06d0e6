"""Arithmetic on places. Operation by operation, so that every computer gives the same bits."""
from __future__ import annotations
from typing import TYPE_CHECKING

import numpy

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

_PAIRS_AT_ONCE = 1 << 20
_FEW_PAIRS = 1 << 14  # all are looked at in less time than cells take
_FAR = 1 << 30  # cells from the origin


def within(xy: ArrayLike, others: ArrayLike, reach: float) -> NDArray[numpy.bool_]:
    """Tests for each place whether one of the others is near. NaN is near nothing.

    Parameters
    ----------
    xy
        (n, 2) places, in metres.
    others
        (m, 2) places in the same frame, in metres.
    reach
        Largest distance in metres, inclusive.

    Returns
    -------
    numpy.ndarray
        (n) of bool.

    Raises
    ------
    ValueError
        If places have another shape.
    """
    xy, others = numpy.asarray(xy, dtype=float), numpy.asarray(others, dtype=float)
    if xy.ndim != 2 or others.ndim != 2 or xy.shape[1] != 2 or others.shape[1] != 2:
        raise ValueError(f"within: places must be arrays of shape (n, 2), not {xy.shape} and {others.shape}")
    if len(xy) * len(others) > _FEW_PAIRS:
        pairs = _candidates(xy, others, reach)
        if pairs is not None:
            rows, columns = pairs
            near = numpy.zeros(len(xy), dtype=bool)
            near[rows[_are_near(others[columns, 0] - xy[rows, 0], others[columns, 1] - xy[rows, 1], reach)]] = True
            return near
    if len(xy) * len(others) <= _PAIRS_AT_ONCE:
        return _has_near(xy, others, reach)
    near = numpy.zeros(len(xy), dtype=bool)
    rows = max(1, _PAIRS_AT_ONCE // max(1, len(others)))
    for first in range(0, len(xy), rows):
        near[first:first + rows] = _has_near(xy[first:first + rows], others, reach)
    return near


def _has_near(xy, others, reach):
    return numpy.logical_or.reduce(_are_near(others[:, 0] - xy[:, 0, None], others[:, 1] - xy[:, 1, None], reach), axis=1)


def _are_near(dx, dy, reach):
    dx *= dx
    dy *= dy
    dx += dy
    return dx <= reach * reach


def _candidates(xy, others, reach):
    """Pairs (rows of xy, rows of others) that hold all that are near: those in the same or in neighbouring square cells. None:
    too many pairs, or places that cells do not help with."""
    side = reach * (1 + 1e-6)  # more than rounding may take away
    if not 0 < side < numpy.inf:
        return None
    cells, other_cells = numpy.floor(xy / side), numpy.floor(others / side)
    rows, columns = (numpy.flatnonzero((abs(c) < _FAR).all(axis=1)) for c in (cells, other_cells))
    if len(columns) == 0:
        return rows[:0], columns
    cells, other_cells = cells[rows].astype(numpy.int64), other_cells[columns].astype(numpy.int64)
    low, high = other_cells[:, 1].min() - 1, other_cells[:, 1].max() + 1
    beside = (cells[:, 1] >= low) & (cells[:, 1] <= high)
    rows, cells = rows[beside], cells[beside]
    # cells of a column lie one behind the other, with one that is empty before and behind: three ranges for each place
    height = high - low + 3
    keys = other_cells[:, 0] * height + (other_cells[:, 1] - low + 1)
    order = numpy.argsort(keys, kind="stable")
    keys = keys[order]
    own = cells[:, 0] * height + (cells[:, 1] - low + 1)
    middle = numpy.concatenate([own - height, own, own + height])
    first = numpy.searchsorted(keys, middle - 1, "left")
    counts = numpy.searchsorted(keys, middle + 1, "right") - first
    total = int(counts.sum())
    if total > min(_PAIRS_AT_ONCE, len(xy) * len(others) // 4):
        return None
    at = numpy.arange(total) - numpy.repeat(numpy.cumsum(counts) - counts, counts) + numpy.repeat(first, counts)
    return numpy.repeat(numpy.tile(rows, 3), counts), columns[order[at]]
