"""What a scenario is, the same as lab::Scenario of C++, and what it meets in its arena beside its own robots."""
from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from .lab_facade import Lab


def check_every(every):
    if isinstance(every, (bool, numpy.bool_)) or not isinstance(every, (int, numpy.integer)) or not 0 <= every <= 1_000_000:
        raise ValueError(f"`every` must be a whole number (frame() gets each k-th frame; 0: none), not {every!r}")
    return int(every)


class Scenario:
    """A scenario: derive from it, once per file. Methods that you do not define do nothing.

    Attributes
    ----------
    every : int
        frame() is called for each k-th frame only; 1 to 1,000,000. 0: never, for a lab that acts at boundaries only; its poses, sensors and `heard` are
        then not updated.
    """

    every = 1  # frame() is called for each k-th frame only

    def __init_subclass__(cls, **more):
        super().__init_subclass__(**more)
        for name in vars(cls):
            cls._check(name, getattr(cls, name))

    def __setattr__(self, name, value):
        self._check(name, value)
        super().__setattr__(name, value)

    @staticmethod
    def _check(name, value):
        """What a scenario calls `every`, or like a method, would fail later, where no line of its own is at fault."""
        if name == "every":
            check_every(value)
        elif name in ("begin", "frame", "period", "finished") and not callable(value):
            raise ValueError(f"the lab calls `{name}`; give {value!r} another name")

    def begin(self, lab: Lab) -> None:
        """Called once, before lab time passes: ask for settings and pieces, declare fields, publish what this lab decides.

        Parameters
        ----------
        lab
            This lab; other labs' robots and fields are not known yet.
        """

    def frame(self, lab: Lab) -> None:
        """Called for each frame of poses, 10 a second. The first frame precedes the first period(), when nothing is known of other labs.

        Parameters
        ----------
        lab
            This lab, with the robots of the newest frame.
        """

    def period(self, lab: Lab) -> None:
        """Called at each boundary, right after the states of all labs were merged.

        Parameters
        ----------
        lab
            This lab, with the robots and fields of all labs as of this boundary.
        """

    def finished(self, lab: Lab) -> bool:
        """Called after each period().

        Parameters
        ----------
        lab
            As in period(). Use merged fields only, so that all labs decide alike.

        Returns
        -------
        bool
            True ends the run.
        """
        return False


class Solid:
    """An obstacle, or an object that robots push.

    Attributes
    ----------
    name : str
        Name of an object; empty for an obstacle.
    radius : float
        Radius of a disc, in metres; 0 for a polygon.
    xy : numpy.ndarray
        (2) position in the arena, in metres; of an object, its position at the start (lab.object_xy has the present one).
    heading : float
        Radians from +x, counter-clockwise; of an object, at the start.
    corners : numpy.ndarray
        (k, 2) corners of a polygon in the arena, in metres; of an object, at the start. Empty for a disc.
    """

    def __init__(self, told):
        self.name, self.radius, self.heading = told["name"], told["radius_m"], told["heading"]
        self.xy = numpy.array([told["x_m"], told["y_m"]])
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        self.corners = self.xy + numpy.array(told["corners"], dtype=float).reshape(-1, 2) @ numpy.array([[cos, sin], [-sin, cos]])


class Others:
    """The robots of all other labs as merged at the last boundary, one row each, in the order of lab and id."""

    def __init__(self, parts=()):
        self._parts = parts

    @cached_property
    def labs(self) -> NDArray[numpy.str_]:
        """(n) the lab of each robot."""
        if len(self._parts) == 1:
            return numpy.full(len(self._parts[0][1]["ids"]), self._parts[0][0], "<U15")
        return numpy.repeat(numpy.array([name for name, _ in self._parts], dtype="<U15"), [len(robots["ids"]) for _, robots in self._parts])

    @cached_property
    def ids(self) -> NDArray[numpy.uint32]:
        """(n) the id of each robot in its lab."""
        return _joined(self._parts, "ids", (0,), numpy.uint32)

    @cached_property
    def xy(self) -> NDArray[numpy.float64]:
        """(n, 2) metres in this lab's arena."""
        return _joined(self._parts, "xy", (0, 2), float)

    @cached_property
    def shared_xy(self) -> NDArray[numpy.float64]:
        """(n, 2) metres in the shared world."""
        return _joined(self._parts, "shared_xy", (0, 2), float)

    @cached_property
    def heading(self) -> NDArray[numpy.float64]:
        """(n) radians from +x of this lab's arena, counter-clockwise."""
        return _joined(self._parts, "heading", (0,), float)

    @cached_property
    def led(self) -> NDArray[numpy.uint8]:
        """(n) bit 0 red, bit 1 green, bit 2 blue; 8 unknown."""
        return _joined(self._parts, "led", (0,), numpy.uint8)


def _joined(parts, key, shape, dtype):
    if len(parts) == 1:
        return parts[0][1][key]
    return numpy.concatenate([numpy.zeros(shape, dtype), *(robots[key] for _, robots in parts)])
