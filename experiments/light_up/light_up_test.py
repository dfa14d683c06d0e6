# Runs the scenario in two simulated labs, and looks at what came of it.
import pathlib
import tempfile
import unittest

import arkmesh

HERE = pathlib.Path(__file__).resolve().parent


class LightUpTest(unittest.TestCase):
    def test_robots_light_up_and_equal_seeds_give_equal_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            labs = HERE / "a.toml", HERE / "b.toml"
            first, again = (arkmesh.run(HERE / "light_up.py", *labs, seconds=20, seed=1, out=f"{folder}/{each}") for each in (1, 2))
            self.assertGreater(first.counts["lit_periods"], 0)
            self.assertTrue((first.labs["b"].led % 8).any())
            self.assertEqual(first.hash, again.hash)


if __name__ == "__main__":
    unittest.main()
