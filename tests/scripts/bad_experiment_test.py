"""Spoiled experiment files: each is refused in one sentence that names a file, or runs; and leaves nothing behind when it is refused."""
import pathlib
import subprocess
import tempfile
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
from lab_processes import PROGRAM, ROOT

WHOLE = f"""labs  = ["{ROOT}/experiments/dhtf/shark.toml"]
seeds = "1..2"
[set]
run.duration_s = 4
arena.use = "null"
[sweep]
gate.period_s = [1, 2]
[choices.mix."all easy"]
scenario.dhtf.types = "easy"
[[plot]]
column = "completed"
over = "mix"
""".splitlines()
VALUES = ("{ x = 1 }", "nan", "1e300", "[[1], 2", '"open', "-1", "[]", "true", '[1, "a"]', "[{a=1}]", "1979-05-27", '"1..1e18"', "[nan, 1]", "inf")
HEADERS = ("[", "[x", "[[set]]", "[a.b.c.d]", "[labs]", "[plot]", "[sweep.x.y]", "[choices]", "[choices.x]")


def spoiled_lines(line):
    if "=" not in line:
        yield from HEADERS
        return
    key = line.split("=")[0]
    yield from (f"{key}= {value}" for value in VALUES)
    yield from (f"{line}\n{line}", f"x{line}", '"a:b:c" = 1', '"" = 1', '"=" = 1', '"a b" = [1]')


class BadExperiment(unittest.TestCase):
    def test_every_spoiled_file_is_refused_or_runs(self):
        """A file spoiled in any of its lines; column names of plots, which only runs can tell, are left alone."""
        with tempfile.TemporaryDirectory() as scratch:
            file, out = pathlib.Path(scratch) / "batch.toml", pathlib.Path(scratch) / "out"
            refused = 0
            for at, line in enumerate(WHOLE):
                for bad in spoiled_lines(line) if not line.startswith("column") else ():
                    file.write_text("\n".join([*WHOLE[:at], bad, *WHOLE[at + 1:]]) + "\n")
                    with self.subTest(f"{at + 1}: {bad}"):
                        done = subprocess.run([PROGRAM, "batch", file, "--out", out], capture_output=True, text=True, timeout=600)
                        self.assertIn(done.returncode, (0, 2), done.stderr)
                        if done.returncode == 2:
                            refused += 1
                            self.assertRegex(done.stderr, r"\Aarkmesh: [^\n]*\.toml[^\n]*\n\Z")
                            self.assertFalse(out.exists())
                    subprocess.run(["rm", "-rf", out], check=True)
            self.assertGreater(refused, 100)


if __name__ == "__main__":
    unittest.main()
