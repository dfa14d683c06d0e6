"""The kit's pieces as a scenario sees them. The lab computes them (scenarios/kit), for C++ and Python alike; their arrays come with
each frame, one row for each robot of the lab. Of robots that were never seen, numbers are NaN, whole numbers -1, and masks False."""
from __future__ import annotations

import io
import math
import os
import sys
from typing import TYPE_CHECKING

import numpy

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

ALL_LEDS = tuple(range(9))  # 8: unknown
LARGEST_IMAGE = 16 << 20  # bytes


def _number(name, value, low=-1e12, high=1e12):
    if isinstance(value, (bool, numpy.bool_)) or not isinstance(value, (int, float, numpy.number)):
        raise ValueError(f"{name} must be a number, not {value!r}")
    value = float(value)
    if not low <= value <= high:
        raise ValueError(f"{name} must be {low:g} to {high:g}, not {value:g}")
    return value


def _whole(name, value, low, high):
    number = _number(name, value, low, high)
    if number != int(number):
        raise ValueError(f"{name} must be a whole number, not {value!r}")
    return int(number)


def _pair(name, values, low=-1e12, high=1e12):
    if numpy.shape(values) != (2,):
        raise ValueError(f"{name} must be two numbers, not {values!r}")
    return [_number(name, value, low, high) for value in values]


def _name(what, name):
    if not isinstance(name, str) or not name.isidentifier() or len(name) > 30:
        raise ValueError(f"the name of {what} must be a word of up to 30 letters, digits and _, not {name!r}")
    return name


def _callers_line():
    """The user's, such as mine.py:5."""
    frame = sys._getframe(1)
    while frame.f_back and os.path.dirname(frame.f_code.co_filename) == os.path.dirname(__file__):
        frame = frame.f_back
    return f"{os.path.basename(frame.f_code.co_filename)}:{frame.f_lineno}"


def _tiles_of(scenario, kept, image, columns, rows, levels):
    """Levels from an image beside the scenario's file, whose bytes `kept` gets."""
    try:
        from PIL import Image  # type: ignore[import]  # pylint: disable=import-outside-toplevel
    except ImportError as error:
        raise ValueError("a floor from an image needs Pillow (python3-pil)") from error
    path = scenario.parent / image
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ValueError(f"cannot read the image {path}: {error.strerror}") from error
    if len(data) > LARGEST_IMAGE:
        raise ValueError(f"{image} has {len(data)} bytes, and the limit is {LARGEST_IMAGE}; use a smaller image")
    if path.is_relative_to(scenario.parent) and ".." not in path.relative_to(scenario.parent).parts:
        kept[path.relative_to(scenario.parent).as_posix()] = data  # kept with the run, so that it can be repeated
    try:
        with Image.open(io.BytesIO(data)) as opened:
            if opened.mode.startswith(("I", "F")):  # Pillow gives 16 bits as 32
                deep = numpy.asarray(opened)
                if deep.min() < 0 or deep.max() > 65535 or opened.mode == "F":
                    raise ValueError("it has 32-bit greys; use 8 or 16 bits")
                opened = Image.fromarray((deep >> 8).astype(numpy.uint8))
            elif opened.mode in ("RGBA", "LA", "PA") or "transparency" in opened.info:  # what is transparent is white
                opened = Image.alpha_composite(Image.new("RGBA", opened.size, "white"), opened.convert("RGBA"))
            grey = numpy.asarray(opened.convert("L").resize((columns, rows), Image.BOX))
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise ValueError(f"{image} cannot be read as an image: {error}") from error
    return ((255 - grey[::-1].astype(int)) * levels // 256).astype(numpy.uint8)  # an image's first row is its highest


def _whole_numbers(sensed):
    return numpy.nan_to_num(sensed, nan=-1).astype(int)


class Piece:
    """A piece of the kit; the lab updates it."""

    columns = 1

    def __init__(self, lab, number, columns=None):
        self._lab, self._number, self.columns = lab, number, columns or self.columns
        self.sensed = numpy.full((len(lab.ids), self.columns), numpy.nan)
        self._world = numpy.zeros(0)  # what is known of the piece itself, as merged last

    def _merge(self, world):
        self._world = world

    def _see(self, rows, sensed):
        if rows is None:
            self.sensed = sensed
        else:
            self.sensed = self.sensed.copy()  # a scenario may keep the former one
            self.sensed[rows] = sensed


def _leds(leds):
    leds = sorted({_whole("an LED", led, 0, 8) for led in (ALL_LEDS if leds is None else numpy.atleast_1d(leds).tolist())})
    if not leds:
        raise ValueError("leds must hold numbers from 0 to 8, and is empty")
    return leds


class Eyes(Piece):
    """A proximity sensor: `distance` (n, sectors) in metres, infinite where nothing is within reach."""

    @property
    def distance(self) -> NDArray[numpy.float64]:
        """(n, sectors) metres, infinite where nothing is within reach."""
        return numpy.where(self.sensed < 0, numpy.inf, self.sensed)

    @property
    def bits(self) -> NDArray[numpy.int64]:
        """(n) a bit for each sector with something within reach, the first sector's highest; -1 for robots never seen."""
        bits = (self.sensed >= 0) @ (1 << numpy.arange(self.columns - 1, -1, -1))
        return numpy.where(numpy.isnan(self.sensed[:, 0]), -1, bits)


class Crowd(Piece):
    """A count of robots: `count` (n) near each robot."""

    @property
    def count(self) -> NDArray[numpy.int64]:
        """(n) robots near each robot."""
        return _whole_numbers(self.sensed[:, 0])


class Trail(Piece):
    """Pheromone of the shared world. `value` (n) under each robot, `gradient` (n, 2) along x and y of this arena per metre of it,
    `zones` (n) as bits, the rightmost zone's lowest."""

    columns = 4

    @property
    def value(self) -> NDArray[numpy.float64]:
        """(n) pheromone under each robot."""
        return self.sensed[:, 0]

    @property
    def gradient(self) -> NDArray[numpy.float64]:
        """(n, 2) along x and y of this arena, per metre of it."""
        return self.sensed[:, 1:3]

    @property
    def zones(self) -> NDArray[numpy.int64]:
        """(n) a bit for each zone, the rightmost zone's lowest."""
        return _whole_numbers(self.sensed[:, 3])

    def lay(self, who: ArrayLike, amount: ArrayLike = 1.0) -> None:
        """Lays pheromone at robots' positions, in frame(). It is in force in all labs from the next boundary.

        Parameters
        ----------
        who
            (n) a mask over the rows, or ids.
        amount
            Amount for each robot, 0 or more: one number, or one for each row or id.

        Raises
        ------
        ValueError
            If an amount is below 0, not finite, or of another shape.
        """
        rows, by_ids = self._lab._rows(who)
        amount = numpy.asarray(amount, dtype=float)
        if amount.shape not in ((), (len(rows),) if by_ids else (len(self._lab.ids),)):
            raise ValueError(f"amount must be one number, or one for each robot, not an array of shape {amount.shape}")
        each = numpy.broadcast_to(amount, len(rows)) if amount.ndim == 0 or by_ids else amount[rows]
        if not numpy.isfinite(each).all() or (each < 0).any():
            raise ValueError("amount must be 0 or more, without NaN")
        rows, each = rows[each > 0], each[each > 0]
        if len(rows):
            self._lab._said.setdefault("kit_acts", []).append(
                {"piece": self._number, "robots": self._lab.ids[rows].tolist(), "amounts": each.tolist()})


class Region(Piece):
    """A part of the shared world. `inside` (n): which robots are in it. The others are as of the last boundary, equal in all labs: `robots`, the number
    of counting robots of all labs in it; `stock`, the rest of its resource; `share`, the amount that each of them took in the last period.
    """

    @property
    def inside(self) -> NDArray[numpy.bool_]:
        """(n) of bool: which robots are in it."""
        return self.sensed[:, 0] == 1

    @property
    def robots(self) -> int:
        """Number of counting robots of all labs in it, at the last boundary."""
        return int(self._world[0])

    @property
    def stock(self) -> float:
        """Rest of its resource, at the last boundary."""
        return float(self._world[1])

    @property
    def share(self) -> float:
        """Amount of the resource that each robot in it took in the last period."""
        return float(self._world[2])


class Floor(Piece):
    """`level` (n) of the tile under each robot."""

    @property
    def level(self) -> NDArray[numpy.int64]:
        """(n) level of the tile under each robot."""
        return _whole_numbers(self.sensed[:, 0])


class Towards(Piece):
    """Direction of a place of the shared world: `bearing` (n) from each robot's heading, counter-clockwise, and `distance` (n) in
    the shared world.
    """

    columns = 2

    @property
    def bearing(self) -> NDArray[numpy.float64]:
        """(n) radians from the robot's heading, counter-clockwise."""
        return self.sensed[:, 0]

    @property
    def distance(self) -> NDArray[numpy.float64]:
        """(n) metres of the shared world."""
        return self.sensed[:, 1]

    def sector(self, sectors: int) -> NDArray[numpy.int64]:
        """Returns the sector of the bearing.

        Parameters
        ----------
        sectors
            Number of equal sectors, the first centred straight ahead, then counter-clockwise.

        Returns
        -------
        numpy.ndarray
            (n) of int, from 0; -1 for robots never seen.
        """
        return _whole_numbers(numpy.floor(self.bearing / (2 * math.pi) * sectors + 0.5) % sectors)


class Gps(Piece):
    """Each robot's pose as whole numbers: `column` and `row` (n) of its cell or the nearest one, from the left and from below, and
    `heading` (n) as one of the directions, 0 around x, then counter-clockwise.
    """

    def _cell(self, axis):
        cells = numpy.floor((self.sensed[:, axis] / self.size[axis] + 0.5) * self.cells[axis])
        return _whole_numbers(numpy.clip(cells, 0, self.cells[axis] - 1))

    cells: list[int]
    size: list[float]

    @property
    def column(self) -> NDArray[numpy.int64]:
        """(n) column of the cell, from the left."""
        return self._cell(0)

    @property
    def row(self) -> NDArray[numpy.int64]:
        """(n) row of the cell, from below."""
        return self._cell(1)

    @property
    def heading(self) -> NDArray[numpy.int64]:
        """(n) direction, 0 around x, then counter-clockwise."""
        return _whole_numbers(numpy.floor(self.sensed[:, 2] / (2 * math.pi) * self.cells[2] + 0.5) % self.cells[2])


class Light(Piece):
    """`level` (n) of virtual light at each robot, 0 to 1023."""

    @property
    def level(self) -> NDArray[numpy.int64]:
        """(n) from 0 to 1023."""
        return _whole_numbers(self.sensed[:, 0])


class Voices(Piece):
    """Messages between robots of all labs. `heard` (n, values): the number of others within reach, or joined by the graph, that say each value."""

    @property
    def heard(self) -> NDArray[numpy.int64]:
        """(n, values) number of others that say each value."""
        return _whole_numbers(self.sensed)

    def say(self, who: ArrayLike, value: ArrayLike) -> None:
        """Sets what robots say from now on, in frame().

        Parameters
        ----------
        who
            (n) a mask over the rows, or ids.
        value
            From 0, or -1 for silence: one number, or one for each row or id.

        Raises
        ------
        ValueError
            If a value is not below `values` of voices().
        """
        rows, by_ids = self._lab._rows(who)
        each = numpy.broadcast_to(self._lab._chosen("value", value, -1, self.columns - 1, rows, by_ids), len(rows))
        if len(rows):
            self._lab._said.setdefault("kit_acts", []).append({"piece": self._number, "robots": self._lab.ids[rows].tolist(), "values": each.astype(int).tolist()})
