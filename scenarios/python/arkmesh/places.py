"""Arithmetic on places. Operation by operation, so that every computer gives the same bits."""
import numpy

_PAIRS_AT_ONCE = 1 << 20


def within(xy, others, reach):
    """For each place of `xy` (n, 2) whether one of `others` (m, 2) is at most `reach` away. NaN is near nothing."""
    xy, others = (numpy.asarray(a, dtype=float) for a in (xy, others))
    if xy.ndim != 2 or others.ndim != 2 or xy.shape[1] != 2 or others.shape[1] != 2:
        raise ValueError(f"within: places are arrays of shape (n, 2), and these have {xy.shape} and {others.shape}")
    near = numpy.zeros(len(xy), dtype=bool)
    rows = max(1, _PAIRS_AT_ONCE // max(1, len(others)))
    for first in range(0, len(xy), rows):
        part = xy[first:first + rows]
        dx = others[:, 0] - part[:, 0, None]
        dy = others[:, 1] - part[:, 1, None]
        dx *= dx
        dy *= dy
        dx += dy
        near[first:first + rows] = (dx <= reach * reach).any(axis=1)
    return near
