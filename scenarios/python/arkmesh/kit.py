"""The calls of a Lab that ask for the kit's pieces (pieces.py)."""
from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any, Optional, Sequence

import numpy

from .pieces import Crowd, Eyes, Floor, Gps, Light, Region, Towards, Trail, Voices, _callers_line, _leds, _name, _number, _pair, _tiles_of, _whole
from .renamed import renamed

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


class Kit:
    """The methods of a Lab that create pieces of the kit, in begin() only. Of pieces that robots sense, `noise` is the standard deviation of a
    reading's normal error, in the reading's unit, and `every_s` the seconds between readings, the same for all robots; 0: a reading each
    frame. A robot missing in a frame keeps its last reading. Every method raises ValueError if an argument is invalid, and RuntimeError after begin().
    """

    name: str
    ids: NDArray[numpy.uint32]
    scale: float
    width_m: float
    height_m: float
    _alike: dict[str, str]
    _file: Any
    _files: dict[str, bytes]

    def eyes(self, sectors: int = 8, reach: float = 0.1, around: bool = False, robots: Optional[float] = None, margin: float = 0.0,
             half_planes: bool = False, noise: ArrayLike = 0.0, every_s: float = 0.0) -> Eyes:
        """Creates a virtual proximity sensor for walls, obstacles and robots of other labs.

        Parameters
        ----------
        sectors
            Number of equal sectors of the half circle in front, 1 to 16; the first is the leftmost.
        reach
            Range in metres of this arena, from the robot's centre.
        around
            Sectors cover the full circle, counter-clockwise; the first begins straight ahead.
        robots
            Radius, in metres of this arena, of the discs by which robots of other labs are sensed, unless sensors.presence is "none". By
            default they are sensed only where that key is "no-walk".
        margin
            Metres by which obstacles appear nearer.
        half_planes
            As in the software published with M-ARK, a wall within reach fills all sectors in front that lie wholly within 90 degrees of
            its direction; so does the nearest of obstacles and robots.
        noise, every_s
            Of distances, in metres; in seconds.

        Returns
        -------
        Eyes
            Arrays `distance` and `bits`, updated with each frame.
        """
        sectors = _whole("sectors", sectors, 1, 16)
        if half_planes and around:
            raise ValueError("half_planes cover the half circle in front; omit around")
        return self._sensor(Eyes, {"piece": "eyes", "sectors": sectors, "reach": _number("reach", reach, 1e-6, 1e3), "around": bool(around),
                                   "margin": _number("margin", margin, 0, 1e3), "half_planes": bool(half_planes),
                                   "robots": None if robots is None else _number("robots", robots, 0, 1e3)}, noise, every_s, sectors)

    @renamed(range="reach")
    def crowd(self, reach: float, leds: Optional[ArrayLike] = None, others: bool = True, noise: ArrayLike = 0.0, every_s: float = 0.0) -> Crowd:
        """Creates a sensor that counts robots near each robot.

        Parameters
        ----------
        reach
            Range in metres of this arena, between centres.
        leds
            LED numbers, 0 to 8, of the robots to count; by default all.
        others
            Also count robots of other labs in this arena, unless sensors.presence is "none".
        noise, every_s
            Of the count, in robots; in seconds.

        Returns
        -------
        Crowd
            Array `count`, updated with each frame.
        """
        return self._sensor(Crowd, {"piece": "crowd", "range": _number("reach", reach, 1e-6, 1e3), "leds": _leds(leds), "others": bool(others)}, noise, every_s)

    def trail(self, name: str, width: float, height: float, cell: float, half_life: float = 0.0, linear: float = 0.0, diffusion: float = 0.0,
              wind: ArrayLike = (0.0, 0.0), cap: float = 1e6, cut_off: float = 0.0, zones: Optional[Sequence[float]] = None, full: float = 1.0) -> Trail:
        """Creates pheromone on a grid around the origin of the shared world, laid by robots of all labs. Every lab must create it alike.

        Parameters
        ----------
        name
            Name of the trail, a word of up to 30 letters, digits and _.
        width, height, cell
            Sides of the grid and of a cell, in metres of the shared world.
        half_life, linear
            Half-life in seconds; linear decay in amount per second; 0: none.
        diffusion
            Diffusion coefficient in m2/s.
        wind
            (2) velocity along x and y, in m/s.
        cap, cut_off
            Largest amount that a cell holds; amount below which it holds none.
        zones
            (number, opening in radians, radius in metres, least amount) of sensing zones in front of robots.
        full
            Amount drawn darkest; 0: draw nothing.

        Returns
        -------
        Trail
            Arrays `value`, `gradient` and `zones`, updated with each frame; `lay()` adds pheromone.
        """
        asked = {"piece": "trail", "name": _name("a trail", name), "wind": _pair("wind", wind), "zones": None, "full": _number("full", full, 0)}
        if zones is not None:
            if numpy.shape(zones) != (4,):
                raise ValueError(f"zones must be a number, an opening, a radius and a least value, not {zones!r}")
            asked["zones"] = [_whole("the number of zones", zones[0], 1, 32), *(_number("zones", z, 0) for z in zones[1:])]
        for key, value in [("width", width), ("height", height), ("cell", cell), ("half_life", half_life), ("linear", linear),
                           ("diffusion", diffusion), ("cap", cap), ("cut_off", cut_off)]:
            asked[key] = _number(key, value, 0)
        self._must_be_alike("trail", name, {key: value for key, value in asked.items() if key not in ("zones", "full")})
        return self._piece(Trail, asked)

    def region(self, centre: Optional[ArrayLike] = None, radius: Optional[float] = None, corners: Optional[ArrayLike] = None,
               resource: Optional[dict[str, Any]] = None, leds: Optional[ArrayLike] = None, label: str = "", colour: str = "note") -> Region:
        """Creates a disc or a polygon of the shared world, and draws it.

        Parameters
        ----------
        centre, radius
            (2) centre and radius of a disc, in metres.
        corners
            (n, 2) corners of a polygon, in metres.
        resource
            A stock that robots inside consume, as a dict of capacity (1), growth (rate of logistic growth, 1/s), rate (share of the capacity that a robot
            takes, 1/s), pairs (true: each of n robots takes n times as much), shared (true: all together take no more than one robot) and
            regrows_below (stock below which it is full again).
        leds
            LED numbers, 0 to 8, of the robots that count and use the resource; by default all.
        label, colour
            Text beside it, and colour by its meaning, as in circle().

        Returns
        -------
        Region
            Array `inside`, updated with each frame, and `robots`, `stock` and `share` as of the last boundary.
        """
        if (centre is None) == (corners is None) or (centre is None) != (radius is None):
            raise ValueError("a region needs centre and radius, or corners")
        known = {"capacity": 1.0, "growth": 0.0, "rate": 0.0, "pairs": False, "shared": False, "regrows_below": 0.0}
        if resource is not None:
            if not isinstance(resource, dict) or set(resource) - set(known):
                raise ValueError(f"a resource must be a dict with any of {', '.join(known)}, not {resource!r}")
            resource = {**known, **resource}
            if resource["pairs"] and resource["shared"]:
                raise ValueError("a resource is used by pairs or shared, not both")
            resource = {key: bool(value) if key in ("pairs", "shared") else _number(f"{key} of a resource", value, 0) for key, value in resource.items()}
        places = numpy.asarray([centre] if corners is None else corners, dtype=float)
        if places.ndim != 2 or places.shape[1] != 2 or not numpy.isfinite(places).all():
            raise ValueError(f"places of a region must be pairs of numbers, not an array of shape {places.shape}")
        asked = {"piece": "region", "corners": places.tolist(), "radius": None if radius is None else _number("radius", radius, 0), "resource": resource, "leds": _leds(leds)}
        if resource is not None:
            self._must_be_alike("resource", sum(key.startswith("resource.") for key in self._alike), asked)
        piece = self._piece(Region, {**asked, "label": str(label), "colour": str(colour)})
        piece._merge(numpy.array([0.0, resource["capacity"] if resource else 0.0, 0.0]))  # until the first boundary
        return piece

    def floor(self, name: str, width: float, height: float, columns: int, rows: int, shares: Sequence[float] = (1, 1), patch: int = 0,
              tiles: Optional[ArrayLike] = None, image: Optional[str] = None, levels: int = 2, noise: ArrayLike = 0.0, every_s: float = 0.0) -> Floor:
        """Creates tiles around the origin of the shared world, equal in all labs: random, given, or read from an image.

        Parameters
        ----------
        name
            Name of the floor; together with run.seed it determines random tiles.
        width, height
            Sides of the floor in metres of the shared world.
        columns, rows
            Numbers of tiles, 1 to 1000 each.
        shares
            Relative frequency of each level of random tiles.
        patch
            Random tiles of a level form patches about 2 * `patch` + 1 tiles wide.
        tiles
            (rows, columns) of given levels, 0 to 255, lowest row first.
        image, levels
            Image file beside the scenario, and the number of levels for its greys, 0 the lightest.
        noise, every_s
            Of the level; in seconds.

        Returns
        -------
        Floor
            Array `level`, updated with each frame.
        """
        columns, rows = _whole("columns", columns, 1, 1000), _whole("rows", rows, 1, 1000)
        if image is not None:
            if tiles is not None:
                raise ValueError("a floor needs tiles or an image, not both")
            tiles = _tiles_of(self._file, self._files, image, columns, rows, _whole("levels", levels, 2, 256))
        if tiles is not None:
            tiles = numpy.asarray(tiles)
            if tiles.shape != (rows, columns):
                raise ValueError(f"tiles must be {rows} x {columns} levels of 0 to 255, not an array of shape {tiles.shape}")
            if tiles.dtype.kind not in "buif" or not ((tiles >= 0) & (tiles <= 255) & (tiles == numpy.floor(tiles))).all():
                raise ValueError("tiles must be whole numbers from 0 to 255")
            shares = [1] * (int(tiles.max()) + 1 if tiles.max() > 0 else 2)
            if image is not None:
                shares = [1] * int(levels)
            tiles = tiles.astype(int).ravel().tolist()
        asked = {"piece": "floor", "name": _name("a floor", name), "width": _number("width", width, 0), "height": _number("height", height, 0), "columns": columns,
                 "rows": rows, "shares": [_number("a share", s, 0) for s in shares], "patch": _whole("patch", patch, 0, 1000), "tiles": tiles}
        self._must_be_alike("floor", name, asked)
        return self._sensor(Floor, asked, noise, every_s)

    def towards(self, place: ArrayLike, noise: ArrayLike = (0.0, 0.0), every_s: float = 0.0) -> Towards:
        """Creates a sensor for bearing and distance to a place.

        Parameters
        ----------
        place
            (2) position in metres of the shared world.
        noise, every_s
            (2) of the bearing in radians, and of the distance in metres; in seconds.

        Returns
        -------
        Towards
            Arrays `bearing` and `distance`, updated with each frame.
        """
        x, y = _pair("place", place, -1e4, 1e4)
        return self._sensor(Towards, {"piece": "towards", "x": x, "y": y}, noise, every_s, count=2)

    def gps(self, columns: int = 32, rows: int = 32, headings: int = 32, width: Optional[float] = None, height: Optional[float] = None,
            noise: ArrayLike = (0.0, 0.0), every_s: float = 0.0) -> Gps:
        """Creates a sensor for each robot's pose in the shared world, in few bits.

        Parameters
        ----------
        columns, rows, headings
            Numbers of cells around the origin, and of directions, 1 to 65536 each.
        width, height
            Sides of the grid in metres of the shared world; by default those of this arena.
        noise, every_s
            (2) of x and y in metres, and of the heading in radians; in seconds.

        Returns
        -------
        Gps
            Arrays `column`, `row` and `heading`, updated with each frame.
        """
        cells = [_whole(name, n, 1, 65536) for name, n in (("columns", columns), ("rows", rows), ("headings", headings))]
        size = [self.scale * side if given is None else _number(name, given, 1e-6, 1e6)
                for name, given, side in (("width", width, self.width_m), ("height", height, self.height_m))]
        piece = self._sensor(Gps, {"piece": "gps"}, noise, every_s, 3, count=2)
        piece.cells, piece.size = cells, size
        return piece

    def light(self, ambient: float = 0.0, slope: ArrayLike = (0.0, 0.0), beams: Sequence[dict[str, Any]] = (), noise: ArrayLike = 0.0,
              every_s: float = 0.0) -> Light:
        """Creates virtual light of the shared world, sensed as a Kilobot's light sensor would, 0 to 1023.

        Parameters
        ----------
        ambient
            Level at the origin.
        slope
            (2) increase of the level per metre along x and y.
        beams
            Dicts of path (one place, or several visited in a loop; metres), radius (0.1 m), level (1023) and speed (0 m/s).
        noise, every_s
            Of the level; in seconds.

        Returns
        -------
        Light
            Array `level`, updated with each frame.
        """
        given = []
        for beam in beams:
            if not isinstance(beam, dict) or "path" not in beam or set(beam) - {"path", "radius", "level", "speed"}:
                raise ValueError(f"a beam needs a path, and may have radius, level and speed, not {beam!r}")
            path = numpy.asarray(beam["path"], dtype=float).reshape(-1, 2)
            if not numpy.isfinite(path).all():
                raise ValueError("a beam's path must be places, as pairs of numbers")
            given.append({"path": path.tolist(), "radius": _number("radius", beam.get("radius", 0.1), 1e-6, 1e4),
                          "level": _number("level", beam.get("level", 1023), -1e6, 1e6), "speed": _number("speed", beam.get("speed", 0), 0, 1e3)})
        return self._sensor(Light, {"piece": "light", "ambient": _number("ambient", ambient, -1e6, 1e6), "slope": _pair("slope", slope, -1e6, 1e6),
                                    "beams": given}, noise, every_s)

    @renamed(range="reach")
    def voices(self, name: str, values: int, reach: Optional[float] = None, graph: Optional[Sequence[Any]] = None) -> Voices:
        """Creates messages from robots to robots of all labs, within reach or along a graph.

        Parameters
        ----------
        name
            Name of the voices, a word of up to 30 letters, digits and _.
        values
            Number of values, 1 to 64.
        reach
            Range in metres of the shared world.
        graph
            Pairs of robots, each as (lab, id).

        Returns
        -------
        Voices
            Array `heard`, updated with each frame; `say()` sets what robots send.
        """
        values = _whole("values", values, 1, 64)
        if (reach is None) == (graph is None):
            raise ValueError("voices need a reach or a graph")
        if graph is not None:
            try:
                graph = [[[str(lab), _whole("an id", robot, 0, 2**32 - 1)] for lab, robot in pair] for pair in graph]
            except (TypeError, ValueError):
                graph = [[]]
            if any(len(pair) != 2 for pair in graph):
                raise ValueError("a graph must be pairs of robots, each (lab, id)")
            for lab, robot in (end for pair in graph for end in pair):
                if lab == self.name and robot not in self.ids:
                    raise ValueError(f"a graph joins robot {robot} of {lab}, which this lab does not have")
        asked = {"piece": "voices", "name": _name("voices", name), "values": values, "graph": graph, "range": None if reach is None else _number("reach", reach, 1e-6, 1e4)}
        self._must_be_alike("voices", name, asked)
        return self._piece(Voices, asked, values)

    def _must_be_alike(self, kind, name, asked):
        """What labs would otherwise compute differently is compared before they run, as the setting KIND.NAME."""
        kinds = ("trail", "voices") if kind in ("trail", "voices") else (kind,)  # these two share the fields of states
        if any(f"{each}.{name}" in self._alike for each in kinds):
            raise ValueError(f"there is a {' or '.join(kinds)} {name!r} already; choose another name")
        text = json.dumps(asked)
        self._alike[f"{kind}.{name}"] = text if len(text) <= 300 else hashlib.sha256(text.encode()).hexdigest()[:16]

    def _sensor(self, kind, asked, noise, every_s, *more, count=1):
        given = [_number("noise", n, 0, 1e6) for n in numpy.atleast_1d(noise)]
        if len(given) != count:
            raise ValueError(f"noise must be {'one number' if count == 1 else f'{count} numbers'}")
        return self._piece(kind, {**asked, "noise": given if count > 1 else given[0], "every": _number("every_s", every_s, 0, 1e6)}, *more)

    def _piece(self, kind, asked, *more):
        if self._ask is None:
            raise RuntimeError(f"{asked['piece']}: ask for pieces of the kit in begin()")
        asked["number"], asked["where"] = len(self._pieces), _callers_line()
        self._pieces.append(kind(self, len(self._pieces), *more))
        self._said.setdefault("kit", []).append(asked)
        return self._pieces[-1]
