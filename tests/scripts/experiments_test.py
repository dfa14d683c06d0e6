"""The figures and the page that are made from batches: on small tables as a batch writes them, and statistics against published values."""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import tomllib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "drawing"), str(ROOT / "tests/figures")]
import intervals  # noqa: E402
import published  # noqa: E402
import samples  # noqa: E402

HEAD = ["run", "setting"]
TAIL = ["seed", "state", "why", "final_hash"]


def make_batch(folder, factors, rows):
    """A batch's folder with its table; `rows` are pairs of labels and numbers by column."""
    folder.mkdir(parents=True)
    columns = sorted({name for _, numbers in rows for name in numbers})
    with open(folder / "runs.csv", "w", newline="") as table:
        writer = csv.writer(table)
        writer.writerow([*HEAD, *factors, *TAIL, *columns])
        for run, (labels, numbers) in enumerate(rows):
            writer.writerow([run, 0, *labels, run + 1, "finished", "", "abc", *(numbers.get(name, "") for name in columns)])
        writer.writerow([len(rows), 0, *(["?"] * len(factors)), 9, "failed", "why", "", *[""] * len(columns)])
    (folder / "manifest.json").write_text(json.dumps({"arkmesh": "0.1.0", "versions": {"commit": "0123456789abcdef"}, "seeds": [1, 2, 3],
                                                      "experiment": {"file": "batch.toml"}}))


def dhtf_rows(scale, *further):
    """Runs with the published counts, times `scale`; `further` labels stand before pair and mix."""
    return [((*further, pair, mix), {"completed": round(scale * n)}) for (pair, mix), counts in published.DHTF_RUNS.items() for n in counts]


def original_rows(scale):
    """The same of both solvers and both kinds of robots."""
    return [row for solver in ("ode", "fast") for robots in ("ideal", "measured") for row in dhtf_rows(scale, solver, robots)]


class Figures(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = pathlib.Path(scratch.name)

    def run_script(self, name, *arguments):
        return subprocess.run([ROOT / name, *map(str, arguments)], capture_output=True, text=True, timeout=600)

    def page(self):
        done = self.run_script("tests/figures/experiments", "--runs", self.scratch / "runs", "--out", self.scratch / "docs/page.md")
        page = self.scratch / "docs/page.md"
        return done, page.read_text() if page.is_file() else ""

    def test_statistics_have_published_values(self):
        """Student's t from tables; Wilson's interval of 81 of 263 (Newcombe 1998); 3 of 10 against one half."""
        for degrees, t in ((1, 12.706), (4, 2.776), (9, 2.262), (30, 2.042), (1000, 1.962)):
            self.assertAlmostEqual(samples.t95(degrees), t, delta=0.001)
        p, low, high = intervals.share(81, 263)[:3]
        self.assertEqual([round(x, 4) for x in (p, low, high)], [0.308, 0.2553, 0.3662])
        self.assertAlmostEqual(samples.binomial_test(3, 10, 0.5), 0.34375)
        self.assertAlmostEqual(samples.binomial_test(63, 100, 0.5), 0.0120, delta=0.0001)
        self.assertEqual([round(x, 4) for x in intervals.share(63, 100)[1:3]], [0.5322, 0.7182])
        self.assertEqual(samples.excess([0, 0], [5, 6])[:2], (-100, -100))
        more, low, high = samples.excess([9, 10, 11], [9, 10, 11])
        self.assertEqual((more, low < 0 < high), (0, True))
        d, low, high = intervals.difference([1, 2, 3], [21, 22, 23])
        self.assertEqual([round(x, 3) for x in (d, low, high)], [20, 17.733, 22.267])
        # Hollander and Wolfe's example of water permeability: 0.305 with -0.15 to 0.76 (96 %); Newcombe's 56 of 70 and 48 of 80.
        term = [0.80, 0.83, 1.89, 1.04, 1.45, 1.38, 1.91, 1.64, 0.73, 1.46]
        early = [1.15, 0.88, 0.90, 0.74, 1.21]
        self.assertEqual([round(x, 3) for x in samples.shift(early, term)], [0.305, -0.15, 0.76])
        self.assertEqual([round(x, 4) for x in intervals.share_difference(48, 80, 56, 70)], [0.2, 0.0524, 0.3339])

    def test_plots(self):
        """Boxes over a choice, lines over a number, and sentences for what cannot be drawn."""
        make_batch(self.scratch / "b", ["pair", "gate.period_s"], [((pair, x), {"completed": len(pair) + float(x) + i})
                                                                   for pair in ("Ro", "Sh") for x in ("0.1", "2", "10") for i in range(3)])
        for options in (["--over", "pair", "--by", "gate.period_s"], ["--over", "gate.period_s"], ["--over", "gate.period_s", "--kind", "box"]):
            out = self.scratch / "plot.png"
            done = self.run_script("drawing/plot_batch", self.scratch / "b", "--column", "completed", *options, "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(out.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            out.unlink()
        for options, words in ((["--column", "complete", "--over", "pair"], "no column complete; there are completed"),
                               (["--column", "completed", "--over", "pair", "--kind", "line"], "needs numbers"),
                               (["--column", "why", "--over", "pair"], "no finished run with a number")):
            done = self.run_script("drawing/plot_batch", self.scratch / "b", *options)
            self.assertEqual((done.returncode, words in done.stderr, done.stderr.count("\n")), (1, True, 1), done.stderr)
        # what labs counted has a table of its own, and is drawn as a result is
        (self.scratch / "b/counters.csv").write_text("run,setting,pair,gate.period_s,seed,shark.bus.sent\n" + "".join(f"{run},0,Ro,2,1,{run}\n" for run in range(19)))
        done = self.run_script("drawing/plot_batch", self.scratch / "b", "--column", "shark.bus.sent", "--over", "pair", "--out", self.scratch / "plot.png")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("holds no runs.csv", self.run_script("drawing/plot_batch", self.scratch, "--column", "a", "--over", "b").stderr)

    def test_page_agrees_with_the_published_counts(self):
        """Our table made of the published software's own counts differs by nothing."""
        make_batch(self.scratch / "runs/dhtf-batch_original", ["solver", "robots", "pair", "mix"], original_rows(1.0))
        done, page = self.page()
        self.assertEqual(done.returncode, 0, done.stderr + page)
        self.assertEqual(page.count("| +0 % |"), 18)
        self.assertIn("| measured | Sh-Ro | all easy | 169.0 ± 13.3 | 10 | 169.0 ± 13.3 | 10 | +0 % | -10 to +11 % | agrees |", page)
        self.assertIn("| ideal | Sh-Sh | all hard | 55.2 ± 14.3 | 6 | 55.2 ± 14.3 | 6 | +0 % | -27 to +37 % | undecided |", page)
        self.assertIn("in 18 of 18 settings the 95 % interval of the difference includes 0.", page)
        self.assertIn("**Undecided:** DHTF beside the published software, 14 of 18 settings.", page)

    def test_page_names_what_does_not_agree(self):
        """A third more than published is said in the table and on top; with the paper's own claims the order is judged."""
        make_batch(self.scratch / "runs/dhtf-batch_original", ["solver", "robots", "pair", "mix"], original_rows(1.34))
        make_batch(self.scratch / "runs/dhtf-batch", ["pair", "mix"], dhtf_rows(1.0))
        done, page = self.page()
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("**Disagreements:** DHTF beside the published software, measured robots, Sh-Ro, all easy: +34 %", page)
        self.assertIn("**does not agree**", page)
        self.assertIn("| Ro-Ro: all easy > mixed | +71.9 |", page)
        self.assertTrue((self.scratch / "docs/experiments/dhtf.png").is_file())

    def test_shipped_experiments_run(self):
        """Every batch file of experiments/: all its settings are taken, and its first run, which is cut short, does not fail."""
        files = [file for file in sorted((ROOT / "experiments").glob("*/*.toml")) if "seeds" in tomllib.loads(file.read_text()) or
                 file.name.startswith("batch")]
        self.assertGreaterEqual(len(files), 3)
        for file in files:
            with self.subTest(file.name):
                out, short = self.scratch / "runs" / f"{file.parent.name}-{file.stem}", self.scratch / "short.toml"
                # choices may set the duration, and then have the last word
                choices = [(name, option) for name, options in tomllib.loads(file.read_text()).get("choices", {}).items()
                           for option, keys in options.items() if "duration_s" in keys.get("run", {})]
                short.write_text(f'include = ["{file}"]\n[set]\nrun.duration_s = 10\n' + "".join(f'[choices.{name}."{option}"]\nrun.duration_s = 10\n' for name, option in choices))
                done = subprocess.run([ROOT / "build/release/arkmesh", "batch", short, "--index", "0", "--out", out], capture_output=True, text=True, timeout=600)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_pages_have_the_marks(self):
        """README has the place that the script writes to, and the page those that the paper quotes."""
        for page, name in (("README.md", "validated"), ("docs/experiments.md", "DHTF"), ("docs/experiments.md", "CRE")):
            text = (ROOT / page).read_text()
            self.assertEqual((text.count(f"<!-- {name}: written by tests/figures/experiments -->\n"), text.count(f"<!-- {name}: written by tests/figures/experiments: end -->")), (1, 1))


if __name__ == "__main__":
    unittest.main()
