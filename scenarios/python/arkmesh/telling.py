"""What a Lab tells its robots."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Optional

import numpy

from .pieces import _number
from .renamed import renamed

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

WORD = numpy.dtype([("robot", "<u4"), ("slot", "u1"), ("kind", "u1"), ("how", "u1"), ("pad", "u1"), ("value", "<u4")])
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


class Telling:
    """The methods of a Lab that send messages to its robots."""

    make: str
    ids: NDArray[numpy.uint32]
    kinds: int
    values: int
    whole_to_one: bool
    wheels_m_per_s: float
    now_s: float
    _words: list[NDArray[Any]]
    _said: dict[str, Any]
    _said_s: dict[int, NDArray[numpy.float64]]
    _not_shown: NDArray[numpy.uint8]
    _to_all: bytes

    def tell(self, who: ArrayLike, kind: ArrayLike = 0, value: ArrayLike = 0, slot: ArrayLike = 0, shown: Optional[ArrayLike] = None) -> None:
        """Tells robots a value until they show it: the lab sends it when it changes, and again each second. Call it for each frame.

        Parameters
        ----------
        who
            (n) a mask over the rows, or ids.
        kind, value, slot
            Whole numbers below `kinds`, `values` and 256: one, or one for each row or id. Kinds that exclude each other share a slot.
        shown
            (n) a mask of robots that show it; by default, a robot shows it when its LED differs from that at the change.

        Raises
        ------
        ValueError
            If a number is out of range or not whole, a shape does not match, or this lab has no robot of that id.
        """
        how = UNTIL_LED_CHANGES if shown is None else self._not_shown - self._column("shown", shown, 0, 1)  # SHOWN is one less
        self._say(who, kind, value, slot, how)

    def say(self, who: ArrayLike, kind: ArrayLike = 0, value: ArrayLike = 0, slot: ArrayLike = 0, every_s: float = 0.0) -> None:
        """Sends robots a value once.

        Parameters
        ----------
        who, kind, value, slot
            As in `tell()`, and refused as there.
        every_s
            Seconds between messages: with a call for each frame, a robot gets the newest value of that slot at this interval; 0: at each call.
        """
        self._say(who, kind, value, slot, ONCE, _number("every_s", every_s, 0, 1e6))

    def drive(self, who: ArrayLike, left: ArrayLike, right: ArrayLike) -> None:
        """Sets the speeds of wheels. They are in force until the next call; the lab repeats them to robots that may have missed them.

        Parameters
        ----------
        who
            (n) a mask over the rows, or ids.
        left, right
            Metres per second, negative backwards: one number, or one for each row or id.

        Raises
        ------
        ValueError
            If robots cannot be driven, or a speed exceeds `wheels_m_per_s`.
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
        """Sends a whole message once. It takes the airtime of values for three robots.

        Parameters
        ----------
        data
            Nine bytes, or three whole numbers of 24 bits, most significant byte first.
        message_type
            0 to 127.
        who
            (n) a mask over the rows, or ids, of simulated robots only. By default all robots.
        slot
            For individual robots, the newest message of a slot replaces unsent older ones, as with `say()`.

        Raises
        ------
        ValueError
            If a number is out of range, or `who` is given in an arena of real robots.
        """
        if who is not None and not self.whole_to_one:
            raise ValueError("who: an overhead controller cannot send a whole message to individual robots; omit who")
        self._said.setdefault("whole", []).append(
            {"type": self._type(message_type), "data": _nine_bytes(data), "slot": int(self._column("slot", slot, 0, 255, 0)),
             "robots": None if who is None else self.ids[self._rows(who)[0]].tolist()})

    @renamed(type="message_type")
    def parameters(self, data: Any, message_type: int) -> None:
        """Sends messages to all robots right before they start, and before they run after a reset.

        The messages of one type from one call of the scenario, such as one per robot with its id in `data`, replace earlier ones of that type.

        Parameters
        ----------
        data, message_type
            As in `message()`, and refused as there; at most 64 messages in all.
        """
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
