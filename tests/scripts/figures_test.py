"""Which figures of documents are stale: on a small repository, and the list itself."""
import json
import pathlib
import subprocess
import sys
import tempfile
import tomllib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import measure_simulator  # noqa: E402

LIST = """
[told]
writes = ["page.md"]
commands = ["cat {runs}/x 2>/dev/null; mkdir -p {runs} && bash source.sh > page.md"]
sources = ["source.sh"]
probe = ["bash source.sh"]
[drawn]
writes = ["page.png"]
commands = ["cp source.sh page.png"]
sources = ["source.sh"]
"""


class Figures(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.root = pathlib.Path(scratch.name)
        (self.root / "scripts/figures").mkdir(parents=True)
        (self.root / "docs").mkdir()
        (self.root / "scripts/figures/figures.toml").write_text(LIST)
        (self.root / "source.sh").write_text("echo 1\n")
        self.git("init", "-q")
        self.commit()

    def git(self, *words):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@example.org", *words], cwd=self.root, check=True, capture_output=True)

    def commit(self):
        self.git("add", "source.sh")
        self.git("commit", "-qm", "a change")

    def run_all(self, *words):
        return subprocess.run([ROOT / "scripts/figures/all", "--root", self.root, *words], capture_output=True, text=True, timeout=600)

    def states(self):
        done = self.run_all("--check")
        return done.returncode, {line[16:].split()[0]: line[:15].strip() for line in done.stdout.splitlines()}

    def test_fresh_same_and_stale(self):
        """What was made is fresh; a change that does nothing leaves what has a probe; one that does something makes it stale."""
        self.assertEqual(self.states(), (1, {"told": "stale", "drawn": "stale"}))
        self.assertEqual(self.run_all("told", "drawn").returncode, 0)
        self.assertEqual((self.root / "page.md").read_text(), "1\n")
        self.assertEqual(self.states(), (0, {"told": "fresh", "drawn": "fresh"}))
        (self.root / "source.sh").write_text("# says one\necho 1\n")
        self.assertEqual(self.states(), (1, {"told": "same behaviour", "drawn": "stale"}))
        (self.root / "source.sh").write_text("echo 2\n")
        self.assertEqual(self.states(), (1, {"told": "stale", "drawn": "stale"}))
        self.commit()
        self.assertEqual(self.run_all("--stale").returncode, 0)
        self.assertEqual((self.root / "page.md").read_text(), "2\n")
        self.assertEqual(self.states(), (0, {"told": "fresh", "drawn": "fresh"}))
        (self.root / "page.png").unlink()
        self.assertEqual(self.states(), (1, {"told": "fresh", "drawn": "stale"}))

    def test_only_what_a_commit_holds(self):
        """A figure of sources that no commit holds is refused; so are unknown names."""
        (self.root / "source.sh").write_text("echo 3\n")
        done = self.run_all("told")
        self.assertEqual((done.returncode, "commit them first" in done.stderr), (1, True), done.stderr)
        self.assertFalse((self.root / "page.md").exists())
        done = self.run_all("page.md")
        self.assertEqual((done.returncode, "there are told, drawn" in done.stderr), (2, True), done.stderr)

    def test_a_failing_probe_is_said(self):
        """A probe that fails, or tells nothing, never counts as the same."""
        self.assertEqual(self.run_all("told").returncode, 0)
        for text, words in (("echo no >&2; exit 3\n", "failed with 3"), ("true\n", "told nothing")):
            (self.root / "source.sh").write_text(text)
            done = self.run_all("--check")
            self.assertEqual((done.returncode, words in done.stderr), (1, True), done.stderr)

    def test_the_list_names_what_is_there(self):
        """Every source and every script of the shipped list exists, and every file that a figure writes has a record."""
        records = json.loads((ROOT / "docs/figures.json").read_text())
        for name, figure in tomllib.loads((ROOT / "scripts/figures/figures.toml").read_text()).items():
            for path in [*figure["sources"], *figure["writes"]]:
                self.assertTrue((ROOT / path).exists(), f"{name}: {path}")
            for command in figure["commands"]:
                word = command.split()[0]
                self.assertTrue(not word.startswith("scripts/") or (ROOT / word).exists(), f"{name}: {command}")
            self.assertIn(name, records)

    def test_the_speed_table_is_todays(self):
        """README's table of speeds has the columns that its script writes, and tells commit and machine."""
        text = (ROOT / "README.md").read_text().split(f"<!-- {measure_simulator.SPEED_PLACE} -->\n")[1].split(f"<!-- {measure_simulator.SPEED_PLACE}: end -->")[0]
        self.assertRegex(text.splitlines()[0], r"^Commit [0-9a-f]{12}, .+, one run of \d{4}-\d\d-\d\d:$")
        rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
        self.assertEqual(rows[0], measure_simulator.SPEED_HEADER)
        self.assertEqual([row[0] for row in rows[1:]], [words for _, words, *_ in measure_simulator.SIZES])


if __name__ == "__main__":
    unittest.main()
