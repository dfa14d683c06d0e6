"""What a user would not notice is said or refused: absent labs, misspelt methods, fields that labs declare otherwise, what the seed does not decide, runs of
other settings in one figure, and wrong words on the command line."""
import importlib.util
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scenarios/python"))
import arkmesh  # noqa: E402  # pylint: disable=wrong-import-position
ARKMESH = ROOT / "build/release/arkmesh"
ENVIRONMENT = {**os.environ, "ARKMESH_PYTHON": "/usr/bin/python3"}
LAB = ("[lab]\nname = '{}'\n[run]\nscenario = 'mine.py'\nduration_s = {}\n[gate]\nperiod_s = 1\n[shared]\nlabs = ['a', 'b']\n"
       "[arena]\nuse = 'null'\nrobots = 2\n")
HEAD = "import arkmesh, numpy, random, time\nclass Mine(arkmesh.Scenario):\n"


class Chance(arkmesh.Scenario):
    """As test_what_the_seed_decides() writes it to a file."""

    def begin(self, lab):
        self.r = random.random()

    def period(self, lab):
        lab.row("t", a=random.random(), b=numpy.random.rand(), c=self.r)


class Said(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        for lab in "ab":
            (self.folder / f"{lab}.toml").write_text(LAB.format(lab, 2))
        self.mine("  pass\n")

    def mine(self, text):
        (self.folder / "mine.py").write_text(HEAD + text)

    def command(self, *words, cwd=None):
        done = subprocess.run([ARKMESH, *words], capture_output=True, text=True, timeout=120, env=ENVIRONMENT, cwd=cwd or self.folder)
        return done.returncode, done.stdout + done.stderr

    def result(self, out, lab=""):
        return json.loads((self.folder / out / lab / "result.json").read_text())

    def test_a_lab_of_the_world_that_is_not_there(self):
        """The summary, result.json and recordings say that it takes no part, also of a batch; with all files, or where it is meant, nothing is said."""
        code, said = self.command("run", "a.toml", "--out", "alone")
        self.assertEqual(code, 0, said)
        self.assertIn("  b of shared.labs does not take part\n", said)
        self.assertEqual([self.result("alone")["absent_labs"], self.result("alone", "a")["absent_labs"]], [["b"], ["b"]])
        self.assertIn("b of shared.labs does not take part", self.command("export", "alone", "--csv")[1])
        self.assertIn("b of shared.labs does not take part", self.command("batch", "a.toml", "--seeds", "1", "--out", "batch")[1])
        for words in (("a.toml", "b.toml"), ("a.toml", "--set", "shared.labs=['a']")):
            code, said = self.command("run", *words, "--out", "all", "--force")
            self.assertEqual((code, "does not take part" in said, "absent_labs" in self.result("all")), (0, False, False), said)

    def test_names_that_are_nearly_of_the_interface(self):
        """What is misspelt is refused with its line; what the scenario itself calls, or is called otherwise, is not."""
        for body, wanted in (("def frames(self, lab): pass", "mine.py:3: Mine.frames is never used; did you mean frame?"),
                             ("def on_period(self, lab): pass", "did you mean period?"), ("def finnished(self, lab): pass", "did you mean finished?"),
                             ("def setup(self, lab): pass", "did you mean begin?"), ("evry = 3", "Mine.evry is never used; did you mean every?"),
                             ("def frames(self, lab): pass\n  def period(self, lab): self.frames(lab)", None), ("def helper(self): pass", None)):
            with self.subTest(body):
                self.mine("  " + body + "\n")
                code, said = self.command("run", "a.toml", "b.toml", "--out", "out", "--force")
                self.assertEqual(code, 0 if wanted is None else 1, said)
                self.assertIn(wanted or "", said)

    def test_fields_that_labs_declare_otherwise(self):
        """Another length, range or owner, and a field that one lab lacks, end the run at once, by the field's name."""
        for a, b in (("length=1", "length=2"), ("high=5", "high=6"), ("low=-1", "low=0"), ("owner_only=True", ""), ("initial_only=True", ""), ("up_to=True", "")):
            with self.subTest(a):
                self.mine(f"  def begin(self, lab):\n    lab.declare('heap', {a}) if lab.name == 'a' else lab.declare('heap', {b})\n")
                code, said = self.command("run", "a.toml", "b.toml", "--out", "out", "--force")
                self.assertEqual(code, 1, said)
                self.assertIn("the labs' settings differ: field.heap is ", said)
        self.mine("  def begin(self, lab):\n    lab.name == 'a' and lab.declare('heap')\n")
        code, said = self.command("run", "a.toml", "b.toml", "--out", "out", "--force")
        self.assertEqual(code, 1, said)
        self.assertRegex(said, "field.heap is (not set in b|.* in a and not set in b)")
        self.mine("  def begin(self, lab):\n    [lab.declare(name) for name in (('p', 'q') if lab.name == 'a' else ('q', 'p'))]\n")
        code, said = self.command("run", "a.toml", "b.toml", "--out", "out", "--force")
        self.assertEqual(code, 0, said)

    def test_what_the_seed_decides(self):
        """random and numpy's global generator repeat with the seed, in a child and in this process; what cannot be seeded is told once, with its line."""
        body = ("  def begin(self, lab): self.r = random.random()\n  def period(self, lab):\n"
                "    lab.row('t', a=random.random(), b=numpy.random.rand(), c=self.r)\n")
        self.mine(body)
        tables = []
        for n, seed in enumerate((1, 1, 2)):
            code, said = self.command("run", "a.toml", "b.toml", "--seed", str(seed), "--out", f"s{n}")
            self.assertEqual((code, "may differ" in said), (0, False), said)
            tables.append([(self.folder / f"s{n}/{lab}/t.csv").read_text() for lab in "ab"])
        self.assertEqual(tables[0], tables[1])
        self.assertEqual(len({*tables[0], *tables[2]}), 4)
        random.seed(5)
        here = arkmesh.run(Chance, self.folder / "a.toml", self.folder / "b.toml", seed=1, out=self.folder / "here")
        self.assertEqual([(here.folder / lab / "t.csv").read_text() for lab in "ab"], tables[0])
        drawn, _ = random.random(), random.seed(5)
        self.assertEqual(drawn, random.random(), "the caller's generator is as it was")
        self.mine("  def period(self, lab):\n    self.t = time.time()\n    self.c = numpy.random.default_rng()\n    lab.random('x').random()\n")
        code, said = self.command("run", "a.toml", "b.toml", "--out", "clock")
        self.assertEqual((code, said.count("mine.py:4: time.time may differ between runs of one seed"), said.count("default_rng()")), (0, 1, 1), said)
        self.assertEqual(len(self.result("clock", "b")["scenario_in_python"]["unseeded"]), 2)

    def test_runs_of_other_settings_are_told_apart(self):
        """In the legend, by what differs; of equal settings they are put together whatever the seed; pooled factors stand in the figure, and labs that
        differ in one table are drawn apart."""
        self.mine("  def period(self, lab): lab.row('t', time_s=lab.now_s, x=len(lab.name) + (lab.name == 'b'))\n")
        for out, words in (("one", ()), ("two", ("--seed", "2")), ("three", ("--set", "arena.robots=3")), ("long", ("--seconds", "4"))):
            self.assertEqual(self.command("run", "a.toml", "b.toml", "--out", out, *words)[0], 0)

        def title(*words):
            code, said = self.command("plot", *words, "--out", "p.svg")
            self.assertEqual(code, 0, said)
            return (self.folder / "p.svg").read_text()
        alike = title("one", "two")
        for words in ("<!-- mean of 2 runs -->", "<!-- t x, lab a -->", "mean, no interval"):
            self.assertIn(words, alike)
        apart = title("one", "two", "three")
        for words in ("<!-- robots 2, mean of 2 runs -->", "<!-- robots 3, 1 run -->"):
            self.assertIn(words, apart)
        self.assertIn("<!-- run duration 4.0 s, 1 run -->", title("one", "long"))
        shutil.copytree(self.folder / "one", self.folder / "copy")
        for lab in "ab":
            config = self.folder / f"copy/{lab}/config.toml"
            config.write_text(config.read_text() + "".join(f"[extra{k}]\nx = 1\n" for k in range(6)))
        code, said = self.command("plot", "one", "copy")
        self.assertEqual((code, "these runs differ in 6 settings" in said), (1, True), said)
        (self.folder / "study.toml").write_text("labs = ['a.toml', 'b.toml']\nseeds = '1..4'\n[sweep]\narena.robots = [1, 2]\narena.width_m = [1.0, 2.0]\n")
        self.assertEqual(self.command("batch", "study.toml", "--out", "study")[0], 0)
        pooled = title("study", "--by", "arena.robots")
        for words in ("pooled over width", "mean, 95 % interval: Student's t"):
            self.assertIn(words, pooled)
        self.assertNotIn("pooled", title("study"))

    def test_wrong_words(self):
        """One sentence that says what was meant, or what is wrong; nothing in it that a terminal would obey."""
        (self.folder / "x.c").write_text("int main() {}\n")
        (self.folder / "study.toml").write_text("labs = ['a.toml']\nseeds = '1..2'\n")
        for words, wanted in ((("rnu",), "did you mean run?"), (("run", "a.toml", "--set", "run.scenario=dhft"), "did you mean dhtf?"),
                              (("run", "x.c"), "x.c: is not a configuration"), (("lab", "study.toml"), "is an experiment; run it with arkmesh batch"),
                              (("batch", "a.toml", "--seeds", "1.." + "9" * 309), "of 64-bit numbers"),
                              (("lab", "a.toml", "--set", "bus.url=memq://"), "must be udpm://"),
                              (("run", "a.toml", "--set", "\x1b[31mred=1"), "?[31mred"),
                              (("controller", "run", ROOT / "experiments/light_up/light_up.c", "--robots", "200", "--spacing", "0.3"), "--spacing 0.3: puts robot 0")):
            code, said = self.command(*words)
            self.assertEqual((code, said.count("\n")), (2, 1), said)
            self.assertIn(wanted, said)
            self.assertLess(len(said), 400)
        (self.folder / "gone").mkdir()
        done = subprocess.run(f"cd {self.folder}/gone && rmdir ../gone && {ARKMESH} run ../a.toml", shell=True, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.stderr, "arkmesh: the current folder was deleted; go to another one, and try again\n")
        for body, wanted in (("lab.circle((0, 0), 1, colour='purple')", "mine.py:4: ValueError: colour 'purple' is not one of note"),
                             ("raise ValueError('\\x1b[31mred\\x07')", "mine.py:4: ValueError: ?[31mred?")):
            self.mine(f"  def period(self, lab):\n    {body}\n")
            code, said = self.command("run", "a.toml", "b.toml", "--out", "out", "--force")
            self.assertEqual((code, "\x1b[31m" in said), (1, False), said)
            self.assertIn(wanted, said)

    def test_what_python_is_given(self):
        """Paths as pathlib has them are settings; a class that importlib loaded is taken; an object in place of its class is refused in words."""
        class Mine(arkmesh.Scenario):
            def begin(self, lab):
                lab.count("length", len(lab.setting("file", "")))
        run = arkmesh.run(Mine, *(self.folder / f"{lab}.toml" for lab in "ab"), out=self.folder / "path",
                          settings={f"scenario.{arkmesh.answering.name_of_class(Mine)}.file": pathlib.Path("/a/b")})
        self.assertEqual(run.counts["length"], 8)
        (self.folder / "loaded.py").write_text(HEAD + "  def period(self, lab): lab.count('n')\n")
        spec = importlib.util.spec_from_file_location("loaded", self.folder / "loaded.py")
        module = importlib.util.module_from_spec(spec)  # has no place in sys.modules
        spec.loader.exec_module(module)
        run = arkmesh.run(module.Mine, self.folder / "a.toml", out=self.folder / "loaded")
        self.assertTrue((run.labs["a"].folder / "scenario/loaded.py").is_file(), list(run.folder.rglob("*")))
        for wrong, wanted in ((Mine(), "give the class, as arkmesh.run(Mine, ...)"), (3, "a scenario is a class derived from arkmesh.Scenario, or a file, and no int")):
            with self.assertRaises(TypeError) as raised:
                arkmesh.run(wrong, self.folder / "a.toml")
            self.assertIn(wanted, str(raised.exception))


if __name__ == "__main__":
    unittest.main()
