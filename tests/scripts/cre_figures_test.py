"""What the scripts for CRE's figures compute from runs."""
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/figures"))

import cre_runs
import pages


def row(south, agreed_s, followed_s=0, south_ppm=0, middle_ppm=0, periods=10, held=10):
    """A run's counts; agreed_s = 0: no consensus."""
    out = {"consensus.south": int(agreed_s > 0 and south), "consensus.north": int(agreed_s > 0 and not south), "consensus.ms": agreed_s * 1000,
           "consensus.periods": periods if agreed_s else 0, "consensus.held": held if agreed_s else 0, "ground.followed_ms": followed_s * 1000,
           "ground.south_ppm": south_ppm, "ground.middle_peak_ppm": middle_ppm, "flying.south_ppm": 900_000 * south, "flying.north_ppm": 0}
    return out


class CreFigures(unittest.TestCase):
    def test_summary(self):
        """Runs are counted by side; times, delays and shares are of the runs that have them."""
        s = cre_runs.summary([
            row(True, 60, 150, 980_000, 300_000), row(True, 200, 260, 900_000, 500_000, held=5), row(False, 400, 0, 150_000, 700_000),
            row(False, 0, 0, 500_000, 400_000)])
        self.assertEqual((s["runs"], s["south"], s["north"]), (4, 2, 1))
        self.assertEqual((s["by"](60), s["by"](200), s["by"](900)), (0.25, 0.5, 0.75))
        self.assertAlmostEqual(s["held"], 25 / 30)
        self.assertEqual(s["behind"], [90, 60])
        self.assertEqual(s["middle_late"], [0.5, 0.7])
        for share, expected in zip(s["ground_with_winner"], (0.98, 0.9, 0.85)):
            self.assertAlmostEqual(share, expected)
        self.assertEqual(len(s["ground_south"]), 4)

    def test_no_consensus_at_all(self):
        """Nothing is divided by zero when no run agrees."""
        s = cre_runs.summary([row(False, 0)])
        self.assertEqual((s["south"], s["north"], s["times"], s["held"], s["by"](900)), (0, 0, [], 0, 0))

    def test_quantiles(self):
        """The q-quantile is the smallest value that a share q does not exceed."""
        self.assertEqual([cre_runs.quantile(range(1, 11), q) for q in (0.1, 0.5, 0.9, 1)], [1, 5, 9, 10])
        self.assertEqual(cre_runs.quantile([7], 0.5), 7)

    def test_page(self):
        """Only what stands between the marks is written anew."""
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "page.md"
            page.write_text("before\n<!-- a -->\nold\n<!-- a: end -->\nafter\n<!-- b -->\n<!-- b: end -->\n")
            pages.write_between(page, "a", "new\n")
            self.assertEqual(page.read_text(), "before\n<!-- a -->\nnew\n<!-- a: end -->\nafter\n<!-- b -->\n<!-- b: end -->\n")

    def test_pages_have_the_marks(self):
        """docs/cre-results.md has the places that both scripts write to."""
        text = (ROOT / "docs/cre-results.md").read_text()
        for name in ("paper: written by scripts/figures/cre_results", "original: written by scripts/figures/cre_results",
                     "sensitivity: written by scripts/figures/cre_sensitivity"):
            self.assertEqual((text.count(f"<!-- {name} -->\n"), text.count(f"<!-- {name}: end -->")), (1, 1))


if __name__ == "__main__":
    unittest.main()
