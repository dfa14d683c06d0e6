"""What a scenario sees of its lab, and says to it: the same as lab::Lab of C++."""
from __future__ import annotations

import hashlib
import math
import pathlib
import re
from typing import Any, Optional, Sequence, TypeVar

import numpy
from numpy.typing import ArrayLike, NDArray

from .kit import Kit
from .pieces import _number
from .renamed import renamed
from .scenario import Others, Solid
from .showing import Showing

_Setting = TypeVar("_Setting", bool, int, float, str)

WORD = numpy.dtype([("robot", "<u4"), ("slot", "u1"), ("kind", "u1"), ("how", "u1"), ("pad", "u1"), ("value", "<u4")])
HEARD = numpy.dtype([("robot", "<u4"), ("kind", "<u4"), ("value", "<i4")])
ONCE, UNTIL_LED_CHANGES, SHOWN, NOT_SHOWN = range(4)  # WORD's `how`, as scenarios/python/python_scenario.cpp has it
_WHEELS = 255  # the slot of drive(), as hal/robot/set_point.hpp has it


def _nine_bytes(data):
    if not isinstance(data, (bytes, bytearray)):
        given = numpy.asarray(data)
        high = {(3,): 2**24 - 1, (9,): 255}.get(given.shape)
        if high is None or given.dtype.kind not in "iu" or given.min() < 0 or given.max() > high:
            raise ValueError("data must be nine bytes, or three whole numbers of 24 bits")
        data = b"".join(int(v).to_bytes(9 // len(given), "big") for v in given)
    if len(data) != 9:
        raise ValueError(f"data must be nine bytes, not {len(data)}")
    return list(data)


class Lab(Kit, Showing):
    """What a scenario sees of its lab, and what it can say.

    Arrays have one row for each robot of this lab, in the order of `ids`. Of robots that were never seen nothing is known: numbers are NaN, whole
    numbers -1, masks False, LEDs 8.

    Attributes
    ----------
    name : str
        The lab's.
    labs, owner : list of str, str
        All labs, and the one that owns what is shared; `is_owner` where it is this one.
    now_s : float
        Lab time in seconds.
    period_s, frame_s, periods : float, float, int
        Seconds between boundaries and between frames; boundaries that have passed.
    ids : numpy.ndarray
        (n) of uint32, ascending.
    seen : numpy.ndarray
        (n) of bool: whom the newest frame holds.
    xy, shared_xy : numpy.ndarray
        (n, 2) metres in the arena, and in the shared world. The origin is the middle, x to the right, y up.
    heading : numpy.ndarray
        (n) radians from +x, counter-clockwise.
    led : numpy.ndarray
        (n) bit 0 red, bit 1 green, bit 2 blue; 8 unknown.
    others : Others
        The robots of other labs.
    width_m, height_m, scale : float
        Sides of the arena in metres, and metres of the shared world for one of the arena.
    obstacles, objects : list
        Discs and polygons that stand still, and that robots push.
    object_xy, object_heading : numpy.ndarray
        (m, 2) metres and (m) radians of the objects now.
    heard : numpy.ndarray
        (k) what robots have said since the frame before: robot, kind, value. Real Kilobots say nothing.
    kinds, values : int
        Kinds and values that a word to a robot can have, each from 0.
    make : str
        What the robots are: "kilobot", "thymio".
    wheels_m_per_s : float
        The fastest that drive() can set, metres a second; 0 where robots cannot be driven.
    """

    def __init__(self, facts, ask_setting):
        self.name, self.labs, self.owner = facts["name"], facts["labs"], facts["owner"]
        self.is_owner = self.name == self.owner
        self.period_s, self.frame_s = facts["period_s"], facts["frame_s"]
        self.width_m, self.height_m = facts["width_m"], facts["height_m"]
        self.scale = facts["scale"]  # shared metres for a metre of this arena
        self.kinds, self.values, self.whole_to_one = facts["kinds"], facts["values"], facts["whole_to_one"]
        self.make = facts.get("make", "robot")  # what the robots are: "kilobot", "thymio"
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
        """Returns a setting of the lab's file, from [scenario.FILE]; in begin() only. All labs have it alike.

        Parameters
        ----------
        name
            Of a-z, 0-9 and _.
        default
            What it is where the file says nothing; its type is the setting's.
        low, high
            Its limits, if it is a number.
        unit
            Such as "m" or "s".
        about
            What it is, in a few words.
        one_of
            The texts that it can be.
        own
            From [sensors.FILE] instead, in which labs may differ.

        Returns
        -------
        bool, int, float or str
            As the default.

        Raises
        ------
        RuntimeError
            After begin().
        ValueError
            If the name, or a default beyond its limits, cannot be, or the setting is asked for twice in two ways.
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
        """In begin(): how many words to single robots, of all together, this scenario has to say in a second. ValueError where the
        arena's airtime carries fewer."""
        if not 0 <= words_per_s <= self._words_per_s:
            raise ValueError(f"{words_per_s:g} words a second exceed the {self._words_per_s:.3g} of this arena's airtime; "
                             "speak to fewer robots, or more rarely")

    def random(self, purpose: str, common: bool = False) -> numpy.random.Generator:
        """A numpy Generator of this lab for `purpose`: it depends on run.seed, lab and purpose, on nothing else. `common`: not on the lab
        either, so that labs that draw alike, as in begin() and period(), have the same numbers."""
        name = f"{'' if common else self.name}/{purpose}"
        if name not in self._streams:
            digest = hashlib.sha256(f"{self._seed}/{name}".encode()).digest()
            seed = numpy.random.SeedSequence(int.from_bytes(digest, "little"))
            self._streams[name] = numpy.random.Generator(numpy.random.PCG64(seed))
        return self._streams[name]

    # --- robots ---
    def tell(self, who: ArrayLike, kind: ArrayLike = 0, value: ArrayLike = 0, slot: ArrayLike = 0, shown: Optional[ArrayLike] = None) -> None:
        """What robots have to know: it is said at once when it changes, and again each second until the robot shows it.

        Parameters
        ----------
        who
            (n) a mask over the rows, or ids.
        kind, value, slot
            Whole numbers below `kinds`, `values` and 256: one, or one for each row or id. Kinds that exclude each other share a slot.
        shown
            (n) a mask of who shows it; without one, a robot shows it when its LED is another one than at the change.

        Raises
        ------
        ValueError
            If a number is beyond its limits or not whole, a shape is another one, or an id is none of this lab's.
        """
        how = UNTIL_LED_CHANGES if shown is None else self._not_shown - self._column("shown", shown, 0, 1)  # SHOWN is one less
        self._say(who, kind, value, slot, how)

    def say(self, who: ArrayLike, kind: ArrayLike = 0, value: ArrayLike = 0, slot: ArrayLike = 0, every_s: float = 0.0) -> None:
        """Says a word to robots once.

        Parameters
        ----------
        who, kind, value, slot
            As in `tell()`.
        every_s
            Seconds: called at each frame, a robot is told the newest in that slot once in so long; 0: at each call.

        Raises
        ------
        ValueError
            As in `tell()`.
        """
        self._say(who, kind, value, slot, ONCE, _number("every_s", every_s, 0, 1e6))

    def drive(self, who: ArrayLike, left: ArrayLike, right: ArrayLike) -> None:
        """Sets speeds of wheels. They are in force until the next ones, and said again to a robot that may lack them.

        Parameters
        ----------
        who
            (n) a mask over the rows, or ids.
        left, right
            Metres a second, backwards below 0: one number, or one for each row or id.

        Raises
        ------
        ValueError
            If robots cannot be driven, or not so fast.
        """
        if not self.wheels_m_per_s:
            raise ValueError(f"drive: a {self.make} has no wheels that a lab can drive; only its own program moves it")
        rows, by_ids = self._rows(who)
        words = numpy.zeros(len(rows), WORD)
        words["robot"], words["slot"], words["how"] = self.ids[rows], _WHEELS, SHOWN
        most = round(1000 * self.wheels_m_per_s)
        for name, given, shift in (("left", left, 12), ("right", right, 0)):
            mm_s = numpy.round(1000 * numpy.asarray(given, dtype=float))
            words["value"] += (self._chosen(f"{name}, mm/s,", mm_s, -most, most, rows, by_ids).astype(numpy.int64) + 2048).astype(numpy.uint32) << shift
        self._words.append(words)

    @renamed(type="message_type")
    def message(self, data: Any, message_type: int, who: Optional[ArrayLike] = None, slot: ArrayLike = 0) -> None:
        """A whole message of nine bytes and a type 0 to 127, said once: to all robots, or, in simulation only, to `who`. `data`:
        nine bytes, or three numbers of 24 bits, most significant byte first. It takes the place of words to three robots."""
        if who is not None and not self.whole_to_one:
            raise ValueError("who: an overhead controller cannot send a whole message to single robots; omit who")
        self._said.setdefault("whole", []).append(
            {"type": self._type(message_type), "data": _nine_bytes(data), "slot": int(self._column("slot", slot, 0, 255, 0)),
             "robots": None if who is None else self.ids[self._rows(who)[0]].tolist()})

    @renamed(type="message_type")
    def parameters(self, data: Any, message_type: int) -> None:
        """What robots have to know before they run: repeated to all of them right before they begin, and before they run after
        a reset. Those of a type that are given in one call of the scenario, such as one for each robot with its id in `data`, replace
        former ones of that type; 64 in all at most. Both arguments as in message()."""
        self._said.setdefault("parameters", []).append({"type": self._type(message_type), "data": _nine_bytes(data)})

    def _type(self, given):
        return int(self._column("message_type", given, 0, 127, 0))

    def _column(self, name, given, low, high, n=None):
        """A number, or one for each row, as integers within low..high."""
        n = len(self.ids) if n is None else n
        if isinstance(given, (int, numpy.integer)) and low <= given <= high:  # the usual one, at once
            return numpy.int64(given)
        given = numpy.asarray(given)
        if given.shape not in ((), (n,)):
            raise ValueError(f"{name} must be one number, or {n} of them, not an array of shape {given.shape}")
        if given.dtype.kind == "b":
            given = given.view(numpy.uint8)
            if low <= 0 and high >= 1:
                return given
        if given.dtype.kind not in "iuf" or (given.dtype.kind == "f" and not (given == numpy.floor(given)).all()):
            raise ValueError(f"{name} must be whole numbers, without NaN")
        if given.size and (given.min() < low or given.max() > high):
            raise ValueError(f"{name} must be {low} to {high}, not {given.min()} to {given.max()}")
        return given

    def _chosen(self, name, given, low, high, rows, by_ids):
        """As _column, of the robots at `rows`: a number, or one for each. Where `rows` are no ids, `given` has all robots'; what it
        has of others does not matter, such as NaN of robots that were never seen."""
        if not isinstance(given, (int, numpy.integer)) and not by_ids and (given := numpy.asarray(given)).shape == self.ids.shape:
            given = given[rows]
            return self._column(name, given, low, high, len(given))
        return self._column(name, given, low, high, len(rows) if by_ids else None)

    def _rows(self, who):
        """The rows that are meant, and whether they were named by ids, and not by a mask."""
        who = numpy.asarray(who)
        if who.dtype.kind in "iu":
            who = numpy.atleast_1d(who)
            rows = numpy.searchsorted(self.ids, who)
            known = (rows < len(self.ids)) & (self.ids[numpy.minimum(rows, max(0, len(self.ids) - 1))] == who if len(self.ids) else False)
            if not known.all():
                raise ValueError(f"this lab has no robot {who[~known][0]}")
            return rows, True
        if who.dtype.kind == "b" and who.shape == self.ids.shape:
            return numpy.flatnonzero(who), False
        if who.size == 0:
            return numpy.zeros(0, dtype=int), False
        raise ValueError(f"who must be a mask of {len(self.ids)} rows, or ids, not an array of {who.dtype} of shape {who.shape}")

    def _say(self, who, kind, value, slot, how, every_s=0.0):
        who = numpy.asarray(who)
        if who.dtype == bool and who.shape == self.ids.shape and who.tobytes().find(0) < 0:
            rows, by_ids = slice(None), False  # of all, as they lie
        else:
            rows, by_ids = self._rows(who)
        words = numpy.ndarray(len(self.ids), WORD, bytearray(self._to_all))[rows]
        columns = [("kind", kind, self.kinds - 1), ("value", value, self.values - 1), ("slot", slot, _WHEELS - 1 if self.wheels_m_per_s else 255)]
        for name, given, high in columns:
            if type(given) is int and given == 0:  # as it mostly is
                continue
            words[name] = self._chosen(name, given, 0, high, rows, by_ids)
        how = numpy.asarray(how)
        words["how"] = how if how.ndim == 0 else how[rows]
        if every_s > 0:
            said = self._said_s.setdefault(int(self._column("slot, with every_s,", slot, 0, 255, 0)), numpy.full(len(self.ids), -math.inf))
            due = self.now_s - said[rows] >= every_s - 1e-6  # of rounding
            said[rows] = numpy.where(due, self.now_s, said[rows])
            words = words[due]
        self._words.append(words)

    # --- what labs share ---
    def declare(self, name: str, length: int = 1, low: int = 0, high: int = 1_000_000, owner_only: bool = False, initial_only: bool = False,
                up_to: bool = False) -> None:
        """In begin() only, and alike in all labs: each lab has a field of this name, of `length` whole numbers from `low` to `high`, or, `up_to`
        true, of so many at most. `owner_only`: only the owner (shared.owner) publishes it. `initial_only`: it is published in begin(), and
        stays as it is. What a lab publishes against this ends its run; what a peer does is refused and counted."""
        if name in self._rules or str(name).startswith("kit."):
            raise ValueError(f"field {name!r} is {'declared already' if name in self._rules else 'one of the kit'}; give another name")
        self._rules[name] = (length, up_to)
        self._said.setdefault("declare", []).append(
            {"name": name, "length": int(length), "low": int(low), "high": int(high), "owner_only": bool(owner_only),
             "initial_only": bool(initial_only), "up_to": bool(up_to)})

    def publish(self, name: str, values: ArrayLike) -> None:
        """Sets an own field: whole numbers. It is in force in all labs once it is merged."""
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
        """A lab's field as merged last, or, of one with `initial_only`, as it was at the start; empty when it has said none."""
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
        return b"".join(each.tobytes() for each in words), said
