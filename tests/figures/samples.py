"""What samples say beside their intervals, which are drawing/intervals.py's: ratios, a test, shifts. Standard library only."""
import json
import math
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "drawing"))
from intervals import rows_of, t95  # noqa: E402  # pylint: disable=wrong-import-position


def excess(ours, theirs):
    """By how much the mean of `ours` exceeds that of `theirs`, in per cent, with low and high of its 95 % interval: both means vary, and the
    logarithm of their ratio is taken as normal, with Welch's degrees of freedom. Of nothing at all there is no upper limit to tell: NaN."""
    a, b = statistics.mean(ours), statistics.mean(theirs)
    if a == 0:
        return -100.0, -100.0, math.nan
    va, vb = statistics.variance(ours) / len(ours) / a**2, statistics.variance(theirs) / len(theirs) / b**2
    half = t95((va + vb) ** 2 / (va**2 / (len(ours) - 1) + vb**2 / (len(theirs) - 1))) * math.sqrt(va + vb)
    return tuple(100 * (a / b * math.exp(x) - 1) for x in (0, -half, half))


def binomial_test(hits, n, share):
    """Two-sided exact test that `hits` of `n` came with probability `share`: the probability of what is not likelier."""
    weights = [math.comb(n, k) * share**k * (1 - share) ** (n - k) for k in range(n + 1)]
    return min(1.0, sum(w for w in weights if w <= weights[hits] * (1 + 1e-9)))


def shift(first, second):
    """By how much numbers of `second` exceed those of `first` in the median of all pairs, with low and high of its 95 % interval (Hodges and
    Lehmann, Ann. Math. Stat. 34, 1963; Moses' interval, normal). It supposes nothing about how they are spread."""
    n, m = len(first), len(second)
    differences = sorted(b - a for a in first for b in second)
    place = max(0, round(n * m / 2 - 1.959964 * math.sqrt(n * m * (n + m + 1) / 12)) - 1)
    return statistics.median(differences), differences[place], differences[-1 - place]


def batch_words(batch):
    """Which command made a batch's folder, of which seeds and which version."""
    manifest = json.loads((batch / "manifest.json").read_text())
    seeds = manifest["seeds"]
    return (f"`arkmesh batch experiments/{batch.name.split('-')[0]}/{manifest['experiment']['file']}`, seeds {min(seeds)} to {max(seeds)}, arkmesh "
            f"{manifest['arkmesh']} (commit {manifest['versions']['commit'][:12]})")


def finished_runs(folder):
    """Rows of a batch's table, of the runs that finished; a sentence as SystemExit when there are none."""
    file = folder / "runs.csv"
    if not file.is_file():
        raise SystemExit(f"{folder} holds no runs.csv; is it a batch's folder, and has the batch ended?")
    rows, _, _ = rows_of(folder)
    if not rows:
        raise SystemExit(f"{file} holds no finished run")
    return rows


def numbers(rows, column, **having):
    """A column of the rows with these cells, without empty ones."""
    return [float(row[column]) for row in rows if all(row[key] == value for key, value in having.items()) and row.get(column, "") != ""]
