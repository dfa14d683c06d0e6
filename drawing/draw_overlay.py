"""Draws what a scenario shows people (a message overlay_t) into axes of matplotlib, in metres of its arena.

Colours and patterns are those of view/page/colours.json, so that these pictures, the page and camera pictures agree.
"""
import math

from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle, Patch, Polygon
from matplotlib.patheffects import withStroke

from figure_style import TABLE

DASHES = (0, (3.4, 3))  # short enough for rings of 2 points
HATCH = {"plain": None, "stripes": "////", "dots": "...", "cross": "xxx"}
# What lies over what: robots come above shapes and below words.
RASTERS, POLYGONS, CIRCLES, LINES, WORDS = 0.5, 1.0, 1.2, 1.4, 7.0


def look_of(name, ground="light"):
    """(colour as matplotlib takes it, hatch, what it means); an unknown name looks like a note."""
    colour = TABLE["colours"].get(name, TABLE["colours"]["note"])
    return colour[ground], HATCH[colour["pattern"]], colour["means"]


def shape_style(shape, ground):
    colour, hatch, _ = look_of(shape.colour, ground)
    return {"facecolor": to_rgb(colour) + (TABLE["fill_opacity"] if shape.filled else 0,), "edgecolor": colour,
            "hatch": hatch if shape.filled else None, "linestyle": DASHES if shape.dashed else "-", "linewidth": 0.9}


def words(axes, x_m, y_m, text, name, ground, **how):
    if text:
        axes.text(x_m, y_m, text, color=look_of(name, ground)[0], fontsize=6, zorder=WORDS, parse_math=False, **how,
                  path_effects=[withStroke(linewidth=1.8, foreground="white" if ground == "light" else "black")])


def raster_corner(raster, column, row):
    c, s = math.cos(raster.heading_rad), math.sin(raster.heading_rad)
    along, left = column * raster.cell_m, row * raster.cell_m
    return raster.x_m + c * along - s * left, raster.y_m + s * along + c * left


def draw_raster(axes, raster, ground):
    if raster.columns < 1 or raster.rows < 1 or raster.columns * raster.rows != len(raster.cells):
        return
    rgb = to_rgb(look_of(raster.colour, ground)[0])
    quads, colours = [], []
    for i, value in enumerate(bytes(raster.cells)):
        if value:
            row, column = divmod(i, raster.columns)
            quads.append([raster_corner(raster, column + a, row + b) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))])
            colours.append(rgb + (TABLE["raster_opacity"] * value / 255,))
    axes.add_collection(PolyCollection(quads, facecolors=colours, edgecolors="none", zorder=RASTERS), autolim=False)
    corners = [raster_corner(raster, a, b) for a in (0, raster.columns) for b in (0, raster.rows)]
    words(axes, sum(x for x, _ in corners) / 4, max(y for _, y in corners), raster.label, raster.colour, ground, ha="center", va="bottom")


def draw(axes, overlay, ground="light", told=None):
    """Adds all of its shapes; returns the entries of a legend for the colours that occur, in the table's order, in words that are `told` by colour, else the table's."""
    for raster in overlay.rasters:
        draw_raster(axes, raster, ground)
    for polygon in overlay.polygons:
        corners = [(point.x_m, point.y_m) for point in polygon.corners]
        if not corners:
            continue
        axes.add_patch(Polygon(corners, zorder=POLYGONS, **shape_style(polygon, ground)))
        x_m, y_m = (sum(part) / len(corners) for part in zip(*corners))
        words(axes, x_m, y_m, polygon.label, polygon.colour, ground, ha="center", va="center")
    for circle in overlay.circles:
        axes.add_patch(Circle((circle.x_m, circle.y_m), circle.radius_m, zorder=CIRCLES, **shape_style(circle, ground)))
        words(axes, circle.x_m, circle.y_m + circle.radius_m, circle.label, circle.colour, ground, ha="center", va="bottom")
    for line in overlay.lines:
        colour, _, _ = look_of(line.colour, ground)
        axes.plot([point.x_m for point in line.points], [point.y_m for point in line.points], color=colour, linewidth=1.2,
                  linestyle=DASHES if line.dashed else "-", zorder=LINES)
        if line.points:
            middle = line.points[len(line.points) // 2]
            words(axes, middle.x_m, middle.y_m, line.label, line.colour, ground, ha="center", va="center")
    for text in overlay.texts:
        words(axes, text.x_m, text.y_m, text.text, text.colour, ground, ha="center", va="center")
    return legend(overlay, ground, told or {})


def legend(overlay, ground, told):
    shapes = [*overlay.rasters, *overlay.polygons, *overlay.circles, *overlay.lines, *overlay.texts]
    used = {shape.colour if shape.colour in TABLE["colours"] else "note" for shape in shapes}
    entries = []
    for name in TABLE["colours"]:
        if name in used:
            colour, hatch, means = look_of(name, ground)
            entries.append(Patch(facecolor=to_rgb(colour) + (TABLE["fill_opacity"],), edgecolor=colour, hatch=hatch, label=told.get(name, means)))
    return entries
