"""What is told by name ends under its name: tables, counts, settings and seeds, in any order, from any lab, and what cannot be is refused."""
import csv
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scenarios/python"))
import arkmesh  # noqa: E402  # pylint: disable=wrong-import-position
ARKMESH = ROOT / "build/release/arkmesh"
ENVIRONMENT = {**os.environ, "ARKMESH_PYTHON": "/usr/bin/python3"}
# Does what plan.json says: by lab, a list of rows and counts.
MINE = """import arkmesh, json, pathlib
PLAN = json.loads((pathlib.Path(__file__).parent / "plan.json").read_text())
class Mine(arkmesh.Scenario):
    def begin(self, lab):
        self.left = PLAN[lab.name]
        self.do(lab, len(self.left) // 3)
    def period(self, lab):
        self.do(lab, len(self.left) if lab.now_s == 2 else 1)
    def do(self, lab, n):
        for what, name, value in self.left[:n]:
            lab.row(name, **dict(value)) if what == "row" else lab.count(name, value)
        self.left = self.left[n:]
"""


class ToldByName(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def labs(self, *names):
        files = [self.folder / f"{name}.toml" for name in names]
        for name, file in zip(names, files):
            file.write_text(f"[lab]\nname = '{name}'\n[run]\nscenario = 'mine.py'\nduration_s = 2\n[gate]\nperiod_s = 1\n"
                            f"[shared]\nlabs = {list(names)}\n[arena]\nuse = 'null'\nrobots = 2\n")
        return files

    def command(self, *words):
        done = subprocess.run([ARKMESH, *words], capture_output=True, text=True, timeout=120, env=ENVIRONMENT, cwd=self.folder)
        return done.returncode, done.stdout + done.stderr

    def test_a_field_that_returns_to_a_former_value(self):
        """What a lab publishes again and again, or as it was before, is in force in all labs as published last."""
        (self.folder / "mine.py").write_text("""import arkmesh
VALUES = [1, 2, 2, 1, 1, 3, 1]
class Mine(arkmesh.Scenario):
    def begin(self, lab):
        lab.declare("x", length=1, low=0, high=9)
        lab.declare("two", length=2, low=0, high=9)
        lab.publish("x", [9])
    def period(self, lab):
        value = VALUES[lab.periods % len(VALUES)]
        for each in (value, 8, value):
            lab.publish("x", [each])
        lab.publish("two", [value, value])
        for name in lab.labs:
            lab.row(name, x=lab.field(name, "x")[0], two=lab.field(name, "two")[-1:].sum())
""")
        labs = self.labs("a", "b")
        for file in labs:
            file.write_text(file.read_text().replace("duration_s = 2", "duration_s = 9"))
        self.assertEqual(self.command("run", *labs, "--out", "out")[0], 0)
        for lab in ("a", "b"):
            for of in ("a", "b"):
                self.assertEqual((self.folder / f"out/{lab}/{of}.csv").read_text().split(), ["x,two", "9,0", *(f"{v},{v}" for v in (1, 2, 2, 1, 1, 3, 1, 1, 2))])

    def test_random_tables_and_counts(self):
        """Whatever the order of names, rows and labs: each value stands under its name, totals are the labs' sums, and a batch has the same columns."""
        for trial in range(6):
            chance = random.Random(trial)
            labs = chance.sample(["a", "b", "zeta", "lab2", "x_1"], chance.randint(1, 3))
            words = ["x", "y", "a", "t", "time_s", "table", "self", "lit", "lit1", "B", "run", "values"]
            plan, rows, counts = {lab: [] for lab in labs}, {}, {}
            tables = {lab: {table: chance.sample(words, chance.randint(1, 6)) for table in chance.sample(["t", "u", "lit", "x9"], 3)} for lab in labs}
            for lab in labs:
                for _ in range(chance.randint(3, 30)):
                    table = chance.choice(list(tables[lab]))
                    names = chance.sample(tables[lab][table], len(tables[lab][table]))
                    row = [(name, chance.choice([chance.randint(-9, 9), chance.random(), "word"])) for name in names]
                    plan[lab].append(("row", table, row))
                    rows.setdefault((lab, table), []).append({name: str(value) for name, value in row})
                for _ in range(chance.randint(0, 9)):
                    name, n = chance.choice(["lit", "lit1", "lit.s", "stood still", "x"]), chance.randint(0, 99)
                    plan[lab].append(("count", name, n))
                    counts[name] = counts.get(name, 0) + n
                    if len(labs) > 1:
                        counts[f"{name}@{lab}"] = counts.get(f"{name}@{lab}", 0) + n
            (self.folder / "plan.json").write_text(json.dumps(plan))
            (self.folder / "mine.py").write_text(MINE)
            files = self.labs(*labs)
            run = arkmesh.run(*files, out=self.folder / f"run{trial}")
            for (lab, table), wanted in rows.items():
                with open(run.folder / lab / f"{table}.csv", newline="") as file:
                    self.assertEqual(list(csv.DictReader(file)), wanted, (trial, lab, table))
            self.assertEqual(dict(run.counts), counts, trial)
            batch = arkmesh.batch(None, *files, seeds=[3], out=self.folder / f"batch{trial}")
            with open(batch.folder / "runs.csv", newline="") as file:
                row = list(csv.DictReader(file))[0]
            self.assertEqual({name: int(row[name]) for name in counts}, counts, trial)

    def test_rows_and_counts_that_are_refused(self):
        """Names that are missing, new or given twice, names of the lab's own tables and of columns that a batch has: the user's line is named."""
        first = "lab.row('t', x=1, y=2); "
        for line, wanted in ((first + "lab.row('t', x=1)", "its columns are x, y, and this row is without y"),
                             (first + "lab.row('t', x=1, y=2, z=3)", "and this row is with z"),
                             (first + "lab.row('t', y=1, z=3)", "and this row is without x and with z"),
                             (first + "lab.row('t', x=1, **{'x': 2, 'y': 3})", "multiple values for keyword argument 'x'"),
                             (first + "lab.row('t')", "a row has a column at least"), ("lab.row('t')", "a row has a column at least"),
                             ("lab.row('t', **{'a,b': 1})", "must not contain commas"), ("lab.row('t', **{'': 1})", "a name must not be empty"),
                             ("lab.row('hash', x=1)", "and is not hash or audit or curves"), (f"lab.row('{'t' * 300}', x=1)", "at most 64"),
                             ("lab.count('seed')", "not one of run, setting"), ("lab.count('lit@a')", "without @"), ("lab.count('')", "a name must be one line"),
                             ("lab.setting('v', 3, low=5)", "setting 'v': the default 3 is not within low=5"),
                             ("lab.setting('v', 9.5, high=5)", "the default 9.5 is not within"),
                             ("lab.setting('v', 'c', one_of=['a', 'b'])", "the default 'c' is not one of a, b"),
                             ("lab.setting('v', 3); lab.setting('v', 4)", "setting 'v' is requested twice")):
            with self.subTest(line):
                (self.folder / "mine.py").write_text(f"import arkmesh\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab):\n    {line}\n")
                code, said = self.command("run", *self.labs("a"), "--out", "out", "--force")
                self.assertEqual(code, 1, said)
                self.assertIn("mine.py:4: ", said)
                self.assertIn(wanted, said)

    def test_columns_of_a_batch_are_checked_after_its_first_run(self):
        """A plot of a column that no run has, and a factor that is called as a count is, end the batch early; what another lab counts is a column."""
        (self.folder / "mine.py").write_text("import arkmesh\nclass Mine(arkmesh.Scenario):\n  def period(self, lab):\n"
                                             "    if not lab.is_owner: lab.count('lit', 2)\n")
        self.labs("a", "b")
        begin = "labs = ['a.toml', 'b.toml']\nseeds = '1..20'\n"
        for n, (more, wanted) in enumerate((("[sweep]\narena.robots = [2, 3]\n[[plot]]\ncolumn = 'lid'\nover = 'arena.robots'\n", "did you mean lit?"),
                                            ("[choices.lit.one]\narena.robots = 2\n[[plot]]\ncolumn = 'lit'\nover = 'lit'\n", "lit is the name of both a count and a factor"))):
            (self.folder / "study.toml").write_text(begin + more)
            code, said = self.command("batch", "study.toml", "--jobs", "1", "--out", f"batch{n}")
            self.assertEqual(code, 2, said)
            self.assertIn(wanted, said)
            self.assertLessEqual(len(list((self.folder / f"batch{n}/runs").iterdir())), 2, "it ended after the first run")
        (self.folder / "study.toml").write_text(begin.replace("1..20", "1..2") + "[sweep]\narena.robots = [2, 3]\n"
                                                "[[plot]]\ncolumn = 'lit@b'\nover = 'arena.robots'\n[[plot]]\nover = 'arena.robots'\ncolumn = 'lit'\n")
        code, said = self.command("batch", "study.toml", "--out", "good")
        self.assertEqual(code, 0, said)
        for name in ("lit_b-over-arena.robots.png", "lit-over-arena.robots.png"):
            self.assertTrue((self.folder / "good" / name).is_file(), said)
        code, said = self.command("run", "a.toml", "b.toml", "--out", "out")
        self.assertIn("  lit 6 (b 6)\n", said)

    def test_seeds_are_themselves_or_refused(self):
        """From 0 to 2^63-1 each seed is another run, however it is told; beyond, and as what is no plain number, it is refused. Nor is NaN a time."""
        (self.folder / "mine.py").write_text("import arkmesh\nclass Mine(arkmesh.Scenario):\n  def begin(self, lab): lab.row('t', x=lab.random('x').random())\n")
        lab, = self.labs("a")
        most, chance, seen = 2**63 - 1, random.Random(5), set()
        seeds = [0, 1, 2**31, 2**32, 2**32 + 1, 2**53, 2**53 + 1, most - 1, most, *(chance.randrange(most) for _ in range(4))]
        for n, seed in enumerate(seeds):
            way = [("--seed", str(seed)), ("--set", f"run.seed={seed}")][n % 2]
            code, said = self.command("run", lab, *way, "--out", f"s{n}")
            self.assertEqual(code, 0, said)
            self.assertEqual(json.loads((self.folder / f"s{n}/result.json").read_text())["seed"], seed)
            self.assertIn(f"seed {seed}:", said)
            seen.add((self.folder / f"s{n}/a/t.csv").read_text())
        self.assertEqual(len(seen), len(seeds))
        for word in (2**63, 2**63 + 1, 2**64, 2**70, "1e3", "1.0", "0x10", "010", "-1", "nan", "inf", "+1", " 1"):
            code, said = self.command("run", lab, f"--seed={word}", "--out", "bad")
            self.assertEqual((code, said.count("\n")), (2, 1), (word, said))
            with self.assertRaises(arkmesh.Failed):
                arkmesh.run(lab, seed=word, out=self.folder / "bad")
            if word != " 1":
                code, said = self.command("batch", lab, "--seeds", str(word), "--out", "bad")
                self.assertEqual(code, 0 if word == "010" else 2, (word, said))
        for word in (2**63, 2**64, -1, "nan", "1.5"):
            code, said = self.command("run", lab, "--set", f"run.seed={word}", "--out", "bad")
            self.assertEqual(code, 2, (word, said))
        for word in ("nan", "inf", "-nan", "1e400", "0", "-1"):
            code, said = self.command("run", lab, "--seconds", word, "--out", "bad")
            self.assertEqual((code, said.count("\n")), (2, 1), (word, said))
        code, said = self.command("batch", lab, "--seeds", f"{most - 1}..{most}", "--list")
        self.assertIn("2 runs", said)
        with self.assertRaises(TypeError):
            arkmesh.batch(None, lab, seeds=[1.2, 1.7])


if __name__ == "__main__":
    unittest.main()
