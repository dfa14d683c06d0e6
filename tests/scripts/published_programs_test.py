"""tests/figures/published_programs, on programs of our own in place of published ones."""
import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINE = '[[program]]\nname = "{name}"\nrepository = "us/{repository}"\ncommit = "0123456789"\nfiles = ["{file}"]\nrules = "robot"\nseconds = 6\n'
LAB = 'lab = """\nrobots = 2\n[arena.ode]\ncontroller = "$"\nspeed_m_per_s = 0.01\n"""\nsays = "way, m"\n'
WAY = 'measure = "np.hypot(*(xy[-1] - xy[0]).T).mean()"\nexpected = [0.02, 0.1]\ncontrol_says = "slower"\ncontrol = [["0.01", "{slower}"]]\n'


class PublishedPrograms(unittest.TestCase):
    def run_list(self, *rows):
        with tempfile.TemporaryDirectory() as folder:
            there = pathlib.Path(folder) / "us/ahead/0123456"
            there.mkdir(parents=True)
            os.symlink(ROOT / "tests/sim_ode/controllers/all_ahead.c", there / "ahead.c")
            (there.parents[2] / "list.toml").write_text("\n".join(rows))
            done = subprocess.run([ROOT / "tests/figures/published_programs", folder, "--list", f"{folder}/list.toml"], capture_output=True, text=True, timeout=300)
            return done.returncode, done.stdout

    def test_rows_are_judged(self):
        """A row is right when all seeds give what is expected and its control never does; what is not there is skipped by name."""
        ahead = LINE.format(name="ahead", repository="ahead", file="ahead.c") + LAB
        code, said = self.run_list(ahead + WAY.format(slower="0.001"), LINE.format(name="gone", repository="gone", file="x.c") + LAB + WAY.format(slower="0.001"))
        self.assertIn("skipped, not in ", said)
        self.assertIn(": gone (us/gone at 0123456)", said)
        self.assertRegex(said, r"(?m)^ahead \|.* \| yes \| \w+(, changed)?$")
        self.assertIn("1 of 1 are right", said)
        self.assertEqual(code, 0)
        # a control that does not fail, and a measure that is not met
        for wrong in (WAY.format(slower="0.012"), WAY.format(slower="0.001").replace("0.02, 0.1", "0.2, 1")):
            code, said = self.run_list(ahead + wrong)
            self.assertRegex(said, r"(?m)^ahead \|.* \| no \| \w+(, changed)?$")
            self.assertEqual(code, 1)

    def test_nothing_there_is_not_right(self):
        """A folder without any of the programs ends with 1, and names what it lacks."""
        code, said = self.run_list(LINE.format(name="gone", repository="gone", file="x.c") + LAB + WAY.format(slower="0.001"))
        self.assertEqual((code, said.splitlines()[-1]), (1, "0 of 0 are right"))


if __name__ == "__main__":
    unittest.main()
