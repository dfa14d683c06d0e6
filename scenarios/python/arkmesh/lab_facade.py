"""What a scenario sees of its lab, and says to it: the same as lab::Lab of C++."""
from __future__ import annotations

import hashlib
import math
import pathlib
import re
from typing import TYPE_CHECKING, Optional, Sequence, TypeVar

import numpy

from .kit import Kit
from .renamed import renamed
from .scenario import Others, Solid
from .showing import Showing
from .telling import NOT_SHOWN, WORD, Telling

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

_Setting = TypeVar("_Setting", bool, int, float, str)

HEARD = numpy.dtype([("robot", "<u4"), ("kind", "<u4"), ("value", "<i4")])


class Lab(Kit, Showing, Telling):
    """A scenario's view of its lab, and its calls.

    Arrays have one row for each robot of this lab, in the order of `ids`. Values of robots that were never seen are unknown: numbers are NaN, whole
    numbers -1, masks False, LEDs 8.

    Attributes
    ----------
    name : str
        Name of this lab.
    labs, owner : list of str, str
        All labs, and the owner of shared state; `is_owner` is True if this lab is the owner.
    now_s : float
        Lab time in seconds.
    period_s, frame_s, periods : float, float, int
        Seconds between boundaries and between frames; number of boundaries passed.
    ids : numpy.ndarray
        (n) of uint32, ascending.
    seen : numpy.ndarray
        (n) of bool: which robots the newest frame holds.
    xy, shared_xy : numpy.ndarray
        (n, 2) metres in the arena, and in the shared world. The origin is the centre, x to the right, y up.
    heading : numpy.ndarray
        (n) radians from +x, counter-clockwise.
    led : numpy.ndarray
        (n) bit 0 red, bit 1 green, bit 2 blue; 8 unknown.
    others : Others
        The robots of other labs.
    width_m, height_m, scale : float
        Sides of the arena in metres, and metres of the shared world per metre of the arena.
    obstacles, objects : list of Solid
        Fixed discs and polygons, and those that robots push.
    object_xy, object_heading : numpy.ndarray
        (m, 2) metres and (m) radians: the present poses of the objects.
    heard : numpy.ndarray
        (k) messages from robots since the previous frame: robot, kind, value. Real Kilobots send none.
    kinds, values : int
        Numbers of kinds and values in messages to robots, each from 0.
    make : str
        Make of the robots: "kilobot", "thymio".
    says : list of str
        Names of the values that arkmesh's own robot program sends, by the kind in `heard`: "prox.horizontal.0", ...; empty for Kilobots.
    wheels_m_per_s : float
        Largest speed for drive(), in metres per second; 0 if robots cannot be driven.
    """

    def __init__(self, facts, ask_setting):
        self.name, self.labs, self.owner = facts["name"], facts["labs"], facts["owner"]
        self.is_owner = self.name == self.owner
        self.period_s, self.frame_s = facts["period_s"], facts["frame_s"]
        self.width_m, self.height_m = facts["width_m"], facts["height_m"]
        self.scale = facts["scale"]  # shared metres for a metre of this arena
        self.kinds, self.values, self.whole_to_one = facts["kinds"], facts["values"], facts["whole_to_one"]
        self.make = facts.get("make", "robot")  # what the robots are: "kilobot", "thymio"
        self.says = facts.get("says", [])
        self.wheels_m_per_s = facts.get("wheels_m_per_s", 0)  # the fastest that drive() can set; 0: robots cannot be driven
        self.ids = numpy.array(facts["robots"], dtype=numpy.uint32)
        n = len(self.ids)
        self.seen = numpy.zeros(n, dtype=bool)  # whom the newest frame holds
        self.xy, self.shared_xy = numpy.full((n, 2), numpy.nan), numpy.full((n, 2), numpy.nan)
        self.heading = numpy.full(n, numpy.nan)
        self.led = numpy.full(n, 8, dtype=numpy.uint8)  # bit 0 red, bit 1 green, bit 2 blue; 8: unknown
        self.others = Others()
        self.obstacles, self.objects = ([Solid(told) for told in facts[key]] for key in ("obstacles", "objects"))
        self.object_xy, self.object_heading = numpy.array([o.xy for o in self.objects]).reshape(-1, 2), numpy.array([o.heading for o in self.objects])
        self.heard = numpy.zeros(0, HEARD)  # what robots have said since the frame before; real Kilobots say nothing
        self.now_s, self.periods = 0.0, 0
        self._seed, self._ask, self._streams, self._merged, self._rules = facts["seed"], ask_setting, {}, {}, {}
        self._words, self._said, self._pieces = [], {}, []
        to_all = numpy.zeros(n, WORD)
        to_all["robot"] = self.ids
        self._published, self._to_all, self._all, self._not_shown = {}, to_all.tobytes(), numpy.ones(n, dtype=bool), numpy.full(n, NOT_SHOWN, numpy.uint8)
        self._said_s = {}  # by slot, when each robot was told what is said now and then
        self._columns, self._settings = {}, {}  # by table, those of its first row; by name, what was asked
        self._file, self._files, self._alike = pathlib.Path(facts["file"]), {}, {}
        self._colours = facts.get("colours")
        self._words_per_s = facts.get("words_per_s", math.inf)

    # --- settings, chance ---
    @renamed(help="about")
    def setting(self, name: str, default: _Setting, low: Optional[float] = None, high: Optional[float] = None, unit: str = "", about: str = "",
                one_of: Sequence[str] = (), own: bool = False) -> _Setting:
        """Returns a setting of the lab's file, from [scenario.FILE]; in begin() only. It must be equal in all labs.

        Parameters
        ----------
        name
            Of a-z, 0-9 and _.
        default
            Value if the file has none; its type is the setting's type.
        low, high
            Limits of a number.
        unit
            Such as "m" or "s".
        about
            Description in a few words.
        one_of
            The allowed texts.
        own
            Read from [sensors.FILE] instead, which may differ between labs.

        Returns
        -------
        bool, int, float or str
            The value, of the type of `default`.

        Raises
        ------
        RuntimeError
            After begin().
        TypeError
            If the default is not a bool, int, float or str.
        ValueError
            If the name is invalid, the default is out of range, or the setting was requested with other arguments.
        """
        if self._ask is None:
            raise RuntimeError(f"setting {name!r}: ask for settings in begin()")
        if not re.fullmatch("[a-z][a-z0-9_]*", name):
            raise ValueError(f"setting {name!r}: a name consists of a-z, 0-9 and _, and begins with a letter")
        if not isinstance(default, (bool, int, float, str)):
            raise TypeError(f"setting {name!r}: the default must be a bool, int, float or str, not {default!r}")
        asked = {"name": name, "default": default, "low": low, "high": high, "unit": unit, "help": about, "one_of": list(one_of), "own": bool(own)}
        if self._settings.setdefault(name, asked) != asked:
            raise ValueError(f"setting {name!r} is requested twice, in different ways; request it once, and keep the value")
        if isinstance(default, str) and one_of and default not in one_of:
            raise ValueError(f"setting {name!r}: the default {default!r} is not one of {', '.join(one_of)}")
        if not isinstance(default, (bool, str)) and not (-math.inf if low is None else low) <= default <= (math.inf if high is None else high):
            raise ValueError(f"setting {name!r}: the default {default!r} is not within low={low} and high={high}")
        if unit:
            self.show(name, unit=unit)
        return self._ask(asked)

    def needs_airtime(self, words_per_s: float) -> None:
        """Declares how many messages the scenario sends to individual robots; in begin() only.

        Parameters
        ----------
        words_per_s
            Messages per second, over all robots.

        Raises
        ------
        ValueError
            If they exceed the arena's airtime.
        """
        if not 0 <= words_per_s <= self._words_per_s:
            raise ValueError(f"{words_per_s:g} words a second exceed the {self._words_per_s:.3g} of this arena's airtime; "
                             "speak to fewer robots, or more rarely")

    def random(self, purpose: str, common: bool = False) -> numpy.random.Generator:
        """Returns this lab's random generator for `purpose`; it depends only on run.seed, lab and purpose.

        Parameters
        ----------
        purpose
            A word of your choice.
        common
            Do not depend on the lab: labs that draw alike, as in begin() and period(), get equal numbers.

        Returns
        -------
        numpy.random.Generator
            The same object at each call.
        """
        name = f"{'' if common else self.name}/{purpose}"
        if name not in self._streams:
            digest = hashlib.sha256(f"{self._seed}/{name}".encode()).digest()
            seed = numpy.random.SeedSequence(int.from_bytes(digest, "little"))
            self._streams[name] = numpy.random.Generator(numpy.random.PCG64(seed))
        return self._streams[name]

    # --- what labs share ---
    def declare(self, name: str, length: int = 1, low: int = 0, high: int = 1_000_000, owner_only: bool = False, initial_only: bool = False,
                up_to: bool = False) -> None:
        """Declares a field that each lab publishes to all labs; in begin() only, and equally in all labs.

        A value that violates the declaration ends the run of the lab that publishes it; states of a peer with such values are refused and counted.

        Parameters
        ----------
        name
            Name of the field.
        length
            Number of whole numbers in it.
        low, high
            Limits of each number.
        owner_only
            Only the owner (shared.owner) publishes it.
        initial_only
            It is published in begin() and does not change.
        up_to
            `length` is the maximum.

        Raises
        ------
        ValueError
            If the field is declared already, or its name begins with "kit.".
        """
        if name in self._rules or str(name).startswith("kit."):
            raise ValueError(f"field {name!r} is {'declared already' if name in self._rules else 'one of the kit'}; give another name")
        self._rules[name] = (length, up_to)
        self._said.setdefault("declare", []).append(
            {"name": name, "length": int(length), "low": int(low), "high": int(high), "owner_only": bool(owner_only),
             "initial_only": bool(initial_only), "up_to": bool(up_to)})

    def publish(self, name: str, values: ArrayLike) -> None:
        """Sets a field of this lab. It is in force in all labs from the next boundary.

        Parameters
        ----------
        name
            A declared field.
        values
            `length` whole numbers; with `up_to`, that many or fewer.

        Raises
        ------
        ValueError
            If the field is not declared, or there are too many or too few numbers, or they are not whole.
        """
        if name not in self._rules:
            raise ValueError(f"field {name!r} is not declared; declare it in begin()")
        length, up_to = self._rules[name]
        if length == 1 and type(values) is list and len(values) == 1 and isinstance(values[0], (int, numpy.integer)) and -2**63 <= values[0] < 2**63:
            numbers = [int(values[0])]  # the usual one, at once
        else:
            given = numpy.atleast_1d(values)
            if given.ndim != 1 or len(given) > length or (len(given) < length and not up_to):
                raise ValueError(f"field {name!r} has {length} values{' at most' if up_to else ''}, not an array of shape {given.shape}")
            numbers = [int(v) for v in self._column(f"field {name!r}", given, -2**63, 2**63 - 1, len(given))]
        if self._published.get(name) != numbers:  # else the lab has it
            self._published[name] = self._said.setdefault("publish", {})[name] = numbers

    def field(self, lab: str, name: str) -> NDArray[numpy.int64]:
        """Returns a lab's field as of the last boundary.

        Parameters
        ----------
        lab
            One of `labs`.
        name
            Name of the field; one with `initial_only` keeps its value from the start.

        Returns
        -------
        numpy.ndarray
            (length) of int64; empty if the lab has not published it.

        Raises
        ------
        ValueError
            If there is no such lab.
        """
        if lab not in self.labs:
            raise ValueError(f"{lab!r} is not one of the labs {', '.join(self.labs)}")
        return self._merged.get(lab, {}).get(name, numpy.zeros(0, dtype=numpy.int64))

    # --- the lab's process ---
    def _see(self, now_us, robots, objects, heard, sensed=()):
        self.now_s, self.heard = now_us / 1e6, heard
        of_all = len(robots["ids"]) == len(self.ids)
        for piece, numbers in zip(self._pieces, sensed):
            piece._see(None if of_all else numpy.searchsorted(self.ids, robots["ids"]), numbers)
        if len(objects):
            self.object_xy, self.object_heading = numpy.stack([objects["x"], objects["y"]], axis=1), objects["heading"]
        if of_all:
            self.seen = self._all.copy()
            self.xy, self.shared_xy, self.heading, self.led = robots["xy"], robots["shared_xy"], robots["heading"], robots["led"]
            return
        rows = numpy.searchsorted(self.ids, robots["ids"])
        self.seen = numpy.zeros(len(self.ids), dtype=bool)
        self.seen[rows] = True
        for key in ("xy", "shared_xy", "heading", "led"):
            mine = getattr(self, key).copy()  # a scenario may keep the former one
            mine[rows] = robots[key]
            setattr(self, key, mine)

    def _merge(self, now_us, period, states, worlds=()):
        for piece, numbers in zip(self._pieces, worlds):
            piece._merge(numbers)
        self.now_s, self.periods = now_us / 1e6, period
        self._merged = {name: fields for name, _, fields in states}
        self.others = Others([(name, robots) for name, robots, _ in states if name != self.name])

    def _take(self):
        words, said = self._words, self._said
        self._words, self._said = [], {}
        return b"".join([each.tobytes() for each in words]) if words else b"", said
