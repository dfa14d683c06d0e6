"""The list of figures in documents, and the simulator's table of speeds."""
import json
import pathlib
import tomllib
import unittest

import run_folder  # noqa: F401  finds the modules of scripts
import measure_simulator

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Figures(unittest.TestCase):
    def test_the_list_names_what_is_there(self):
        """Every source and every script of the shipped list exists, and every file that a figure writes has a record."""
        records = json.loads((ROOT / "docs/figures.json").read_text())
        for name, figure in tomllib.loads((ROOT / "tests/figures/figures.toml").read_text()).items():
            for path in [*figure["sources"], *figure["writes"]]:
                self.assertTrue((ROOT / path).exists(), f"{name}: {path}")
            for command in figure["commands"]:
                word = command.split()[0]
                self.assertTrue(not word.startswith(("scripts/", "tests/")) or (ROOT / word).exists(), f"{name}: {command}")
            self.assertIn(name, records)

    def test_the_speed_table_is_todays(self):
        """The table of speeds has the columns that its script writes, and tells commit and machine."""
        text = (ROOT / "docs/simulator-speed.md").read_text().split(f"<!-- {measure_simulator.SPEED_PLACE} -->\n")[1].split(f"<!-- {measure_simulator.SPEED_PLACE}: end -->")[0]
        self.assertRegex(text.splitlines()[0], r"^Commit [0-9a-f]{12}, .+, one run of \d{4}-\d\d-\d\d:$")
        rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
        self.assertEqual(rows[0], measure_simulator.SPEED_HEADER)
        self.assertEqual([row[0] for row in rows[1:]], [words for _, words, *_ in measure_simulator.SIZES])


if __name__ == "__main__":
    unittest.main()
