"""calibration/fit: simulated robots of preset "measured" are like the real ones of its data."""
import importlib.machinery
import importlib.util
import os
import pathlib
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
loader = importlib.machinery.SourceFileLoader("fit", str(ROOT / "calibration/fit"))
fit = importlib.util.module_from_spec(importlib.util.spec_from_loader("fit", loader))
loader.exec_module(fit)


class Fit(unittest.TestCase):
    def test_measured_robots(self):
        """Reception in both regimes, the distance of first receptions and the turn of straight drivers are within their tolerances; none holds of the reach before the fit (by night)."""
        for what, value, least, most in fit.compare("measured"):
            with self.subTest(what):
                print(f"{what}: {value:.3f}")
                self.assertTrue(least <= value <= most, f"{value:.4f} is not within {least} to {most}")
        if "ARKMESH_THOROUGH" not in os.environ:
            return
        before = {what: not least <= value <= most for what, value, least, most in fit.compare("measured_0")}
        self.assertTrue(all(off for what, off in before.items() if what.startswith(("first reception", "straight drivers: turn"))), before)

    def test_table_of_logs(self):
        """The table's means are those of the logs, each distance once, in both sessions."""
        self.assertEqual([round(shares.mean(), 3) for shares in fit.logged("0").values()],
                         [0.971, 0.965, 0.960, 0.958, 0.954, 0.945, 0.946, 0.932, 0.511, 0.273, 0.628, 0.136, 0.161, 0.034])
        self.assertEqual([len(fit.logged(tau)[5.0]) for tau in fit.SESSIONS], [10, 20, 20])
        numpy.testing.assert_allclose([fit.logged("0.5")[cm].mean() for cm in (5.0, 14.1, 15.8)], [0.959, 0.791, 0.147], atol=0.0006)


if __name__ == "__main__":
    unittest.main()
