"""95 % intervals: the one place where arkmesh computes them. docs/what-a-result-means.md says which is used when. Standard library only.

A mean has Student's t, from 4 values on, cut at what can be; a share of runs Wilson's interval (JASA 22, 1927); a time that some runs did not
reach is censored: the median of Kaplan and Meier (JASA 53, 1958), with the percentiles of 2000 resamples (Efron, 1979)."""
import csv
import functools
import hashlib
import math
import random
import re
import statistics
import typing

LEAST_RUNS, RESAMPLES, Z95 = 4, 2000, 1.959964
UNITS_PER_S, MOST = {"s": 1.0, "ms": 1e3, "us": 1e6}, {"ppm": 1e6, "pct": 100.0}  # of times; of shares that a run measured


class Estimate(typing.NamedTuple):
    value: float  # inf: more than half never
    low: float  # NaN, as `high`: there is no interval
    high: float
    how: str  # "mean, t", "share, Wilson", ...
    n: int
    reached: int  # of n; all where nothing is censored

    def words(self, digits=1):
        """As tables in documents have it."""
        told = "more than half never" if self.value == math.inf else f"{self.value:.{digits}f}"
        return told + (f" (reached in {self.reached} of {self.n})" if self.reached < self.n else "")

    def span(self, digits=1):
        low, high = ("never" if x == math.inf else f"{x:z.{digits}f}" for x in (self.low, self.high))
        return f"none: fewer than {LEAST_RUNS} runs" if math.isnan(self.low) else f"{low} to {high}" + (" (cut)" if "cut" in self.how else "")


def words_of(estimates):
    """Which intervals a figure shows: "mean, 95 % interval: Student's t, cut at what can be"."""
    how = max((estimate.how for estimate in estimates), key=len)
    words = how.replace(", t", ", 95 % interval: Student's t").replace(", W", ", 95 % interval: W").replace(f", {RESAMPLES}", f", 95 % interval: {RESAMPLES}")
    words += " at what can be" if "cut" in how else ""
    words += f"; none below {LEAST_RUNS} runs" if any(math.isnan(estimate.low) for estimate in estimates) and "no interval" not in how else ""
    reached, n = sum(estimate.reached for estimate in estimates), sum(estimate.n for estimate in estimates)
    return words + (f"; reached in {reached} of {n} runs" if reached < n else "")


@functools.lru_cache(maxsize=None)
def t95(degrees):
    """Half of the interval that holds 95 % of Student's t with so many degrees of freedom."""
    factor = math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(degrees * math.pi)
    low, high = 0.0, 13.0
    for _ in range(60):
        middle = (low + high) / 2
        h = middle / 400  # Simpson's rule from 0, twice
        density = [factor * (1 + (i * h) ** 2 / degrees) ** (-(degrees + 1) / 2) for i in range(401)]
        inside = 2 * h / 3 * (density[0] + density[-1] + 4 * sum(density[1:-1:2]) + 2 * sum(density[2:-1:2]))
        low, high = (middle, high) if inside < 0.95 else (low, middle)
    return low


def mean(sample, least=-math.inf, most=math.inf):
    """Of numbers that cannot be below `least` or above `most`."""
    n, value = len(sample), statistics.fmean(sample)
    if n < LEAST_RUNS:
        return Estimate(value, math.nan, math.nan, "mean, no interval", n, n)
    half = t95(n - 1) * statistics.stdev(sample) / math.sqrt(n)
    cut = value - half < least or value + half > most
    return Estimate(value, max(least, value - half), min(most, value + half), "mean, t, cut" if cut else "mean, t", n, n)


def share(hits, n):
    p, z2 = hits / n, Z95 * Z95 / n
    half = Z95 * math.sqrt(p * (1 - p) / n + z2 / 4 / n)
    low, high = ((p + z2 / 2 + sign * half) / (1 + z2) for sign in (-1, 1))
    return Estimate(p, 0.0 if hits == 0 else low, 1.0 if hits == n else high, "share, Wilson", n, n)


def difference(first, second):
    """Mean of `second` minus mean of `first`, with low and high of its 95 % interval (Welch)."""
    d = statistics.mean(second) - statistics.mean(first)
    va, vb = statistics.variance(first) / len(first), statistics.variance(second) / len(second)
    if va + vb == 0:
        return d, d, d
    half = t95((va + vb) ** 2 / (va**2 / (len(first) - 1) + vb**2 / (len(second) - 1))) * math.sqrt(va + vb)
    return d, d - half, d + half


def share_difference(hits, n, other_hits, other_n):
    """Share of the second minus share of the first, with low and high of its 95 % interval (Newcombe, Stat. Med. 17, 1998, method 10)."""
    (p, low, high), (q, other_low, other_high) = share(hits, n)[:3], share(other_hits, other_n)[:3]
    return q - p, q - p - math.hypot(q - other_low, high - p), q - p + math.hypot(p - low, other_high - q)


def _median(order, weights):
    """Where half have reached it, of (time, reached) in order, each so many times; inf: more than half never."""
    left, alive, at = sum(weights), 1.0, None
    for (time, reached), weight in zip(order, weights):
        if weight and reached:
            if at is not None:  # half at that one exactly: between it and the next
                return (at + time) / 2
            alive *= 1 - weight / left
            if alive < 0.5 - 1e-9:
                return time
            at = time if alive < 0.5 + 1e-9 else None
        left -= weight
    return math.inf if at is None else at


def median(times, seed, reached=None):
    """Of times, and whether each was reached; one that was not is how long it was waited for. `seed`: table_hash()."""
    order = sorted(zip(times, reached or [True] * len(times)), key=lambda each: (each[0], not each[1]))
    n, dice, found = len(order), random.Random(seed), [math.nan] * RESAMPLES
    value, hits = _median(order, [1] * n), sum(came for _, came in order)
    for k in range(RESAMPLES if n >= LEAST_RUNS else 0):
        weights = [0] * n
        for i in dice.choices(range(n), k=n):
            weights[i] += 1
        found[k] = _median(order, weights)
    found.sort()
    how = f"median{'' if hits == n else ' (Kaplan-Meier)'}, " + (f"{RESAMPLES} resamples" if n >= LEAST_RUNS else "no interval")
    return Estimate(value, found[RESAMPLES // 40 - 1], found[-RESAMPLES // 40], how, n, hits)


def table_hash(file):
    return hashlib.sha256(file.read_bytes()).hexdigest()


def rows_of(folder):
    """Finished runs of a batch's table, with what labs counted; the table's columns, and those of what labs counted."""
    tables = []
    for name in ("runs.csv", "counters.csv"):
        with open(folder / name, newline="", errors="replace") if (folder / name).is_file() else open("/dev/null") as text:
            reader = csv.DictReader(text)
            tables += [{row["run"]: row for row in reader}, reader.fieldnames or []]
    runs, names, counted, counters = tables
    rows = [{**counted.get(run, {}), **row} for run, row in runs.items() if row.get("state") == "finished"]
    return rows, names, [name for name in counters if name not in names]


def number(text):
    """NaN of what is none."""
    try:
        return float(text) if math.isfinite(float(text)) else math.nan
    except (TypeError, ValueError):
        return math.nan


class Column:
    """A column of a batch's table, by what all finished runs have in it: shares where all are 0 or 1, censored times where a time is empty in some, or as
    long as they lasted; else means."""

    def __init__(self, name, rows, seed):
        unit = re.split("[._]", name.partition("@")[0])[-1]
        self.name, self.seed, self.kind, self.most = name, seed, "mean", MOST.get(unit, math.inf)
        self.per_s = UNITS_PER_S.get(unit) if name != "duration_s" else None
        values = [number(row.get(name)) for row in rows]
        if not self.per_s and set(values) <= {0.0, 1.0}:
            self.kind = "share"
        elif self.per_s and not all(value < self._lasted(row) for value, row in zip(values, rows)):
            # what is counted period by period until it comes is a period longer where it does not; what is longer still is no time of the run
            longest = [self._lasted(row) * (1 + 1 / max(1.0, number(row.get("periods")))) for row in rows]
            self.kind = "median" if all(most > 0 and not value > most for value, most in zip(values, longest)) else "mean"

    def _lasted(self, row):
        return number(row.get("duration_s")) * self.per_s

    def sample(self, rows):
        """Numbers of rows that have one; of censored times all, as (time, whether it was reached)."""
        values = [(number(row.get(self.name)), row) for row in rows]
        if self.kind != "median":
            return [value for value, _ in values if not math.isnan(value)]
        return [(value, True) if value < self._lasted(row) else (self._lasted(row), False) for value, row in values]

    def estimate(self, rows):
        """None of no number at all."""
        if not (sample := self.sample(rows)):
            return None
        if self.kind == "median":
            times, reached = zip(*sample)
            return median(times, self.seed, reached)
        return share(int(sum(sample)), len(sample)) if self.kind == "share" else mean(sample, 0.0, self.most)
