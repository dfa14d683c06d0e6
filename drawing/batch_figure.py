"""Columns of a batch's table over a swept key or a choice, as axes of matplotlib. drawing/plot_batch and arkmesh.Batch.plot draw with it."""
import math

from matplotlib.patches import Patch

import figure_style
import intervals
from figure_style import COLOURS, Refused


def named(name, columns):
    """The column of that name, or the only one that ends in a dot and that name: `gain` for scenario.follow.gain, as in a sweep."""
    endings = [column for column in columns if column.endswith(f".{name}")]
    return endings[0] if name not in columns and name and len(endings) == 1 else name


def read(folder, column, keys):
    """Finished runs as rows, the names of the factors, and the columns that `column` and `keys` name."""
    file = folder / "runs.csv"
    if not file.is_file():
        raise Refused(f"{folder} holds no runs.csv; it is written when a batch ends, or by arkmesh batch FILE --gather")
    rows, names, counters = intervals.rows_of(folder)
    if "state" not in names or "seed" not in names:
        raise Refused(f"{file} is not a batch's table; arkmesh batch FILE --gather writes it again")
    column, *keys = chosen = [named(name, (*names, *counters)) for name in [column, *keys]]
    for name in chosen:
        if name not in (*names, *counters):
            near = [known for known in (*names, *counters) if name.lower() in known.lower()]
            raise Refused(f"{file} has no column {name}; " + (f"there are {', '.join(near[:5])}" if near else f"it has {', '.join(names[:12])}, ..."))
    if all(math.isnan(intervals.number(row.get(column))) for row in rows):
        raise Refused(f"{file} holds no finished run with a number in {column}")
    return rows, names[2:names.index("seed")], chosen


def in_order(values):
    """Numbers by size, the rest as the table has it."""
    known = list(dict.fromkeys(values))
    return sorted(known, key=float) if are_numbers(known) else known


def are_numbers(values):
    return not any(math.isnan(intervals.number(value)) for value in values)


def draw_lines(axes, column, samples, over, groups):
    """Estimates with their intervals, over numbers joined by lines, and a point for each run; a cross for one that did not reach it."""
    places = [float(x) for x in over] if are_numbers(over) else list(range(len(over)))
    for k, (colour, group) in enumerate(zip(COLOURS * 9, groups)):
        points = []
        for place, x in zip(places, over):
            sample, estimate = samples.get((x, group)), column.estimate(samples.get((x, group), []))
            if estimate is None:
                continue
            if not are_numbers(over):
                place += (k - (len(groups) - 1) / 2) * 0.8 / len(groups)
            for value, reached in (each if column.kind == "median" else (each, True) for each in column.sample(sample)):
                axes.plot(place, value, linestyle="", marker="." if reached else "x", markersize=3, alpha=0.3, color=colour)
            if math.isinf(estimate.value):
                axes.annotate("more than\nhalf never", (place, max(value for value, _ in column.sample(sample))), ha="center", fontsize=6, color=colour)
            points.append((place, estimate))
        most = axes.yaxis.get_data_interval()[1]  # where an interval ends that reaches never
        drawn = [(place, e.value, e.value - e.low, min(e.high, max(most, e.value)) - e.value) for place, e in points if math.isfinite(e.value)]
        xs, ys, *errors = zip(*drawn) if drawn else [[]] * 4
        errors = errors if any(map(math.isfinite, errors[0])) else None  # of too few runs
        axes.errorbar(xs, ys, yerr=errors, color=colour, capsize=3, marker="o", markersize=4, label=group, linestyle="-" if are_numbers(over) else "")
    if not are_numbers(over):
        axes.set_xticks(places, over)
    elif min(places) > 0 and max(places) / min(places) > 20:
        axes.set_xscale("log")
        axes.set_xticks(places, over)
        axes.minorticks_off()


def draw_boxes(axes, column, samples, over, groups):
    width = 0.8 / len(groups)
    for i, (colour, group) in enumerate(zip(COLOURS * 9, groups)):
        there = [(k, column.sample(samples[x, group])) for k, x in enumerate(over) if (x, group) in samples]
        boxes = axes.boxplot([sample for _, sample in there], positions=[k + (i - (len(groups) - 1) / 2) * width for k, _ in there],
                             widths=width * 0.85, patch_artist=True, showmeans=True, medianprops={"color": "black"},
                             meanprops={"marker": "D", "markersize": 4, "markerfacecolor": "white", "markeredgecolor": "black"},
                             flierprops={"marker": ".", "markersize": 4})
        for box in boxes["boxes"]:
            box.set(facecolor=colour, alpha=0.6)
    axes.set_xticks(range(len(over)), over)
    axes.set_xlim(-0.5, len(over) - 0.5)


def draw(folder, column, over, by="", kind="", width="page", xlabel=None, ylabel=None, title=None, axes=None):
    """Returns the axes. `kind`: "box", "line", or by what is drawn. `width` is that of a new figure, where no `axes` are given. Raises Refused."""
    rows, factors, (column, *keys) = read(folder, column, [over] + ([by] if by else []))
    over, by = (*keys, "")[:2]
    samples = {}
    for row in rows:
        samples.setdefault((row[over], row[by] if by else ""), []).append(row)
    about = figure_style.told_in(folder)
    told = intervals.Column(column, rows, intervals.table_hash(folder / "runs.csv"))
    places = in_order([row[over] for row in rows])
    groups = in_order([row[by] for row in rows]) if by else [""]
    if kind == "line" and not are_numbers(places):
        raise Refused(f"--kind line needs numbers, but {over} holds {next(x for x in places if not are_numbers([x]))}")
    # a share, or what some runs did not reach, has no box
    kind = kind if told.kind == "mean" and kind else "line" if are_numbers(places) or told.kind != "mean" else "box"
    if axes is None:
        _, axes = figure_style.new(width)
    (draw_lines if kind == "line" else draw_boxes)(axes, told, samples, places, groups)
    axes.set_xlabel(xlabel or figure_style.label_of(over, about))
    axes.set_ylabel(ylabel or figure_style.label_of(column, about))
    axes.set_ylim(bottom=min(0, axes.get_ylim()[0]))
    if told.kind == "mean":
        figure_style.whole_numbers(axes.yaxis, told.sample(rows))
    if by:
        boxes = [Patch(facecolor=colour, alpha=0.6, label=group) for colour, group in zip(COLOURS * 9, groups)]
        axes.legend(title=figure_style.label_of(by, about), **({"handles": boxes} if kind == "box" else {}))
    pooled = [figure_style.words_of(factor, about)[0] for factor in factors if factor not in keys and len({row[factor] for row in rows}) > 1]
    n = sorted({len(sample) for sample in samples.values()})
    words = f"n = {n[0]}" if len(n) == 1 else f"n = {n[0]} to {n[-1]}"
    words += figure_style.seed_words({int(row["seed"]) for row in rows if row["seed"].isdigit()})
    words += f", pooled over {', '.join(pooled)}" if pooled else ""
    if kind == "line":
        what = intervals.words_of([estimate for sample in samples.values() if (estimate := told.estimate(sample))])
    else:
        what = "boxes: quartiles and median; whiskers: 1.5 of the box's height; diamond: mean"
    figure_style.note(axes, f"{what}; {words}", title)
    return axes
