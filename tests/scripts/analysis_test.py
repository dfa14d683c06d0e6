"""Figures, tables and studies from Python and from the command line: what a journal takes, and what the package says of types and scenarios."""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
ARKMESH, PYTHON = ROOT / "build/release/arkmesh", "/usr/bin/python3"
LIGHT_UP = ROOT / "experiments/light_up"
ENVIRONMENT = {**os.environ, "ARKMESH_PYTHON": PYTHON, "PYTHONPATH": str(ROOT / "scenarios/python")}
sys.path.append(str(ROOT / "drawing"))
# pylint: disable=wrong-import-position
import figure_style
import painted_film  # finds the package, too
import arkmesh
from PIL import Image


def called(*words, **how):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=600, env=ENVIRONMENT, **how)


class Analysis(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.script(f"""
            arkmesh.run("{LIGHT_UP}/light_up.py", *LABS, seconds=5, seed=3, out="run")
            arkmesh.sweep("{LIGHT_UP}/light_up.py", *LABS, settings={{"reach_m": [0.05, 0.2], "a:arena.robots": 9}}, seeds=[3, 5], seconds=5, out="swept", progress=False)
            """)

        done = called(ARKMESH, "run", ROOT / "experiments/dhtf/shark.toml", ROOT / "experiments/dhtf/roark.toml", "--seconds", 60, "--out", cls.folder / "demo")
        assert done.returncode == 0, done.stderr

    @classmethod
    def script(cls, text):
        done = called(PYTHON, "-c", f"import json, arkmesh, numpy as np\nLABS = {[str(LIGHT_UP / name) for name in ('a.toml', 'b.toml')]}\n" + textwrap.dedent(text), cwd=cls.folder)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def assert_printable(self, *files):
        for file in files:
            fonts = called("pdffonts", self.folder / file).stdout.splitlines()[2:]
            self.assertTrue(fonts, file)
            for font in fonts:
                self.assertIn("TrueType", font, file)

    def width_of(self, file):
        return float(re.search(r"Page size: +([\d.]+) x", called("pdfinfo", self.folder / file).stdout)[1]) / 72

    def test_figures_are_what_journals_take(self):
        """PDFs of every command and method, and those that a user saves after one, hold TrueType fonts and are as wide as a column or a page."""
        for words in (("run", "--out", "run.pdf"), ("run", "--width", "column", "--out", "narrow.pdf"), ("demo", "--curves", "--title", "Tasks", "--out", "curves.pdf")):
            done = called(ARKMESH, "plot", *words, cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.script("""
            import matplotlib
            matplotlib.use("Agg")
            import matplotlib.pyplot as plt
            run, swept = arkmesh.open_run("run"), arkmesh.open_run("swept")
            arenas = run.plot(3.0, out="python_run.pdf")
            assert sorted(arenas) == ["a", "b"] and arenas["a"].get_xlabel() == "x (m)"
            axes = swept.plot("scenario.light_up.reach_m", "lit_periods", width="column", out="python_batch.pdf")
            assert (axes.get_xlabel(), axes.get_ylabel()) == ("light up reach (m)", "lit periods"), (axes.get_xlabel(), axes.get_ylabel())
            assert all(tick == round(tick) for tick in axes.get_yticks())
            figure, mine = plt.subplots()
            assert swept.plot("scenario.light_up.reach_m", "lit_periods", axes=mine, xlabel="reach", title="Mine") is mine and mine.get_title() .startswith("Mine")
            figure.savefig("mine.pdf")
            """)
        self.assert_printable("run.pdf", "narrow.pdf", "curves.pdf", "python_run.pdf", "python_batch.pdf", "mine.pdf")
        for file, inches in (("run.pdf", 7.16), ("narrow.pdf", 3.5), ("python_batch.pdf", 3.5)):
            self.assertAlmostEqual(self.width_of(file), inches, delta=0.02, msg=file)

    def test_a_film_without_a_browser(self):
        """Where Chromium lacks, arenas are painted, with a clock that goes on and a scale; what cannot be done without it names what is missing."""
        def film(*words, lacks=("selenium",), path=os.environ["PATH"]):
            script = (f"import importlib.util, runpy, sys\nfind = importlib.util.find_spec\nimportlib.util.find_spec = lambda name, *more: None if name in {lacks!r} else find(name, *more)\n"
                      f"sys.argv = ['film', *{list(words)!r}]\nsys.path.insert(0, {str(ROOT / 'drawing')!r})\nrunpy.run_path({str(ROOT / 'drawing/film')!r}, run_name='__main__')")
            return subprocess.run([PYTHON, "-c", script], cwd=self.folder, capture_output=True, text=True, timeout=600, env={**ENVIRONMENT, "PATH": path})

        done = film("demo", "--out", "demo.mp4", "--size", "640x360", "--fps", "5", "--speed", "20", "--to", "40")
        self.assertEqual((done.returncode, done.stdout), (0, "demo.mp4: 10 pictures, 2.0 s\n"), done.stderr)
        self.assertIn("film: python3-selenium is missing, so the film shows the arenas only", done.stderr)
        told = called("ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames,width,height", "-of", "csv=p=0", self.folder / "demo.mp4").stdout.strip()
        self.assertEqual(told, "640,360,10")
        raw = subprocess.run(["ffmpeg", "-loglevel", "error", "-i", self.folder / "demo.mp4", "-f", "rawvideo", "-pix_fmt", "gray", "-"], capture_output=True, check=True).stdout
        moments = [raw[i * 640 * 360:(i + 1) * 640 * 360] for i in range(10)]
        captions = [moment[334 * 640:] for moment in moments]
        self.assertEqual(len(set(captions)), 10)  # the clock
        self.assertTrue(all(min(caption) < 100 for caption in captions))
        self.assertEqual(len({moment[:300 * 640] for moment in moments}), 10)  # robots
        for words, lacks, path, wanted in ((("demo", "--whole"), ("selenium",), os.environ["PATH"], "film: this machine lacks python3-selenium; sudo apt-get install python3-selenium\n"),
                                           (("demo",), ("selenium",), "/nowhere", "film: this machine lacks ffmpeg; sudo apt-get install ffmpeg\n"),
                                           (("demo",), ("selenium", "PIL"), os.environ["PATH"], "film: this machine lacks python3-selenium, python3-pil; sudo apt-get install python3-selenium python3-pil\n")):
            refused = film(*words, "--out", "none.mp4", lacks=lacks, path=path)
            self.assertEqual((refused.returncode, refused.stderr), (1, wanted))
        self.assertFalse((self.folder / "none.mp4").exists())

    def test_leds_have_the_colours_of_the_page(self):
        """What moves is blue in DHTF: RGB(0,0,1) is one colour in a picture, in a painted film, in a swarm's picture and on the page (page_test)."""
        blue = tuple(bytes.fromhex(json.loads((ROOT / "view/page/colours.json").read_text())["leds"]["light"][4][1:]))
        self.assertEqual(called(ARKMESH, "plot", "demo", "--out", "blue.png", cwd=self.folder).returncode, 0)
        (self.folder / "poses.csv").write_text("time_s,robot,x_m,y_m,heading_rad,led\n0,0,0.1,0.2,1,blue\n")
        called(ROOT / "drawing/draw_swarm", "poses.csv", "--diameter", 0.033, "--png", "swarm.png", cwd=self.folder)
        labs = list(arkmesh.open_run(self.folder / "demo").labs.values())
        film = Image.frombytes("RGB", (640, 360), next(painted_film.pictures(labs, 0, 60, 1, 60, 20, 640, 360))[1])
        trails = [sum(list(Image.frombytes("RGB", (640, 360), next(painted_film.pictures(labs, 0, 60, 1, 60, 20, 640, 360, trail_s))[1]).getdata()).count(
            tuple(bytes.fromhex(colour[1:]))) for colour in painted_film.TRAILS) for trail_s in (0, 10, 60)]
        self.assertEqual(trails[0], 0)
        self.assertTrue(0 < trails[1] < trails[2], trails)
        for picture in (film, *(Image.open(self.folder / name).convert("RGB") for name in ("blue.png", "swarm.png"))):
            self.assertGreater(list(picture.getdata()).count(blue), 20)

    def test_a_batch_says_how_its_figures_look(self):
        """[[plot]] takes words and a width; a width that there is not is refused where it is written."""
        text = (f'labs = ["{LIGHT_UP}/a.toml", "{LIGHT_UP}/b.toml"]\nseeds = "1..2"\n[set]\n"run.duration_s" = 2\n[sweep]\n"scenario.light_up.reach_m" = [0.05, 0.2]\n'
                '[[plot]]\ncolumn = "lit_periods"\nover = "scenario.light_up.reach_m"\nwidth = "column"\nylabel = "robots that are lit"\ntitle = "Lights"\n')
        (self.folder / "study.toml").write_text(text)
        done = called(ARKMESH, "batch", "study.toml", "--out", "study", cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        picture = self.folder / "study/lit_periods-over-scenario.light_up.reach_m.png"
        self.assertEqual(int.from_bytes(picture.read_bytes()[16:20], "big"), 1050)
        words = called(ARKMESH, "batch", "study.toml", "--out", "study", "--plot", "lit_periods", "--over", "scenario.light_up.reach_m", "--width", "huge", cwd=self.folder)
        self.assertNotEqual(words.returncode, 0)
        (self.folder / "wide.toml").write_text(text.replace('"column"\nylabel', '"wide"\nylabel'))
        refused = called(ARKMESH, "batch", "wide.toml", "--out", "wide", cwd=self.folder)
        self.assertIn('width of a [[plot]] is "column" or "page"', refused.stderr)

    def test_names_become_labels(self):
        for name, label in {"gate.period_s": "gate period (s)", "completed": "completed", "lit_periods@b": "lit periods, lab b", "scenario.dhtf.reach_m": "dhtf reach (m)",
                            "consensus.ms": "consensus (ms)", "speed_mm_s": "speed (mm/s)", "arena.robots": "robots", "right_pct": "right (%)", "s": "s"}.items():
            self.assertEqual(figure_style.label_of(name), label)

    def test_tables(self):
        """A data frame has what `arkmesh export --csv` writes, and an xarray the same with names and units."""
        called(ARKMESH, "export", "run", "--csv", cwd=self.folder)
        told = json.loads(self.script("""
            run = arkmesh.open_run("run")
            rows = arkmesh.recorded.read_table(run.folder / "export/csv/b/poses.robots.csv")
            table = run.labs["b"].to_dataframe()
            assert len(table) == len(rows) == 51 * 12
            for mine, its in (("robot", "robot"), ("x_m", "x_m"), ("y_m", "y_m"), ("heading_rad", "heading_rad"), ("led", "led")):
                assert np.allclose(table[mine], rows[its], rtol=0, atol=1e-9), mine
            data = run.labs["b"].to_xarray()
            assert float(data.x.sel(time=5.0, robot=3)) == run.labs["b"].xy[-1, 3, 0]
            print(json.dumps([data.x.attrs, list(data.dims), list(arkmesh.open_run("swept").to_dataframe()["seed"])]))"""))
        self.assertEqual(told, [{"units": "m"}, ["time", "robot"], [3, 5, 3, 5]])

    def test_a_sweep_is_its_runs(self):
        """A setting and a seed give the run that they give alone; settings of the scenario need no path."""
        told = json.loads(self.script(f"""
            swept = arkmesh.open_run("swept")
            alone = arkmesh.run("{LIGHT_UP}/light_up.py", *LABS, seconds=5, seed=5, settings={{"scenario.light_up.reach_m": 0.2, "a:arena.robots": 9}})
            print(json.dumps([list(swept.runs), swept.runs[0.2, 5].hash == alone.hash, swept.runs[0.05, 5].hash == alone.hash, int(swept["lit_periods@b"].min()) > 0]))"""))
        self.assertEqual(told, [[[0.05, 3], [0.05, 5], [0.2, 3], [0.2, 5]], True, False, True])

    def test_check_says_what_is_wrong(self):
        """A sound scenario has no fault; chance of its own, a robot that a small lab does not have, and results that nobody counts are told."""
        told = json.loads(self.script(f"""
            import random
            class Chance(arkmesh.Scenario):
                def period(self, lab):
                    lab.count("x", random.SystemRandom().randrange(1000))
            class Third(arkmesh.Scenario):
                def frame(self, lab):
                    lab.xy[2]
                def period(self, lab):
                    lab.count("x")
            class Nothing(arkmesh.Scenario):
                pass
            print(json.dumps([arkmesh.check(each) for each in ("{LIGHT_UP}/light_up.py", Chance, Third, Nothing)]))"""))
        self.assertEqual(told[0], [])
        self.assertIn("two runs with the same seed differ", told[1][0])
        self.assertIn("IndexError", told[2][0])
        self.assertIn("it counts nothing", told[3][0])

    def test_a_loop_draws_lines(self):
        """What a lab can draw, it can draw as a loop, too."""
        self.script("""
            with arkmesh.lab(LABS[0], seconds=2, settings={"shared.labs": ["a"]}) as lab:
                for frame in lab:
                    lab.line([[0, 0], [0.1, 0.1]])
            """)

    def test_types(self):
        """mypy finds nothing in the package nor in the scenario that `arkmesh scenario new` copies."""
        done = called("/usr/bin/mypy", "--cache-dir", self.folder / "mypy", ROOT / "scenarios/python/arkmesh", LIGHT_UP / "light_up.py", LIGHT_UP / "light_up_test.py")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertTrue((ROOT / "scenarios/python/arkmesh/py.typed").is_file())
        (self.folder / "wrong.py").write_text("import arkmesh\n\n\nclass Mine(arkmesh.Scenario):\n    def frame(self, lab: arkmesh.Lab) -> None:\n        lab.tel([1])\n")
        wrong = called("env", f"MYPYPATH={ROOT / 'scenarios/python'}", "/usr/bin/mypy", "--cache-dir", self.folder / "mypy", self.folder / "wrong.py")
        self.assertIn('"Lab" has no attribute "tel"', wrong.stdout)


if __name__ == "__main__":
    unittest.main()
