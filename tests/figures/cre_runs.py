"""Runs of CRE over many seeds, and what they say: for the scripts beside it."""
import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

from samples import finished_runs

ROOT = Path(__file__).resolve().parents[2]
LABS = [ROOT / "experiments/cre/meadow.toml", ROOT / "experiments/cre/sky.toml"]

# The paper's two experiments: active resources in the north and in the south, and how long a run lasts here.
EXPERIMENTS = {
    "asymmetric": {"scenario.cre.resources_north": 10, "scenario.cre.resources_south": 35, "run.duration_s": 900},
    "symmetric": {"scenario.cre.resources_north": 35, "scenario.cre.resources_south": 35, "run.duration_s": 1800},
}


def options_of(parser):
    """The options that all scripts have."""
    parser.add_argument("--arkmesh", default=ROOT / "build/release/arkmesh")
    parser.add_argument("--seeds", default="1001..1100", help="FIRST..LAST (default 1001..1100)")
    parser.add_argument("--jobs", default=2, type=int, help="runs at a time (default 2)")
    parser.add_argument("--set", action="append", default=[], help="a further override for all labs")


def run(options, experiment, sets=()):
    """A row for each seed of a batch of its own, as of_batch() gives them."""
    with tempfile.TemporaryDirectory(prefix="cre_runs.") as folder:
        out = Path(folder) / "out"
        command = [options.arkmesh, "batch", *LABS, "--seeds", options.seeds, "--jobs", options.jobs, "--out", out]
        settings = [f"{key}={value}" for key, value in EXPERIMENTS[experiment].items()]
        for setting in [*settings, *options.set, *sets]:
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
        if row["resources"] != experiment:
            continue
        rows.append(numbers_of(row))
        if swarms:
            rows[-1]["swarms"] = read_swarms(Path(folder) / f"runs/{int(row['run']):05}/meadow/swarms.csv")
    return rows


def numbers_of(row):
    numbers = {name: int(value) for name, value in row.items() if value.isdigit()}
    for name in ("consensus.ms", "ground.followed_ms"):  # empty where there was none
        numbers.setdefault(name, 0)
    return numbers


def read_swarms(file):
    with open(file) as table:
        return [{name: float(value) for name, value in each.items()} for each in csv.DictReader(table)]


def quantile(values, q):
    """The smallest value that at least a share q of all do not exceed; nan of nothing."""
    ordered = sorted(values)
    return ordered[max(0, math.ceil(q * len(ordered)) - 1)] if ordered else math.nan


def summary(rows):
    """What a set of runs says. Times in seconds, shares 0..1."""
    agreed = [row for row in rows if row.get("consensus.ms", 0) > 0]
    times = [row["consensus.ms"] / 1e3 for row in agreed]
    followed = [row for row in agreed if row.get("ground.followed_ms", 0) > 0]
    late = [row["ground.middle_peak_ppm"] / 1e6 for row in agreed if row["consensus.ms"] > 120_000]
    with_winner = [row["ground.south_ppm"] / 1e6 if row["consensus.south"] else 1 - row["ground.south_ppm"] / 1e6 for row in agreed]
    return {
        "runs": len(rows),
        "south": sum(row["consensus.south"] for row in rows),
        "north": sum(row["consensus.north"] for row in rows),
        "times": times,
        "by": lambda seconds: sum(t <= seconds for t in times) / len(rows),
        "held": sum(row["consensus.held"] for row in agreed) / max(1, sum(row["consensus.periods"] for row in agreed)),
        "behind": [(row["ground.followed_ms"] - row["consensus.ms"]) / 1e3 for row in followed],
        "followed": len(followed),
        "ground_south": [row["ground.south_ppm"] / 1e6 for row in rows],
        "ground_with_winner": with_winner,
        "last_minute": [max(row["flying.north_ppm"], row["flying.south_ppm"]) / 1e6 for row in rows],
        "middle_late": late,
    }
