"""What samples say: means with intervals, differences, ratios, shares. Standard library only."""
import csv
import json
import math
import statistics


def t95(degrees):
    """Half of the interval that holds 95 % of Student's t with so many degrees of freedom."""
    factor = math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(degrees * math.pi)
    density = lambda x: factor * (1 + x * x / degrees) ** (-(degrees + 1) / 2)  # noqa: E731

    def inside(t, steps=400):  # Simpson's rule from 0 to t, twice
        h = t / steps
        return 2 * h / 3 * (density(0) + density(t) + sum((4 if i % 2 else 2) * density(i * h) for i in range(1, steps)))

    low, high = 0.0, 13.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if inside(middle) < 0.95 else (low, middle)
    return low


def mean_interval(sample):
    """Mean and half of its 95 % interval; the half is 0 for one number."""
    if len(sample) < 2:
        return statistics.mean(sample), 0.0
    return statistics.mean(sample), t95(len(sample) - 1) * statistics.stdev(sample) / math.sqrt(len(sample))


def difference(first, second):
    """Mean of `second` minus mean of `first`, with low and high of its 95 % interval (Welch)."""
    d = statistics.mean(second) - statistics.mean(first)
    va, vb = statistics.variance(first) / len(first), statistics.variance(second) / len(second)
    if va + vb == 0:
        return d, d, d
    half = t95((va + vb) ** 2 / (va**2 / (len(first) - 1) + vb**2 / (len(second) - 1))) * math.sqrt(va + vb)
    return d, d - half, d + half


def excess(ours, theirs):
    """By how much the mean of `ours` exceeds that of `theirs`, in per cent, with low and high of its 95 % interval: both means vary, and the
    logarithm of their ratio is taken as normal, with Welch's degrees of freedom. Of nothing at all there is no upper limit to tell: NaN."""
    a, b = statistics.mean(ours), statistics.mean(theirs)
    if a == 0:
        return -100.0, -100.0, math.nan
    va, vb = statistics.variance(ours) / len(ours) / a**2, statistics.variance(theirs) / len(theirs) / b**2
    half = t95((va + vb) ** 2 / (va**2 / (len(ours) - 1) + vb**2 / (len(theirs) - 1))) * math.sqrt(va + vb)
    return tuple(100 * (a / b * math.exp(x) - 1) for x in (0, -half, half))


def share_interval(hits, n):
    """Share, low and high of its 95 % interval (Wilson, JASA 22, 1927)."""
    z, p = 1.959964, hits / n
    middle, half = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return p, (middle - half) / (1 + z * z / n), (middle + half) / (1 + z * z / n)


def binomial_test(hits, n, share):
    """Two-sided exact test that `hits` of `n` came with probability `share`: the probability of what is not likelier."""
    weights = [math.comb(n, k) * share**k * (1 - share) ** (n - k) for k in range(n + 1)]
    return min(1.0, sum(w for w in weights if w <= weights[hits] * (1 + 1e-9)))


def rank_test(first, second):
    """Two-sided p that both samples come from one distribution: Mann and Whitney's test (Ann. Math. Stat. 18, 1947), normal, corrected for ties."""
    n, m = len(first), len(second)
    everything = sorted((*first, *second))
    places = {}
    for place, value in enumerate(everything, 1):
        places.setdefault(value, []).append(place)
    u = sum(statistics.mean(places[value]) for value in first) - n * (n + 1) / 2
    ties = sum(len(p) ** 3 - len(p) for p in places.values())
    variance = n * m / 12 * (n + m + 1 - ties / ((n + m) * (n + m - 1)))
    if variance == 0:
        return 1.0
    return 2 * statistics.NormalDist().cdf(-max(0.0, abs(u - n * m / 2) - 0.5) / math.sqrt(variance))


def shift(first, second):
    """By how much numbers of `second` exceed those of `first` in the median of all pairs, with low and high of its 95 % interval (Hodges and
    Lehmann, Ann. Math. Stat. 34, 1963; Moses' interval, normal). It supposes nothing about how they are spread."""
    n, m = len(first), len(second)
    differences = sorted(b - a for a in first for b in second)
    place = max(0, round(n * m / 2 - 1.959964 * math.sqrt(n * m * (n + m + 1) / 12)) - 1)
    return statistics.median(differences), differences[place], differences[-1 - place]


def median_interval(sample):
    """Median, with low and high of its 95 % interval by the sign test (normal); of fewer than six numbers the least and the largest."""
    ordered, n = sorted(sample), len(sample)
    place = max(0, round(n / 2 - 1.959964 * math.sqrt(n) / 2) - 1)
    return statistics.median(ordered), ordered[place], ordered[-1 - place]


def share_difference(hits, n, other_hits, other_n):
    """Share of the second minus share of the first, with low and high of its 95 % interval (Newcombe, Stat. Med. 17, 1998, method 10)."""
    p, low, high = share_interval(hits, n)
    q, other_low, other_high = share_interval(other_hits, other_n)
    return q - p, q - p - math.hypot(q - other_low, high - p), q - p + math.hypot(p - low, other_high - q)


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
    with open(file, newline="") as table:
        rows = [row for row in csv.DictReader(table) if row["state"] == "finished"]
    counted = folder / "counters.csv"
    if counted.is_file():
        with open(counted, newline="") as table:
            by_run = {row["run"]: row for row in csv.DictReader(table)}
        rows = [{**by_run.get(row["run"], {}), **row} for row in rows]
    if not rows:
        raise SystemExit(f"{file} holds no finished run")
    return rows


def numbers(rows, column, **having):
    """A column of the rows with these cells, without empty ones."""
    return [float(row[column]) for row in rows if all(row[key] == value for key, value in having.items()) and row.get(column, "") != ""]
