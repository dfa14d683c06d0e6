"""scripts/arrows on small trees of its own: what it prints and what it refuses. scripts/alone: alone it is."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = """<!-- arrows: read by scripts/arrows -->
| folder | what it is for | may include |
|---|---|---|
| `hal` | below | `lcmtypes` |
| `hal/platforms/*` | robots | `hal` |
| `lab` | above | `hal` `lcmtypes` |
| `side` | beside | `lab` `hal` |
| `app` | roof | all but `cli` |
| `cli` | words | all |
<!-- arrows: end -->
"""


class Arrows(unittest.TestCase):
    def run_on(self, files):
        """Exit code and words for a tree of {path: included path}."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for path in ["scripts", "docs"]:
                (root / path).mkdir()
            shutil.copy(ROOT / "scripts/arrows", root / "scripts/arrows")
            (root / "docs/architecture.md").write_text(TABLE)
            for path, included in files.items():
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(f'#include "{included}"\n' if included else "")
            done = subprocess.run([root / "scripts/arrows"], capture_output=True, text=True)
            return done.returncode, done.stdout + done.stderr

    def test_allowed(self):
        """Arrows that the table allows pass, and are counted by files; a row for a family of folders holds for each of them."""
        code, said = self.run_on({"hal/bus.hpp": "", "lab/a.cpp": "hal/bus.hpp", "lab/b.cpp": "hal/bus.hpp",
                                  "hal/platforms/bee/bee.hpp": "hal/bus.hpp", "app/x.cpp": "hal/platforms/bee/bee.hpp"})
        self.assertEqual(code, 0, said)
        self.assertRegex(said, r"lab +-> hal +2 files\n")
        self.assertIn("arrows: 3 arrows, all allowed, no circle", said)

    def test_refused(self):
        """Upwards, sideways, into a test, to nothing, from one robot to another, from a folder without a row: each is said."""
        for files, sentence in (
                ({"lab/l.hpp": "", "hal/h.cpp": "lab/l.hpp"}, "hal includes lab (1 files)"),
                ({"cli/c.hpp": "", "app/a.cpp": "cli/c.hpp"}, "app includes cli (1 files)"),
                ({"hal/platforms/bee/b.hpp": "", "hal/h.cpp": "hal/platforms/bee/b.hpp"}, "hal includes hal/platforms/bee (1 files)"),
                ({"hal/platforms/bee/b.hpp": "", "hal/platforms/ant/a.cpp": "hal/platforms/bee/b.hpp"}, "hal/platforms/ant includes hal/platforms/bee"),
                ({"lab/a.cpp": "tests/support/a.hpp"}, "lab/a.cpp:1: includes a test"),
                ({"lab/a.cpp": "lab/gone.hpp"}, "lab/a.cpp:1: there is no lab/gone.hpp"),
                ({"new/a.cpp": ""}, "new/a.cpp: its folder has no row")):
            code, said = self.run_on(files)
            self.assertEqual((code, sentence in said), (1, True), said)

    def test_circle(self):
        """Folders that include each other by way of a third are a circle, whatever the table says."""
        code, said = self.run_on({"lab/l.hpp": "app/a.hpp", "side/s.hpp": "lab/l.hpp", "app/a.hpp": "side/s.hpp"})
        self.assertEqual(code, 1)
        self.assertIn("circle: app and lab and side include each other", said)


class Alone(unittest.TestCase):
    def test_alone(self):
        """A command gets its arguments, gives its exit code, has loopback and a multicast route, and nobody else's ports."""
        alone = ROOT / "scripts/alone"
        done = subprocess.run([alone, "sh", "-c", 'ip route get 239.255.76.67; ip -o addr; echo "$1"; exit 5', "-", "a b"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertIn("dev lo", done.stdout)
        self.assertIn("a b\n", done.stdout)
        self.assertNotIn("eth0", done.stdout)

    def test_no_namespace(self):
        """Where no namespace can be made the command does not run, and the exit code is 77, which ctest counts as not run."""
        with tempfile.TemporaryDirectory() as folder:
            stub = pathlib.Path(folder) / "unshare"
            stub.write_text("#!/bin/sh\necho unshare: Operation not permitted >&2\nexit 1\n")
            stub.chmod(0o755)
            done = subprocess.run([ROOT / "scripts/alone", "echo", "ran"], capture_output=True, text=True, env={"PATH": f"{folder}:/usr/sbin:/usr/bin:/sbin:/bin"})
            self.assertEqual((done.returncode, done.stdout), (77, ""))
            self.assertIn("not run: echo", done.stderr)


if __name__ == "__main__":
    unittest.main()
