"""A file is the same file however its path is spelled: what commands print and write does not depend on it."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/arkmesh"
HELLO = """#include <kilolib.h>
#include <stdio.h>
static message_t m;
static message_t *tx(void) { return &m; }
static void rx(message_t *heard, distance_measurement_t *d) { (void)heard; (void)d; if (kilo_ticks < 100) printf("heard\\n"); }
static void setup(void) { m.crc = message_crc(&m); printf("here is %d\\n", kilo_uid); }
static void loop(void) { set_motors(kilo_straight_left, 0); }
int main(void) { kilo_init(); kilo_message_tx = tx; kilo_message_rx = rx; kilo_start(setup, loop); return 0; }
"""
LENS = """%YAML:1.0
---
image_width: 1000
image_height: 1000
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1500., 0., 500., 0., 1500., 500., 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
"""
CORNERS = "--corner 159.1,170.7 --corner 840.9,170.7 --corner 886.4,873.2 --corner 113.6,873.2"  # as that lens sees a square metre, 2 m below
# what is given, the command, and what it writes; OUT is a new path, PATH the file
COMMANDS = {
    "controller run": ("x/robot.c", "controller run PATH --robots 4 --spacing 0.05 --seconds 8 --csv OUT"),
    "controller check": ("x/robot.c", "controller check PATH"),
    "config --airtime": ("x/a.toml", "config --airtime PATH"),
    "config --keys": ("x/light_up.py", "config --keys PATH"),
    "explain": ("x/a.toml", "explain world --to b PATH"),
    "run": ("x/a.toml", "run PATH --seconds 4 --out OUT"),
    "batch": ("x/batch.toml", "batch PATH --out OUT"),
    "rerun": ("done", "rerun PATH --out OUT"),
    "export": ("done", "export PATH --csv --out OUT"),
    "lab": ("x/alone.toml", "lab PATH --out OUT"),
    "view": ("done", "view PATH"),
    "plot": ("done", "plot PATH --out OUT.png"),
    "calibrate": ("x/lens.yaml", f"calibrate --intrinsics PATH {CORNERS} --out OUT.yaml"),
    "track": ("x/robots.jpg", "track PATH --csv OUT"),
}


class Spellings(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="arkmesh-spellings-")).resolve()
        self.addCleanup(shutil.rmtree, self.folder)
        for name in ("x", "y"):
            (self.folder / name).mkdir()
        (self.folder / "x/robot.c").write_text(HELLO)
        for name in ("a.toml", "light_up.py"):
            shutil.copy(ROOT / "experiments/light_up" / name, self.folder / "x")
        text = (self.folder / "x/a.toml").read_text()
        text = re.sub(r'controller *= *".*"', 'controller = "robot.c"', text)
        (self.folder / "x/a.toml").write_text(text)
        (self.folder / "x/alone.toml").write_text(text.replace("duration_s = 120", "duration_s = 1").replace('labs = ["a", "b"]', 'labs = ["a"]'))
        (self.folder / "x/batch.toml").write_text('labs = ["a.toml"]\nseeds = "1..2"\n[set]\nrun.duration_s = 4.0\n')
        (self.folder / "x/lens.yaml").write_text(LENS)
        shutil.copy(ROOT / "docs/camera-good.jpg", self.folder / "x/robots.jpg")
        os.symlink("../x", self.folder / "y/link")
        os.symlink("../x", self.folder / "y/ä b")
        self.assertEqual(self.said("run", "x/a.toml", "--seconds", "4", "--out", "done")[0], 0)

    def shown(self, *words):
        """What is printed up to the page's address, and the page there."""
        with subprocess.Popen([PROGRAM, *words], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as view:
            lines = []
            while not lines or not lines[-1].startswith("see it at "):
                self.assertTrue(line := view.stdout.readline(), lines)
                lines.append(line)
            with urllib.request.urlopen(lines[-1].split()[-1].partition("#")[0], timeout=60) as page:
                lines.append(page.read().decode())
            view.terminate()
        return 0, "".join(lines)

    def said(self, *words):
        if words[0] == "view":
            return self.shown(*words)
        done = subprocess.run([PROGRAM, *words], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
        return done.returncode, done.stdout

    def spellings(self, path):
        """The same file: plain, ./, through another folder, with //, absolute, through a link, through one with a space and an umlaut."""
        last = pathlib.Path(path).name
        out = [path, f"./{path}", f"y/../{path}", f".//{path}".replace("x/", "x//"), f"{self.folder}/{path}"]
        if path.startswith("x/"):
            return out + [f"y/link/{last}", f"y/ä b/{last}"]
        for name in ("link to it", "ä b"):
            if not (self.folder / name).exists():
                os.symlink(path, self.folder / name)
        return [*out, "link to it", "ä b"]

    def answer(self, command, spelling, out):
        """Exit code, what is printed and what is written, but for the path itself and what the clock says."""

        code, text = self.said(*(word.replace("OUT", out).replace("PATH", spelling) for word in command.split()))
        def plain(words):
            for path in sorted({spelling, str((self.folder / spelling).parent) + "/" + pathlib.Path(spelling).name, str((self.folder / spelling).resolve()), out}, key=len, reverse=True):
                words = words.replace(path, "PATH")
            return words

        text = "\n".join(line for line in plain(text).splitlines() if not re.search(r"\d x\)|\dx\)|\dx  eta|built in|wall|see it at|TCP port|  period \d| in \d+(\.\d+)? s|\d/\d+ runs", line))
        files = sorted(path for path in [self.folder / out, *(self.folder / out).rglob("*")] if path.is_file())
        return code, text, {plain(str(path.relative_to(self.folder))): path.read_bytes() for path in files if path.suffix in (".csv", ".yaml")}, [plain(str(path)) for path in files]

    def test_commands_know_a_file_however_it_is_spelled(self):
        """Each command takes the plain path and two other spellings in rotation, so at least four commands try each; with ARKMESH_THOROUGH all try all."""
        for number, (name, (path, command)) in enumerate(COMMANDS.items()):
            first, (plain, *others) = None, self.spellings(path)
            if "ARKMESH_THOROUGH" not in os.environ:
                others = [others[(2 * number + k) % len(others)] for k in range(2)]
            for k, spelling in enumerate([plain, *others]):
                with self.subTest(command=name, spelling=spelling):
                    answer = self.answer(command, spelling, f"out{k}-{name.replace(' ', '-')}")
                    if first is None:
                        first = answer
                        self.assertEqual(first[0], 0, first[1])
                    for mine, plains in zip(answer, first):
                        self.assertEqual(mine, plains)


if __name__ == "__main__":
    unittest.main()
