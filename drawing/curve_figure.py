"""What runs have counted over lab time, as axes of matplotlib. drawing/plot_curves and arkmesh.Run.curves draw with it."""
import csv
import json
import math
import tomllib

import figure_style
import intervals
import read_log
from figure_style import COLOURS, Refused

LINES = ["-", "--", ":", "-."]
NO_CURVES, COUNTS = {"hash", "audit"}, "curves"  # counts that the scenario shows
POINTS, MOST_PANELS, MOST_DIFFERENCES = 240, 9, 4


def number(text):
    try:
        return float(text)
    except ValueError:
        return math.nan


def read_csv(file):
    """Whole rows as dicts; the last one may be cut."""
    with open(file, newline="") as text:
        rows = list(csv.reader(text))
    header = rows[0] if rows else []
    return header, [dict(zip(header, row)) for row in rows[1:] if len(row) == len(header)]


def labs_of(run):
    """The folders of a run's labs."""
    if read_log.log_in(run).is_file() or (run / "config.toml").is_file():
        return [run]
    return sorted(file.parent for file in run.glob("*/config.toml"))


def curves_of(run):
    """{name: (times in s, values, whether values hold until the next)} of a run; name@lab where labs have other values under one name."""
    found = {}
    for lab in labs_of(run):
        for file in sorted(lab.glob("*.csv")):
            header, rows = read_csv(file)
            if file.stem in NO_CURVES or "time_s" not in header:
                continue
            times = [number(row["time_s"]) for row in rows]
            steps = {round(b - a, 6) for a, b in zip(times, times[1:])}
            if file.stem == COUNTS or (len(times) > 2 and len(steps) == 1):
                for name in header:
                    series = name if file.stem == COUNTS else f"{file.stem}.{name}"
                    if name not in ("time_s", "period") and lab.name not in found.get(series, {}) and not any(math.isnan(number(row[name])) for row in rows):
                        found.setdefault(series, {})[lab.name] = (times, [number(row[name]) for row in rows], False)
            else:
                found.setdefault(file.stem, {})[lab.name] = ([0.0, *times], list(range(len(times) + 1)), True)
    out = {}
    for name, by_lab in found.items():
        first, *others = by_lab.values()
        out.update({name: first} if all(other == first for other in others) else {f"{name}@{lab}": curve for lab, curve in by_lab.items()})
    return out


def flat(table, path=""):
    for key, value in table.items():
        if isinstance(value, dict):
            yield from flat(value, f"{path}{key}.")
        else:
            yield path + key, str(value).rpartition("/")[2]  # of files their names, wherever runs lie


def settings_of(run):
    """{key: value} of all that a run's course depends on beside its seed."""
    out = {}
    for lab in labs_of(run):
        result = json.loads((lab / "result.json").read_text()) if (lab / "result.json").is_file() else {}
        files = {key: result.get(key, {}) for key in ("hashes", "versions", "scenario_in_python")}
        files["hashes"].pop("config.toml", None)
        for key, value in flat({**tomllib.loads((lab / "config.toml").read_text()), **files}):
            if not key.startswith(("run.seed", "recorder.", "view.", "bus.", "gateway.", "operator.")):
                out.setdefault(key, {})[lab.name] = value
    return {key: next(iter(by_lab.values())) if len(set(by_lab.values())) == 1 else str(by_lab) for key, by_lab in out.items()}


def length_of(run):
    """Simulated seconds, from the results of a lab; 0 where there are none."""
    for lab in labs_of(run):
        try:
            return float(json.loads((lab / "result.json").read_text()).get("duration_s", 0))
        except (OSError, ValueError):
            continue
    return 0.0


def seeds_of(run):
    """Of a run's labs."""
    return {tomllib.loads(config.read_text()).get("run", {}).get("seed", 1) for lab in labs_of(run) if (config := lab / "config.toml").is_file()}


def apart(by_folder, told):
    """{folder: words of what it has otherwise than others}, of {folder: settings of each of its runs}."""
    common = {folder: {key: value for key, value in runs[0].items() if all(run.get(key) == value for run in runs)} for folder, runs in by_folder.items()}
    varied = {key for runs in by_folder.values() for run in runs[1:] for key in run.keys() | runs[0].keys() if run.get(key) != runs[0].get(key)}
    keys = sorted({key for settings in common.values() for key in settings} - varied)
    keys = [key for key in keys if len({settings.get(key) for settings in common.values()}) > 1]
    if len(keys) > MOST_DIFFERENCES:
        raise Refused(f"these runs differ in {len(keys)} settings, {', '.join(keys[:MOST_DIFFERENCES])}, ...; draw runs with the same settings, or a batch with --by")
    return {folder: ", ".join(figure_style.setting_of(key, settings.get(key, "not set"), told) for key in keys) for folder, settings in common.items()}


def value_at(curve, t, place):
    """The value at a time, and the place in the curve from where to look next."""
    times, values, holds = curve
    while place + 1 < len(times) and times[place + 1] <= t:
        place += 1
    if holds or place + 1 == len(times) or t <= times[place]:
        return values[place], place
    share = (t - times[place]) / (times[place + 1] - times[place])
    return values[place] + share * (values[place + 1] - values[place]), place


def sampled(curve, grid):
    place, out = 0, []
    for t in grid:
        value, place = value_at(curve, t, place)
        out.append(value)
    return out


def runs_of(folder, by):
    """(group, run folder) of an argument, and the factors of a batch that no group tells apart."""
    table = folder / "runs.csv"
    if table.is_file():
        header, rows = read_csv(table)
        factors = header[2:header.index("seed")] if "seed" in header else []
        for key in by:
            if key not in factors:
                raise Refused(f"{table} has no factor {key}; it has {', '.join(factors) or 'none'}")
        keys, rows = by or factors, [row for row in rows if row["state"] == "finished"]
        pooled = [factor for factor in factors if factor not in keys and len({row[factor] for row in rows}) > 1]
        told = figure_style.told_in(folder)
        return [(", ".join(figure_style.setting_of(key, row[key], told) for key in keys), folder / "runs" / f"{int(row['run']):05d}") for row in rows], pooled
    if not labs_of(folder):
        raise Refused(f"{folder} is neither a run nor a batch: there is no config.toml in it or one level below, and no runs.csv")
    return [("", folder)], []


def draw(axes, name, groups, end_s, told):
    """Returns the estimates that the bands are made of."""
    shown = []
    least = 0.0 if all(min(curve[name][1]) >= 0 for curves in groups.values() for curve in curves if name in curve) else -math.inf
    grid = [end_s * i / POINTS for i in range(POINTS + 1)]
    for i, (group, curves) in enumerate(groups.items()):
        samples = [sampled(curve[name], grid) for curve in curves if name in curve]
        if not samples:
            continue
        columns = list(zip(*samples))
        estimates = [intervals.mean(column, least, intervals.MOST.get(name.partition("@")[0].rpartition("_")[2], math.inf)) for column in columns]
        mean = [estimate.value for estimate in estimates]
        colour, line = COLOURS[i % len(COLOURS)], LINES[i // len(COLOURS) % len(LINES)]
        if len(samples) > 1:
            axes.fill_between(grid, [e.low for e in estimates], [e.high for e in estimates], color=colour, alpha=0.25, linewidth=0)
            shown += estimates
        label = f"{group + ', ' if group else ''}{'mean of ' if len(samples) > 1 else ''}{len(samples)} run{'s' if len(samples) > 1 else ''}"
        axes.plot(grid, mean, color=colour, linestyle=line, linewidth=1.4, label=label)
    figure_style.whole_numbers(axes.yaxis, [value for curves in groups.values() for curve in curves if name in curve for value in curve[name][1]])
    axes.set_xlim(0, end_s)
    axes.set_xlabel("lab time (s)")
    axes.set_ylabel(figure_style.label_of(name, told))
    axes.legend()
    return shown


def draw_all(folders, by=(), series=(), width="page", xlabel=None, ylabel=None, title=None):
    """Returns the figure, its axes by the names of the series, and how many series are not drawn. Raises Refused."""
    groups, end_s, seeds, pooled, there, told = {}, 0.0, set(), [], [], {}
    for i, folder in enumerate(folders):
        if folder.resolve() in [other.resolve() for other in folders[:i]]:
            raise Refused(f"{folder} is named twice; each run counts once")
        runs, unsaid = runs_of(folder, list(by))
        there.append(runs)
        told = told or figure_style.told_in(folder)
        pooled += [factor for factor in unsaid if factor not in pooled]
    told_apart = apart({i: [settings_of(run) for _, run in runs] for i, runs in enumerate(there) if runs}, told)
    for i, runs in enumerate(there):
        for group, run in runs:
            curves = curves_of(run)
            groups.setdefault(", ".join(words for words in (group, told_apart[i]) if words), []).append(curves)
            seeds.update(seeds_of(run))
            end_s = max([end_s, length_of(run)] + [times[-1] for times, _, _ in curves.values()])
    names = list(dict.fromkeys(name for curves in groups.values() for curve in curves for name in curve))
    if not names:
        raise Refused(f"{folders[0]} holds no table with a column time_s, so there is nothing to plot over time")
    for name in series:
        if name not in names:
            raise Refused(f"no run has {name}; there are {', '.join(names)}")
    wanted = [name for of, about in told.items() if about["curve"] for name in names if name.partition("@")[0] == of]
    chosen = (list(series) or wanted or names)[:MOST_PANELS]
    columns = 1 if len(chosen) == 1 or width == "column" else 2 if len(chosen) <= 4 else 3
    rows = math.ceil(len(chosen) / columns)
    figure, all_axes = figure_style.new(width, (0.62 if columns == 1 else 0.85) * rows / columns, rows, columns, squeeze=False)
    for axes in all_axes.flat[len(chosen):]:
        axes.set_visible(False)
    bands = [estimate for axes, name in zip(all_axes.flat, chosen) for estimate in draw(axes, name, groups, end_s or 1, told)]
    for axes in all_axes.flat[:len(chosen)]:
        axes.set_xlabel(xlabel or axes.get_xlabel())
        axes.set_ylabel(ylabel or axes.get_ylabel())
    words = ("band: " + intervals.words_of(bands) if bands else str(folders[0])) + figure_style.seed_words(seeds)
    words += f", pooled over {', '.join(figure_style.words_of(factor, told)[0] for factor in pooled)}" if pooled else ""
    figure.supxlabel(figure_style.wrapped(words, figure.get_figwidth()), fontsize=6, color="#444444")
    if title:
        figure.suptitle(title, fontsize=9)
    return figure, dict(zip(chosen, all_axes.flat)), len(names) - len(chosen)
