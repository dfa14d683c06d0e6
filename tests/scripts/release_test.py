"""What scripts/release refuses, what it changes, and that a failure leaves everything as it was: on a small repository with this tree's own files."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHANGES = "# Changes\n\n## 0.1.0, not released yet\n\n### Changed\n\n- Everything.\n"


class Release(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.root = pathlib.Path(scratch.name)
        for name in ("CMakeLists.txt", "CITATION.cff", "scenarios/python/arkmesh/__init__.py"):
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, self.root / name)
        (self.root / "CHANGELOG.md").write_text(CHANGES)
        (self.root / ".gitignore").write_text("build/\n")
        # Stand-ins for what takes hours.
        for name, does in (("scripts/test", "true"), ("tests/figures/all", "true"), ("scripts/alone", 'exec "$@"'), ("scripts/measure", "echo fast enough"),
                           ("scripts/site", "mkdir -p build/site; date >build/site/index.html"),
                           ("scripts/package/make", "mkdir -p build/$2/package; date >build/$2/package/arkmesh.deb")):
            script = self.root / name
            script.parent.mkdir(parents=True, exist_ok=True)
            script.write_text(f"#!/bin/sh\n{does}\n")
            script.chmod(0o755)
        self.git("init", "-q", "-b", "main")
        self.git("config", "user.name", "a")
        self.git("config", "user.email", "a@example.org")
        self.commit()

    def git(self, *words):
        return subprocess.run(["git", *words], cwd=self.root, check=True, capture_output=True, text=True).stdout.strip()

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "x")

    def release(self, *words):
        return subprocess.run([ROOT / "scripts/release", "--root", self.root, *words], capture_output=True, text=True)

    def refused(self, words, *arguments):
        head = self.git("rev-parse", "HEAD")
        done = self.release(*arguments)
        self.assertEqual(done.returncode, 2, done.stdout)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(words, done.stderr)
        self.assertEqual(self.git("rev-parse", "HEAD"), head)

    def test_refuses_what_is_no_release(self):
        for version in ("1", "1.0", "v1.0.0", "1.0.0.0", "01.0.0", "1.0.x"):
            self.refused("is no version", version)
        (self.root / "new.txt").write_text("x")
        self.refused("(new.txt)", "0.1.0")
        self.commit()
        self.git("tag", "v0.3.0")
        self.refused("0.3.0 is released already", "0.3.0")
        self.refused("above 0.2.9", "0.2.9")
        self.assertEqual(self.release("0.10.0", "--dry-run").returncode, 0)  # numbers, not text
        self.git("checkout", "-q", "--detach")
        self.refused("no branch", "0.4.0")
        self.git("checkout", "-q", "main")
        (self.root / "CHANGELOG.md").write_text("# Changes\n\n## 0.5.0, 2026-01-01\n\n- Everything.\n")
        self.commit()
        self.refused("0.5.0 is released already", "0.5.0")
        self.refused("tells no change", "0.6.0")

    def test_a_dry_run_says_all_and_changes_nothing(self):
        done = self.release("0.1.0", "--dry-run")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for words in ("+## 0.1.0, 2", "+date-released: 2", "would run: scripts/test", "--suite trixie --check", "scripts/measure", "would run: scripts/site"):
            self.assertIn(words, done.stdout)
        self.assertEqual(self.git("status", "--porcelain"), "")
        self.assertFalse((self.root / "build").exists())

    def test_a_release_is_one_commit_with_version_date_and_tag(self):
        done = self.release("0.2.0")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.git("log", "-1", "--format=%s"), "Release 0.2.0")
        self.assertEqual(self.git("rev-parse", "v0.2.0^{commit}"), self.git("rev-parse", "HEAD"))
        self.assertEqual(self.git("diff", "--name-only", "HEAD~1").split(), ["CHANGELOG.md", "CITATION.cff", "CMakeLists.txt", "scenarios/python/arkmesh/__init__.py"])
        self.assertIn("project(arkmesh VERSION 0.2.0 ", (self.root / "CMakeLists.txt").read_text())
        self.assertRegex((self.root / "CITATION.cff").read_text(), r"(?m)^version: 0\.2\.0\ndate-released: \d{4}-\d\d-\d\d$")
        self.assertRegex((self.root / "CHANGELOG.md").read_text(), r"(?m)^## 0\.2\.0, \d{4}-\d\d-\d\d$")
        self.assertEqual(self.git("status", "--porcelain"), "")
        self.assertEqual(len(self.git("worktree", "list").splitlines()), 1)
        folder = self.root / "build/releases/0.2.0"
        measured = (folder / "measure.txt").read_text()
        self.assertIn(self.git("rev-parse", "HEAD"), measured)
        self.assertIn("fast enough", measured)
        for name in ("packages/bookworm/arkmesh.deb", "packages/trixie/arkmesh.deb", "site/index.html"):
            self.assertTrue((folder / name).is_file(), name)
        # The next one: nothing is told yet; then once more.
        self.refused("tells no change", "0.3.0")
        changes = self.root / "CHANGELOG.md"
        changes.write_text(changes.read_text().replace("## 0.2.0", "## 0.3.0, not released yet\n\n- More.\n\n## 0.2.0"))
        self.commit()
        self.assertEqual(self.release("0.3.0").returncode, 0)
        self.assertEqual((self.root / "CITATION.cff").read_text().count("date-released"), 1)

    def test_a_red_state_is_not_released(self):
        for red in ("scripts/test", "tests/figures/all", "scripts/package/make", "scripts/measure"):
            script = self.root / red
            green = script.read_text()
            script.write_text("#!/bin/sh\necho this is red\nexit 1\n")
            self.commit()
            head = self.git("rev-parse", "HEAD")
            done = self.release("0.1.0")
            self.assertEqual(done.returncode, 1, red)
            self.assertIn("nothing is released", done.stderr)
            self.assertIn("this is red", pathlib.Path(done.stderr.split("see ")[1].split(";")[0]).read_text())
            self.assertEqual((self.git("rev-parse", "HEAD"), self.git("tag")), (head, ""))
            self.assertEqual(self.git("status", "--porcelain"), "")
            script.write_text(green)
        self.commit()
        self.assertEqual(self.release("0.1.0").returncode, 0)  # what a failed one left is in no way


if __name__ == "__main__":
    unittest.main()
