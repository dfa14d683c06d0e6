"""Intervals of means, shares and censored times, against textbooks and against what must hold of any sample; and the tables and figures that show them."""
import csv
import math
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "drawing"))
import intervals  # noqa: E402  # pylint: disable=wrong-import-position


def table(file, rows):
    with open(file, "w", newline="") as text:
        writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


class Intervals(unittest.TestCase):
    def test_of_a_mean(self):
        """Student's t of 9 degrees of freedom is 2.262; below 4 values there is none; what cannot be is cut and marked; nothing jumps at n = 31."""
        told = intervals.mean([3, 1, 2, 5, 4, 8, 7, 6, 10, 9])
        self.assertAlmostEqual(told.high - told.value, 2.262 * 0.957427, 3)
        self.assertEqual(told.how, "mean, t")
        for few in ([1], [1, 2], [1, 2, 90]):
            self.assertTrue(math.isnan(intervals.mean(few).low), few)
            self.assertIn("no interval", intervals.mean(few).how)
        cut = intervals.mean([0, 0, 1, 9], 0, 10)
        self.assertEqual((cut.low, cut.how), (0, "mean, t, cut"))
        self.assertEqual(intervals.mean([99, 100, 100, 80], 0, 100).high, 100)
        for degrees, t in ((1, 12.706), (3, 3.182), (29, 2.045), (30, 2.042), (31, 2.040), (1000, 1.962)):
            self.assertAlmostEqual(intervals.t95(degrees), t, 3)

    def test_of_a_share(self):
        """Wilson's values for 1 of 10 and 5 of 20; never below 0 or above 1, also of none and of all."""
        for hits, n, low, high in ((1, 10, 0.0179, 0.4042), (5, 20, 0.1119, 0.4687), (0, 10, 0, 0.2775), (10, 10, 0.7225, 1)):
            told = intervals.share(hits, n)
            self.assertAlmostEqual(told.low, low, 3)
            self.assertAlmostEqual(told.high, high, 3)

    def test_of_a_censored_time(self):
        """Without censoring it is the median; what was waited for until the end is later than all; else by Kaplan and Meier, as in a textbook."""
        chance = random.Random(1)
        for _ in range(100):
            times = [chance.randint(0, 20) for _ in range(chance.randint(1, 9))]
            self.assertEqual(intervals.median(times, "s").value, statistics.median(times))
            told = intervals.median([min(t, 10) for t in times], "s", [t < 10 for t in times])
            wanted = statistics.median(t if t < 10 else math.inf for t in times)
            if math.isfinite(wanted):
                self.assertEqual(told.value, wanted)
            self.assertEqual(told.reached, sum(t < 10 for t in times))
            self.assertEqual(told, intervals.median([min(t, 10) for t in times], "s", [t < 10 for t in times]), "the same of the same table")
            if len(times) >= 4:
                self.assertLessEqual(told.low, told.high)
        # Freireich's 6-MP arm (Kaplan-Meier in every textbook): the median of 21 is 23 weeks
        weeks = [(6, 1), (6, 1), (6, 1), (6, 0), (7, 1), (9, 0), (10, 1), (10, 0), (11, 0), (13, 1), (16, 1), (17, 0), (19, 0), (20, 0), (22, 1), (23, 1),
                 (25, 0), (32, 0), (32, 0), (34, 0), (35, 0)]
        self.assertEqual(intervals.median([t for t, _ in weeks], "s", [bool(c) for _, c in weeks]).value, 23)
        never = intervals.median([5, 6, 900, 900, 900], "s", [True, True, False, False, False])
        self.assertEqual(never.words(), "more than half never (reached in 2 of 5)")

    def test_of_differences(self):
        """Welch's of two samples: variances 5/3 and 5/2, 6.98 degrees of freedom; Newcombe's of 56 of 70 and 48 of 80, as he gives it."""
        d, low, high = intervals.difference([1, 2, 3, 4], [3, 4, 5, 6, 7])
        self.assertAlmostEqual(d, 2.5)
        self.assertAlmostEqual(high - d, 2.366 * math.sqrt(5 / 12 + 0.5), 2)
        d, low, high = intervals.share_difference(48, 80, 56, 70)
        self.assertAlmostEqual(low, 0.0524, 3)
        self.assertAlmostEqual(high, 0.3339, 3)


class Tables(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        rows = []
        for i in range(24):
            told, k = ("nothing" if i % 2 else "all"), i // 2
            # of those told nothing one in six comes; aggregation counts 901 s where it did not
            rows.append({"run": i, "setting": i % 2, "told": told, "seed": k, "state": "finished", "why": "", "final_hash": "ab", "tasks": k % 5,
                         "until_half_s": (901 if k % 6 else 700 + k) if i % 2 else 50 + k, "agreed.ms": "" if i % 2 and k % 6 else 1000 * (70 + k),
                         "agreed": int(not (i % 2 and k % 6)), "right_pct": 100 if k % 7 else 60, "duration_s": 900, "periods": 900})
        table(self.folder / "runs.csv", rows)
        table(self.folder / "counters.csv", [{"run": row["run"], "setting": row["setting"], "told": row["told"], "seed": row["seed"], "a.sent": row["run"]} for row in rows])

    def script(self, name, *words):
        return subprocess.run([ROOT / "drawing" / name, self.folder, *words], capture_output=True, text=True, timeout=300)

    def test_summary_and_effects(self):
        """Each column has the interval that it needs: times medians, 0 and 1 shares, others means that are cut; never 901.0, above 100 % or below 0."""
        done = self.script("summarise_batch")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.folder / "summary.csv", newline="") as text:
            told = {(row["column"], row["told"]): row for row in csv.DictReader(text)}
        never = told["until_half_s", "nothing"]
        self.assertEqual((never["mean"], never["median"], never["reached"], never["interval"]), ("", "inf", "2", "median (Kaplan-Meier), 2000 resamples"))
        self.assertEqual(told["until_half_s", "all"]["median"], "55.5")
        self.assertEqual(told["agreed.ms", "nothing"]["median"], "inf")
        self.assertEqual(told["agreed", "all"]["interval"], "share, Wilson")
        self.assertEqual((told["agreed", "all"]["low95"], told["agreed", "all"]["high95"]), ("0.757506", "1"))
        self.assertEqual((told["right_pct", "all"]["high95"], told["right_pct", "all"]["interval"]), ("100", "mean, t, cut"))
        self.assertEqual(told["tasks", "all"]["interval"], "mean, t")
        self.assertEqual(told["a.sent", "all"]["n"], "12")
        with open(self.folder / "effects.csv", newline="") as text:
            effects = {row["column"]: row for row in csv.DictReader(text)}
        self.assertEqual((effects["until_half_s"]["difference"], effects["until_half_s"]["hedges_g"]), ("", ""))
        self.assertGreater(float(effects["until_half_s"]["cliffs_delta"]), 0.9)
        self.assertEqual(effects["agreed"]["of"], "share")
        self.assertEqual(effects["tasks"]["difference"], "0")

    def test_figures_say_what_they_draw(self):
        """The figure names its interval; runs that did not reach it are crosses, and a group of which more than half never did says so."""
        for column, wanted in (("until_half_s", "median (Kaplan-Meier), 95 % interval: 2000 resamples; reached in 14 of 24 runs"),
                               ("agreed", "share, 95 % interval: Wilson")):
            done = self.script("plot_batch", "--column", column, "--over", "told", "--out", self.folder / "a.svg")
            self.assertEqual(done.returncode, 0, done.stderr)
            picture = (self.folder / "a.svg").read_text()
            self.assertIn(f"<!-- {wanted}; n = ", picture)
            if column == "until_half_s":
                self.assertIn("<!-- half never -->", picture)

    def test_a_setting_is_named_as_the_scenario_names_it(self):
        """`gain` is scenario.study.gain, unless there are two of that name; three runs have no interval, and nothing is warned of."""
        rows = [{"run": i, "setting": i // 3, "scenario.study.gain": 0.5 + i // 3, "seed": i % 3, "state": "finished", "why": "", "near": 10 * i} for i in range(6)]
        table(self.folder / "runs.csv", rows)
        done = self.script("plot_batch", "--column", "near", "--over", "gain", "--out", self.folder / "a.svg")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("mean, no interval; n = 3", (self.folder / "a.svg").read_text())
        table(self.folder / "runs.csv", [{"a.gain": 1, **row} for row in rows])
        refused = self.script("plot_batch", "--column", "near", "--over", "gain", "--out", self.folder / "a.svg")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("has no column gain; there are a.gain, scenario.study.gain", refused.stderr)


if __name__ == "__main__":
    unittest.main()
