"""What a Lab shows people: rows of tables, counts and drawings."""
from __future__ import annotations

import math
import pathlib
import re
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

OWN_TABLES = ("hash", "audit", "curves")  # of each lab
OWN_COLUMNS = ("run", "setting", "seed", "state", "why", "final_hash", "periods", "duration_s")  # of a batch's table, beside counts


class Showing:
    """The methods of a Lab for tables, counts and drawings. They do not influence the run."""

    _said: dict[str, Any]
    _columns: dict[str, list[str]]
    _colours: Optional[list[str]]
    _column: Any
    _ask: Any
    _settings: dict[str, Any]
    _file: pathlib.Path

    def row(self, table: str, /, **values: Any) -> None:
        """Writes a row of TABLE.csv in the run's folder.

        Parameters
        ----------
        table
            Name of the table, of a-z, 0-9 and _.
        **values
            The columns by name; the first row sets their order.

        Raises
        ------
        ValueError
            If the columns differ from the first row's, or a name or value contains a comma, quote or line end.
        """
        if not re.fullmatch("[a-z][a-z0-9_]{0,63}", table) or table in OWN_TABLES:
            raise ValueError(f"row of {table!r}: a table's name consists of a-z, 0-9 and _, at most 64, and is not {' or '.join(OWN_TABLES)}")
        columns = self._columns.setdefault(table, list(values))
        if not values or set(columns) != set(values):
            differ = [f"{what} {', '.join(names)}" for what, names in (("without", [c for c in columns if c not in values]),
                                                                      ("with", [v for v in values if v not in columns])) if names]
            raise ValueError(f"row of {table!r}: its columns are {', '.join(columns)}, and this row is {' and '.join(differ)}" if values and columns
                             else f"row of {table!r}: a row has a column at least")
        cells = [str(values[name]) for name in columns]
        if "" in columns or any(set(c) & set(',"\r\n') for c in (*columns, *cells)):
            raise ValueError(f"row of {table!r}: names and values must not contain commas, quotes or line ends, and a name must not be empty")
        self._said.setdefault("rows", []).append([table, ",".join(columns), ",".join(cells)])

    def count(self, name: str, n: int = 1) -> None:
        """Adds to a total of this lab. The run's result has the sum of all labs as `name`, and each lab's total as `name@LAB`.

        Parameters
        ----------
        name
            One line of text without @.
        n
            Whole number to add, 0 or more.

        Raises
        ------
        ValueError
            If the name is empty, has several lines or @, or is a column of a batch's table; or `n` is not a whole number from 0.
        """
        if not str(name).strip() or not str(name).isprintable() or "@" in str(name) or name in OWN_COLUMNS:
            raise ValueError(f"count {name!r}: a name must be one line without @, and not one of {', '.join(OWN_COLUMNS)}")
        self._said.setdefault("counts", []).append([str(name), int(self._column("a count", n, 0, 2**53, 0))])

    def show(self, name: str, words: str = "", unit: str = "", curve: bool = False) -> None:
        """Sets how pages and figures describe a count, a column or a setting; in begin() only.

        Parameters
        ----------
        name
            A count, a column of a table, "TABLE.COLUMN", or a setting that was requested.
        words, unit
            Label and unit.
        curve
            Draw it over lab time, in the order of these calls.

        Raises
        ------
        ValueError
            If a text is longer than 120 bytes, or a name contains a comma, quote or @.
        RuntimeError
            After begin().
        """
        asked = self._settings.get(name)
        if asked:
            return self._show(f"setting.{'sensors' if asked['own'] else 'scenario'}.{self._file.stem}.{name}", words, unit or asked["unit"])
        return self._show(f"series.{name}", words, unit, bool(curve))

    def legend(self, of: Union[str, int], words: str) -> None:
        """Explains a colour in the legends of pages and figures; in begin() only.

        Parameters
        ----------
        of
            A drawing colour by its meaning, or an LED, 0 to 8.
        words
            Its meaning.

        Raises
        ------
        ValueError
            If there is no such colour or LED.
        RuntimeError
            After begin().
        """
        if of not in (self._colours or [of]) if isinstance(of, str) else not 0 <= of <= 8:
            raise ValueError(f"legend of {of!r}: must be an LED, 0 to 8, or one of {', '.join(self._colours or [])}")
        self._show(f"colour.{of}" if isinstance(of, str) else f"led.{int(of)}", words)

    def _show(self, of, words, unit="", curve=False):
        if self._ask is None:
            raise RuntimeError(f"{of}: declare in begin() how it is shown")
        for each in (of, words, unit):
            if not isinstance(each, str) or not each.isprintable() or len(each.encode()) > 120 or set(of) & set('",@'):
                raise ValueError(f"{each!r}: names, words and units must be one line of at most 120 bytes, and names must not contain commas, quotes or @")
        self._said.setdefault("shown", []).append({"of": of, "words": words, "unit": unit, "curve": curve})

    def circle(self, at: ArrayLike, radius: float, colour: str = "note", filled: bool = False, dashed: bool = False, label: str = "") -> None:
        """Draws circles in this arena until the next boundary; in period().

        Parameters
        ----------
        at
            (2) or (n, 2) centres, in metres of this arena.
        radius
            Metres.
        colour
            By its meaning, such as "site_easy", "resource", "pheromone" or "note".
        filled, dashed, label
            Style, and text beside it.

        Raises
        ------
        ValueError
            If a number is NaN or infinite, or there is no such colour.
        """
        self._draw("circle", at, colour, filled, dashed, label, float(radius))

    def polygon(self, corners: ArrayLike, colour: str = "note", filled: bool = False, dashed: bool = False, label: str = "") -> None:
        """Draws a polygon; see circle().

        Parameters
        ----------
        corners
            (n, 2) metres of this arena.
        colour, filled, dashed, label
            As of circle().
        """
        self._draw("polygon", corners, colour, filled, dashed, label)

    def line(self, points: ArrayLike, colour: str = "note", dashed: bool = False, label: str = "") -> None:
        """Draws a line through points; see circle().

        Parameters
        ----------
        points
            (n, 2) metres of this arena.
        colour, dashed, label
            As of circle().
        """
        self._draw("line", points, colour, False, dashed, label)

    def text(self, at: ArrayLike, text: str, colour: str = "note") -> None:
        """Draws a text; see circle().

        Parameters
        ----------
        at
            (2) centre of the text, in metres of this arena.
        text
            One line.
        colour
            As of circle().
        """
        self._draw("text", at, colour, False, False, text)

    def raster(self, corner: ArrayLike, cell: float, values: ArrayLike, heading: float = 0.0, colour: str = "pheromone", label: str = "") -> None:
        """Draws a quantity on a grid; see circle().

        Parameters
        ----------
        corner
            (2) corner at which the first row begins, in metres of this arena.
        cell
            Side of a cell in metres.
        values
            (rows, columns) from 0, transparent, to 1, opaque; rows run along `heading`, each to the left of the one before.
        heading
            Radians from +x, counter-clockwise.
        colour, label
            As of circle().

        Raises
        ------
        ValueError
            If values are not (rows, columns) from 0 to 1.
        """
        values = numpy.asarray(values, dtype=float)
        if values.ndim != 2 or not numpy.isfinite(values).all() or not (0 <= values).all() or not (values <= 1).all():
            raise ValueError(f"a raster's values must be (rows, columns) from 0 to 1, not an array of shape {values.shape}")
        self._draw("raster", corner, colour, False, False, label)
        self._said["draw"][-1].update(heading=float(heading), cell_m=float(cell), columns=values.shape[1],
                                      cells=numpy.rint(values * 255).astype(numpy.uint8).tobytes().hex())

    def _draw(self, shape, points, colour, filled, dashed, label, radius=0.0):
        points = numpy.asarray(points, dtype=float).reshape(-1, 2)
        if not numpy.isfinite(points).all() or not math.isfinite(radius):
            raise ValueError(f"places and sizes of a {shape} must be numbers, without NaN")
        if self._colours and colour not in self._colours:
            raise ValueError(f"colour {colour!r} is not one of {', '.join(self._colours)}")
        self._said.setdefault("draw", []).append(
            {"shape": shape, "points": points.astype("<f8").tobytes().hex(), "radius": radius, "colour": colour, "filled": bool(filled),
             "dashed": bool(dashed), "label": str(label)})
