"""The kit's pieces as a scenario sees them. The lab computes them (scenarios/kit), for C++ and Python alike; their arrays come with
each frame, one row for each robot of the lab, NaN for robots that were never seen."""
import math

import numpy


def _number(name, value, low=-math.inf, high=math.inf):
    value = float(value)
    if not low <= value <= high:
        raise ValueError(f"{name} must be {low:g} to {high:g}, and is {value:g}")
    return value


class Piece:
    columns = 1

    def __init__(self, lab, number):
        self._lab, self._number = lab, number
        self.sensed = numpy.full((len(lab.ids), self.columns), numpy.nan)

    def _see(self, rows, sensed):
        if rows is None:
            self.sensed = sensed
        else:
            self.sensed = self.sensed.copy()  # a scenario may keep the former one
            self.sensed[rows] = sensed


class Eyes(Piece):
    """What is near in each sector: `distance` (n, sectors) in metres, infinite where nothing is within reach."""

    def __init__(self, lab, number, sectors):
        self.columns = sectors
        super().__init__(lab, number)

    @property
    def distance(self):
        return numpy.where(self.sensed < 0, numpy.inf, self.sensed)

    @property
    def bits(self):
        """Of each robot, one number: a bit for each sector in which something is near, the first sector's highest."""
        return (self.sensed >= 0) @ (1 << numpy.arange(self.columns - 1, -1, -1))


class Crowd(Piece):
    """`count` (n): how many robots are near each robot."""

    @property
    def count(self):
        return self.sensed[:, 0]


class Trail(Piece):
    """Pheromone of the shared world. `value` (n) under each robot, `gradient` (n, 2) along x and y of this arena per metre of it,
    `zones` (n) as bits, the rightmost zone's lowest."""

    columns = 4

    @property
    def value(self):
        return self.sensed[:, 0]

    @property
    def gradient(self):
        return self.sensed[:, 1:3]

    @property
    def zones(self):
        return numpy.nan_to_num(self.sensed[:, 3]).astype(int)

    def lay(self, who, amount=1.0):
        """In frame(): the robots `who` (a mask over the rows, or ids) lay so much, one number or one for each of them, where the frame
        has them. All labs have it from the next boundary on."""
        rows, by_ids = self._lab._rows(who)
        amount = numpy.asarray(amount, dtype=float)
        if amount.shape not in ((), (len(rows),) if by_ids else (len(self._lab.ids),)) or not numpy.isfinite(amount).all() or (amount < 0).any():
            raise ValueError(f"amount is one number of 0 or more, or one for each robot, and has the shape {amount.shape}")
        each = numpy.broadcast_to(amount, len(rows)) if amount.ndim == 0 or by_ids else amount[rows]
        if len(rows):
            self._lab._said.setdefault("kit_acts", []).append(
                {"piece": self._number, "robots": self._lab.ids[rows].tolist(), "amounts": each.tolist()})


class Kit:
    """The methods of a Lab that ask for pieces, each in begin() only."""

    def eyes(self, sectors=8, reach=0.1, around=False, robots=0.0):
        """A virtual proximity sensor for walls and obstacles: 1 to 16 equal sectors of the half circle in front, the leftmost first, or
        `around` the robot, counter-clockwise from straight ahead. `reach` in metres from the robot's centre. `robots`: robots of other
        labs are seen, too, as discs of that radius in this arena: a no-walk zone."""
        sectors = int(sectors)
        _number("sectors", sectors, 1, 16)
        return self._piece(Eyes, {"piece": "eyes", "sectors": sectors, "reach": _number("reach", reach, 1e-6, 1e3), "around": bool(around),
                                  "robots": _number("robots", robots, 0, 1e3)}, sectors)

    def crowd(self, range, leds=None, others=True):  # pylint: disable=redefined-builtin
        """How many robots are within `range` metres of each robot: of this lab and, `others` true, of other labs where they are in this
        arena. `leds`: only those whose LED is one of these numbers."""
        leds = sorted({int(led) for led in (numpy.arange(8) if leds is None else numpy.atleast_1d(leds))})
        if not leds or leds[0] < 0 or leds[-1] > 7:
            raise ValueError(f"leds are numbers 0 to 7, and not {leds}")
        return self._piece(Crowd, {"piece": "crowd", "range": _number("range", range, 1e-6, 1e3), "leds": leds, "others": bool(others)})

    def trail(self, name, width, height, cell, half_life=0.0, linear=0.0, diffusion=0.0, wind=(0.0, 0.0), cap=1e6, cut_off=0.0,
              zones=None, full=1.0):
        """Pheromone on a grid around the origin of the shared world, that robots of all labs lay: metres of the shared frame, seconds,
        `diffusion` in m2/s, `wind` in m/s. `zones`: (how many, opening in radians, radius, least value) in front of robots. `full`: what
        people see as darkest; 0 shows nothing. Every lab asks for it alike."""
        if not isinstance(name, str) or not name.isidentifier() or len(name) > 30:
            raise ValueError(f"a trail's name is a word of up to 30 letters, digits and _, and not {name!r}")
        asked = {"piece": "trail", "name": name, "wind": [_number("wind", w) for w in wind],
                 "zones": None if zones is None else [int(zones[0]), *(_number("zones", z) for z in zones[1:4])]}
        for key, value in [("width", width), ("height", height), ("cell", cell), ("half_life", half_life), ("linear", linear),
                           ("diffusion", diffusion), ("cap", cap), ("cut_off", cut_off), ("full", full)]:
            asked[key] = _number(key, value)
        return self._piece(Trail, asked)

    def _piece(self, kind, asked, *more):
        if self._ask is None:
            raise RuntimeError(f"{asked['piece']}: ask for pieces of the kit in begin()")
        self._pieces.append(kind(self, len(self._pieces), *more))
        self._said.setdefault("kit", []).append(asked)
        return self._pieces[-1]
