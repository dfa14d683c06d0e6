"""A run's arenas at one moment, and what it counted below them, as axes of matplotlib. drawing/plot and arkmesh.Run.plot draw with it."""
import csv
import json
import math
import struct
import tomllib

from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle

import draw_overlay
import figure_style
import read_log
from figure_style import LED_NAMES, LEDS, Refused

LAB = ["#d95f02", "#1b6ca8", "#66a61e", "#7f4fa0", "#a6761d"]


class Lab:
    """One lab at one moment, from its folder of the run."""

    def __init__(self, folder, at_s):
        self.folder = folder
        chosen = arena = overlay = shown = None
        self.last_s = 0  # of all moments that it has
        log = read_log.log_in(folder)
        for _, channel, data in read_log.events(log):
            if channel == "arena":
                arena = data
            elif channel == "shown":
                shown = data
            elif channel == "shared":
                stamp_s = self.last_s = struct.unpack(">q", data[8:16])[0] / 1e6
                if chosen is None or at_s is None or stamp_s <= at_s:
                    chosen = data
            elif channel == "overlay":
                stamp_s = struct.unpack(">q", data[8:16])[0] / 1e6
                if overlay is None or at_s is None or stamp_s <= at_s:
                    overlay = data
        if arena is None or chosen is None:
            raise Refused(f"{log} holds no complete period yet; nothing to draw.")
        self.arena, self.view = read_log.decode(arena), read_log.decode(chosen)
        self.overlay = read_log.decode(overlay) if overlay else None  # None of another version's, too
        if self.arena is None or self.view is None:
            raise Refused(f"{log} is from another version of arkmesh; draw it with the version that recorded it.")
        self.name = self.arena.lab
        self.body_radius_m = self.arena.body_radius_m
        self.bodies_m = {}  # of other labs' robots, where their labs are known
        config = folder / "config.toml"
        settings = tomllib.loads(config.read_text()) if config.is_file() else {}
        told = {each.of: each.words for each in (getattr(read_log.decode(shown), "words", []) if shown else []) if each.words}
        self.means = {of.partition(".")[2]: words for of, words in told.items() if of.startswith("colour.")}
        self.led_says = {int(of.partition(".")[2]): words for of, words in told.items() if of.startswith("led.")}
        self.seed = settings.get("run", {}).get("seed")
        projections = settings.get("shared", {}).get("projection", {})
        self.scale_of = {view.lab: projections.get(view.lab, {}).get("scale", 1) for view in self.view.labs}

    def in_arena(self, x_um, y_um, heading_urad=0):
        """Shared frame to this arena's frame: the projection backwards."""
        v = self.view
        x, y = x_um / 1e6 - v.shift_x_m, y_um / 1e6 - v.shift_y_m
        c, s = math.cos(v.turn_rad), math.sin(v.turn_rad)
        return (c * x + s * y) / v.scale, (c * y - s * x) / v.scale, heading_urad / 1e6 - v.turn_rad


def rows_of(folder, table):
    """Whole rows of a table of a run; the last may be cut."""
    file = folder / f"{table}.csv"
    if not file.is_file():
        return None
    with open(file, newline="") as text:
        rows = list(csv.reader(text))
    header = rows[0] if rows else []
    return [dict(zip(header, row)) for row in rows[1:] if len(row) == len(header) and row[-1] != ""]


def draw_robots(axes, lab):
    for other in lab.view.labs:
        own = other.lab == lab.name
        for robot in other.robots:
            x, y, heading = lab.in_arena(robot.x_um, robot.y_um, robot.heading_urad)
            colour = LEDS[min(robot.led, 8)]
            tip = (x + lab.body_radius_m * math.cos(heading), y + lab.body_radius_m * math.sin(heading))
            if own:
                axes.add_patch(Circle((x, y), lab.body_radius_m, facecolor=colour, edgecolor="black", linewidth=0.6, zorder=5))
                axes.plot([x, tip[0]], [y, tip[1]], color="black", linewidth=1, zorder=6)
            else:
                # As large as its own lab sees it, in the shared world.
                radius = lab.bodies_m.get(other.lab, lab.body_radius_m) * lab.scale_of[other.lab] / lab.view.scale
                axes.add_patch(Circle((x, y), radius, facecolor="none", edgecolor=colour, linewidth=1, alpha=0.7, zorder=4))


def draw_arena(axes, lab):
    """Wall, drawings and robots; returns the drawings' entries of a legend."""
    wide, high = lab.arena.width_m, lab.arena.height_m
    axes.add_patch(Rectangle((-wide / 2, -high / 2), wide, high, fill=False, linewidth=1.5))
    margin = 0.03 * max(wide, high)
    axes.set_xlim(-wide / 2 - margin, wide / 2 + margin)
    axes.set_ylim(-high / 2 - margin, high / 2 + margin)
    axes.set_aspect("equal")
    draw_robots(axes, lab)
    return draw_overlay.draw(axes, lab.overlay, told=lab.means) if lab.overlay else []


def draw_swarms(axes, lab, end_s):
    """CRE: who is committed, and how many ground robots are in the south, as shares of their swarms."""
    rows = [{name: float(value) for name, value in row.items()} for row in rows_of(lab.folder, "swarms")]
    times = [row["time_s"] for row in rows]
    flying = [max(1, row["uncommitted"] + row["north"] + row["south"]) for row in rows]
    for name, colour, label in (("north", LEDS[1], "flying, committed north"), ("south", LEDS[4], "flying, committed south")):
        axes.plot(times, [row[name] / n for row, n in zip(rows, flying)], color=colour, linewidth=1.2, label=label)
    axes.plot(times, [row["ground_south"] / max(1, row["ground"]) for row in rows], color="black", linewidth=1.8, label="ground, in the south")
    axes.axvline(end_s, color="#999999", linewidth=0.8, linestyle=":")
    axes.set_xlim(0, max(times + [1]))
    axes.set_ylim(-0.02, 1.02)
    axes.set_xlabel("lab time (s)")
    axes.set_ylabel("share of the swarm")
    axes.legend(loc="center right")


def draw_completed(axes, lab, end_s):
    rows = rows_of(lab.folder, "completed")
    kinds = {"all": [], "easy in all labs": [], "mixed": [], "hard in all labs": []}
    for row in rows:
        hard = [value == "1" for name, value in row.items() if name.startswith("hard.")]
        kind = "hard in all labs" if all(hard) else "mixed" if any(hard) else "easy in all labs"
        kinds["all"].append(float(row["time_s"]))
        kinds[kind].append(float(row["time_s"]))
    style = {"all": ("black", 1.8), "easy in all labs": ("#d040d0", 1.1), "mixed": ("#8070c0", 1.1), "hard in all labs": ("#00a0a0", 1.1)}
    last_s = max([end_s] + kinds["all"])
    for kind, times in kinds.items():
        if times or kind == "all":
            axes.step([0] + times + [last_s], [0] + list(range(1, len(times) + 1)) + [len(times)], where="post",
                      color=style[kind][0], linewidth=style[kind][1], label=f"{kind}: {len(times)}")
    axes.axvline(end_s, color="#999999", linewidth=0.8, linestyle=":")
    axes.set_xlim(0, max(last_s, 1))
    axes.set_ylim(0)
    axes.set_xlabel("lab time (s)")
    axes.set_ylabel("completed tasks")
    axes.legend(loc="upper left")


# What is drawn below the arenas: of the first table that a lab has.
BELOW = {"completed": draw_completed, "swarms": draw_swarms}


def leds(labs):
    """{LED: what robots say by it}; of a scenario that is not known here, the colours that are to be seen."""
    seen = {min(robot.led, 8) for lab in labs for view in lab.view.labs for robot in view.robots}
    return labs[0].led_says or {led: f"LED {LED_NAMES[led]}" for led in sorted(seen)}


def draw(labs, width="page", title=None):
    """Returns the figure and the axes of each lab, by name, in metres of its arena."""
    names = sorted({view.lab for lab in labs for view in lab.view.labs})
    colours = {name: LAB[i % len(LAB)] for i, name in enumerate(names)}
    below = next(((table, lab) for table in BELOW for lab in labs if rows_of(lab.folder, table) is not None), None)
    across = len(labs) if width == "page" else 1  # arenas in a row
    rows = math.ceil(len(labs) / across)
    inches = figure_style.WIDTHS_IN.get(width, 1)
    aspect = max(lab.arena.height_m / lab.arena.width_m for lab in labs)
    legend_columns = 1 if width == "column" else 3
    heights = [(inches / across - 0.5) * aspect + 0.5] * rows + [1.9 if width == "column" else 0.75] + [1.7] * bool(below)
    figure, _ = figure_style.new(width, sum(heights) / inches)
    figure.clear()
    grid = figure.add_gridspec(len(heights), across, height_ratios=heights)
    shown, arenas = {}, {}
    for i, lab in enumerate(labs):
        axes = arenas[lab.name] = figure.add_subplot(grid[i // across, i % across])
        shown.update({entry.get_label(): entry for entry in draw_arena(axes, lab)})
        axes.set_xlabel("x (m)", labelpad=1)
        axes.set_ylabel("y (m)", labelpad=1)
        rules = lab.arena.platform.partition(" ")[2]  # "(infrared: argos)"
        axes.set_title(f"{lab.name}: {lab.arena.robots} robots, {lab.arena.width_m:g} x {lab.arena.height_m:g} m {rules}".rstrip(), color=colours[lab.name])
    # One legend for all arenas.
    marks = [Line2D([], [], marker="o", linestyle="", markerfacecolor=LEDS[led], color="black", markeredgewidth=0.6, label=words) for led, words in leds(labs).items()]
    if len(names) > 1:
        marks.append(Line2D([], [], marker="o", linestyle="", markerfacecolor="none", color="black", label="robot of another lab"))
    marks += shown.values()
    legend = figure.add_subplot(grid[rows, :])
    legend.axis("off")
    legend.legend(handles=marks, loc="center", ncol=min(len(marks), legend_columns)).set_in_layout(False)
    stamp_s, seeds = labs[0].view.stamp_us / 1e6, figure_style.seed_words({lab.seed for lab in labs} - {None})
    figure.suptitle(title or f"lab time {stamp_s:g} s, period {labs[0].view.period}{seeds}", fontsize=9)
    if below:
        BELOW[below[0]](figure.add_subplot(grid[rows + 1, :]), below[1], stamp_s)
    return figure, arenas


def labs_of(run, at_s=None):
    """The labs of a run's folder, or of one lab's, at a moment; the largest arena first. Raises Refused."""
    folders = [run] if read_log.log_in(run).is_file() else sorted(folder for folder in run.glob("*") if read_log.log_in(folder).is_file())
    if not folders:
        raise Refused(f"{run} is not a run folder: there is no log.lcm in it or one level below.")
    result = run / "result.json"
    took_part = json.loads(result.read_text()).get("labs", []) if folders != [run] and result.is_file() else []
    gone = [lab for lab in took_part if not read_log.log_in(run / lab).is_file()]
    if gone and len(folders) < len(took_part):
        raise Refused(f"{run} has no log of lab {', '.join(gone)}, which took part; {run / folders[0].name} draws one lab alone.")
    labs = sorted((Lab(folder, at_s) for folder in folders), key=lambda lab: (-lab.arena.width_m, lab.name))
    for lab in labs:
        lab.bodies_m = {other.name: other.body_radius_m for other in labs}
    last_s = max(lab.last_s for lab in labs)
    if at_s is not None and not 0 <= at_s <= last_s:
        raise Refused(f"--at {at_s:g}: {run} covers lab time 0 to {last_s:g} s; give a time in that range, or none for its end.")
    return labs
