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
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "scripts/figures")]
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
        return subprocess.run([ROOT / "scripts" / name, *map(str, arguments)], capture_output=True, text=True, timeout=600)

    def page(self):
        done = self.run_script("figures/experiments", "--runs", self.scratch / "runs", "--out", self.scratch / "docs/page.md")
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
            done = self.run_script("plot_batch", self.scratch / "b", "--column", "completed", *options, "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(out.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            out.unlink()
        for options, words in ((["--column", "complete", "--over", "pair"], "no column complete; there are completed"),
                               (["--column", "completed", "--over", "pair", "--kind", "line"], "needs numbers"),
                               (["--column", "why", "--over", "pair"], "no finished run with a number")):
            done = self.run_script("plot_batch", self.scratch / "b", *options)
            self.assertEqual((done.returncode, words in done.stderr, done.stderr.count("\n")), (1, True, 1), done.stderr)
        # what labs counted has a table of its own, and is drawn as a result is
        (self.scratch / "b/counters.csv").write_text("run,setting,pair,gate.period_s,seed,shark.bus.sent\n" + "".join(f"{run},0,Ro,2,1,{run}\n" for run in range(19)))
        done = self.run_script("plot_batch", self.scratch / "b", "--column", "shark.bus.sent", "--over", "pair", "--out", self.scratch / "plot.png")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("holds no runs.csv", self.run_script("plot_batch", self.scratch, "--column", "a", "--over", "b").stderr)

    def test_page_agrees_with_the_published_counts(self):
        """Our table made of the published software's own counts differs by nothing."""
        make_batch(self.scratch / "runs/dhtf-batch_original", ["solver", "robots", "pair", "mix"], original_rows(1.0))
        done, page = self.page()
        self.assertEqual(done.returncode, 0, done.stderr + page)
        self.assertEqual(page.count("| +0 % |"), 18)
        self.assertIn("| measured | Sh-Ro | all easy | 169.0 ± 13.3 | 10 | 169.0 ± 13.3 | 10 | +0 % | -10 to +11 % | agrees |", page)
        self.assertIn("| ideal | Sh-Sh | all hard | 55.2 ± 14.3 | 6 | 55.2 ± 14.3 | 6 | +0 % | -27 to +37 % | cannot be told |", page)
        self.assertIn("in 18 of 18 settings the 95 % interval of the difference holds 0.", page)
        self.assertIn("**What cannot be told:** DHTF beside the published software, 14 of 18 settings.", page)

    def test_further_seeds_count_with_the_others(self):
        """The batch of further seeds adds its runs to those of the same setting."""
        make_batch(self.scratch / "runs/dhtf-batch_original", ["solver", "robots", "pair", "mix"], original_rows(1.0))
        make_batch(self.scratch / "runs/dhtf-edges_original", ["solver", "robots", "pair", "mix"], original_rows(1.0)[:10])
        _, page = self.page()
        self.assertIn("| ideal | Sh-Ro | all easy | 169.0 ± 8.4 | 20 |", page)

    def test_known_curves_stay(self):
        """What another script writes below stays when the page is written anew, and anew again."""
        make_batch(self.scratch / "runs/dhtf-batch_original", ["solver", "robots", "pair", "mix"], original_rows(1.0))
        below = "\n## Known curves, with virtual sensors\n\nSentences.\n"
        (self.scratch / "docs").mkdir(parents=True, exist_ok=True)
        (self.scratch / "docs/page.md").write_text("# Of before\n" + below)
        _, page = self.page()
        self.assertTrue(page.endswith(" % |\n" + below) or page.endswith(".\n" + below), page[-300:])
        self.assertNotIn("Of before", page)
        self.assertEqual(self.page()[1], page)

    def test_page_names_what_does_not_agree(self):
        """A third more than published is said in the table and on top; with the paper's own claims the order is judged."""
        make_batch(self.scratch / "runs/dhtf-batch_original", ["solver", "robots", "pair", "mix"], original_rows(1.34))
        make_batch(self.scratch / "runs/dhtf-batch", ["pair", "mix"], dhtf_rows(1.0))
        done, page = self.page()
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("**What does not agree:** DHTF beside the published software, measured robots, Sh-Ro, all easy: +34 %", page)
        self.assertIn("**does not agree**", page)
        self.assertIn("| Ro-Ro: all easy > mixed | +71.9 |", page)
        self.assertTrue((self.scratch / "docs/experiments/dhtf.png").is_file())

    def test_page_of_cre(self):
        """Runs as the paper has them agree; without consensus they do not."""
        def run(kind, i):
            slow = kind == "symmetric"
            south = not slow or i % 2
            return (kind,), {"consensus.south": int(south), "consensus.north": int(not south), "consensus.ms": 1000 * (500 if slow else 60) + i,
                             "ground.followed_ms": 1000 * (700 if slow else 200) + i, "ground.south_ppm": 950_000 if south else 50_000,
                             "ground.middle_peak_ppm": 450_000}

        make_batch(self.scratch / "runs/cre-batch", ["resources"], [run(kind, i) for kind in ("asymmetric", "symmetric") for i in range(40)])
        done, page = self.page()
        self.assertEqual(done.returncode, 0, page)
        self.assertIn("| 40 of 40 |", page)
        self.assertIn("20 of 40 south", page)
        self.assertIn("| 35/35 is slower than 10/35 | 500 s, 60 s: +440 s | 440 to 440 s | agrees |", page)
        self.assertIn("| 35/35: either side wins, each in 35 to 65 % (the paper: 63 of 100 south) | 20 of 40 south | 0.35 to 0.65;", page)
        for row in ("asymmetric", "symmetric"):
            self.assertIn({"asymmetric": "10/35", "symmetric": "35/35"}[row], page)
        table = self.scratch / "runs/cre-batch/runs.csv"
        rows = list(csv.DictReader(table.read_text().splitlines()))
        for row in rows[:10]:
            row["consensus.south"], row["consensus.ms"] = "0", ""
        with open(table, "w", newline="") as out:
            writer = csv.DictWriter(out, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
        done, page = self.page()
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("30 of 40", page.split("\n")[4])

    def test_what_medians_alone_would_say_is_called_open(self):
        """Two samples with other medians and much the same numbers: which is slower cannot be told."""
        def run(kind, i):
            return (kind,), {"consensus.south": i % 2, "consensus.north": 1 - i % 2, "consensus.ms": 1000 * (60 + 5 * i + (kind == "symmetric")),
                             "ground.followed_ms": 900_000, "ground.south_ppm": 950_000, "ground.middle_peak_ppm": 450_000}

        make_batch(self.scratch / "runs/cre-batch", ["resources"], [run(kind, i) for kind in ("asymmetric", "symmetric") for i in range(40)])
        _, page = self.page()
        self.assertRegex(page, r"\| 35/35 is slower than 10/35 \| 158 s, 158 s: \+1 s \| -\d+ to \d+ s \| cannot be told \|")
        self.assertIn("35/35 is slower than 10/35", page.split("\n")[6])

    def test_page_of_cre_without_any_consensus(self):
        """No run has a time of consensus, so the table has no such column: the claims do not agree."""
        numbers = {"consensus.south": 0, "consensus.north": 0, "ground.south_ppm": 500_000, "ground.middle_peak_ppm": 300_000}
        make_batch(self.scratch / "runs/cre-batch", ["resources"], [((kind,), numbers) for kind in ("asymmetric", "symmetric") for _ in range(5)])
        done, page = self.page()
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        self.assertEqual(page.count("| 0 of 5 |"), 3)

    def test_page_of_causes(self):
        """What changes the mean for certain is named, the largest first."""
        rows = [((cause, mix), {"completed": base + step + i % 3}) for cause, step in (("as it is", 0), ("ice", 60), ("glue", -20))
                for mix, base in (("all easy", 150), ("mixed", 80), ("all hard", 40)) for i in range(6)]
        make_batch(self.scratch / "runs/dhtf-causes", ["cause", "mix"], rows)
        done, page = self.page()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertLess(page.index("ice (all hard: +146 %)"), page.index("glue (all hard: -49 %)"))

    def short(self, file, seconds):
        """An experiment that includes a shipped one, with two seeds and short runs."""
        text, choices = f'include = ["{file}"]\nseeds = "1..2"\n[set]\nrun.duration_s = {seconds}\n', ""
        shipped = tomllib.loads(file.read_text())
        for name in shipped.get("include", []):
            shipped.setdefault("choices", {}).update(tomllib.loads((file.parent / name).read_text())["choices"])
        for name, options in shipped["choices"].items():
            for option, keys in options.items():
                if "duration_s" in keys.get("run", {}):
                    choices += f'[choices.{name}."{option}"]\nrun.duration_s = {seconds}\n'
        short = self.scratch / "short.toml"
        short.write_text(text + choices)
        return short

    def test_shipped_experiments_run_in_short_and_give_the_page(self):
        """Every batch file of experiments/, two seeds of 30 s each: no run fails, and the page has a section for each."""
        files = [file for file in sorted((ROOT / "experiments").glob("*/*.toml")) if "seeds" in tomllib.loads(file.read_text()) or
                 file.name.startswith("batch")]
        self.assertGreaterEqual(len(files), 3)
        for file in files:
            if not (file.parent / tomllib.loads((file.parent / "batch.toml").read_text())["labs"][0]).is_file():
                continue
            with self.subTest(file.name):
                out = self.scratch / "runs" / f"{file.parent.name}-{file.stem}"
                done = subprocess.run([ROOT / "build/release/arkmesh", "batch", self.short(file, 30), "--out", out], capture_output=True,
                                      text=True, timeout=600)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                self.assertIn(" 0 failed", done.stdout)
        done, page = self.page()
        self.assertNotIn("Traceback", done.stderr)
        for title in ("## DHTF as the paper describes it", "## DHTF beside the published software", "### What the difference depends on"):
            self.assertIn(title, page)

    def test_readme_has_the_marks(self):
        """README has the three places that the script writes to."""
        text = (ROOT / "README.md").read_text()
        for name in ("validated", "DHTF", "CRE"):
            self.assertEqual((text.count(f"<!-- {name}: written by scripts/figures/experiments -->\n"), text.count(f"<!-- {name}: written by scripts/figures/experiments: end -->")), (1, 1))

    def test_nothing_to_tell(self):
        """Without batches it says which there could be."""
        (self.scratch / "runs").mkdir()
        done, _ = self.page()
        self.assertEqual((done.returncode, "run the batches first" in done.stderr), (1, True))


if __name__ == "__main__":
    unittest.main()
