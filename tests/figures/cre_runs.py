"""Runs of CRE over many seeds, and what they say: for the scripts beside it."""
import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

from pages import ROOT
from samples import finished_runs

LABS = [ROOT / "experiments/cre/meadow.toml", ROOT / "experiments/cre/sky.toml"]

# The paper's two experiments: active resources in the north and in the south, and how long a run lasts here.
EXPERIMENTS = {
    "asymmetric": {"scenario.cre.resources_north": 10, "scenario.cre.resources_south": 35, "run.duration_s": 900},
    "symmetric": {"scenario.cre.resources_north": 35, "scenario.cre.resources_south": 35, "run.duration_s": 1800},
}


def plotter():
    """matplotlib's, without a screen."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot
    return matplotlib.pyplot


def run(options, experiment, sets=()):
    """A row for each seed of a batch of its own, as of_batch() gives them."""
    with tempfile.TemporaryDirectory(prefix="cre_runs.") as folder:
        out = Path(folder) / "out"
        command = [ROOT / "build/release/arkmesh", "batch", *LABS, "--seeds", options.seeds, "--jobs", options.jobs, "--out", out]
        for setting in [*(f"{key}={value}" for key, value in EXPERIMENTS[experiment].items()), *options.set, *sets]:
            command += ["--set", setting]
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{experiment}, {' '.join(sets) or 'as it is'}: a run failed\n{done.stderr[-2000:]}{done.stdout[-2000:]}")
        return [numbers_of(row) for row in finished_runs(out)]


def of_batch(folder, experiment, swarms=False):
    """Of a batch of experiments/cre in which resources lie as in this experiment: whole numbers of each run and, if wanted, `swarms`: the rows of
    swarms.csv."""
    rows = []
    for row in finished_runs(Path(folder)):
        if row["resources"] == experiment:
            rows.append(numbers_of(row))
            if swarms:
                with open(Path(folder) / f"runs/{int(row['run']):05}/meadow/swarms.csv") as table:
                    rows[-1]["swarms"] = [{name: float(value) for name, value in each.items()} for each in csv.DictReader(table)]
    return rows


def numbers_of(row):
    """0 where what did not happen has an empty time."""
    return {"consensus.ms": 0, "ground.followed_ms": 0} | {name: int(value) for name, value in row.items() if value.isdigit()}


def quantile(values, q):
    """The smallest value that at least a share q of all do not exceed; nan of nothing."""
    ordered = sorted(values)
    return ordered[max(0, math.ceil(q * len(ordered)) - 1)] if ordered else math.nan


def summary(rows):
    """What a set of runs says. Times in seconds, shares 0..1."""
    agreed = [row for row in rows if row["consensus.ms"] > 0]
    times = [row["consensus.ms"] / 1e3 for row in agreed]
    return {
        "runs": len(rows),
        "south": sum(row["consensus.south"] for row in rows),
        "north": sum(row["consensus.north"] for row in rows),
        "times": times,
        "by": lambda seconds: sum(t <= seconds for t in times) / len(rows),
        "held": sum(row["consensus.held"] for row in agreed) / max(1, sum(row["consensus.periods"] for row in agreed)),
        "behind": [(row["ground.followed_ms"] - row["consensus.ms"]) / 1e3 for row in agreed if row["ground.followed_ms"] > 0],
        "ground_south": [row["ground.south_ppm"] / 1e6 for row in rows],
        "ground_with_winner": [row["ground.south_ppm"] / 1e6 if row["consensus.south"] else 1 - row["ground.south_ppm"] / 1e6 for row in agreed],
        "last_minute": [max(row["flying.north_ppm"], row["flying.south_ppm"]) / 1e6 for row in rows],
        "middle_late": [row["ground.middle_peak_ppm"] / 1e6 for row in agreed if row["consensus.ms"] > 120_000],
    }
