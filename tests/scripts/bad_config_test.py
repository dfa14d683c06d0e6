"""Spoiled configurations: each is refused in one sentence, in a second, and leaves nothing behind."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
from lab_processes import PROGRAM, ROOT

IN_USE = ("common.toml", "shark.toml", "presets/paper.toml")
KEY = re.compile(r"^(\s*)([\w.-]+)(\s*=\s*)([^#\n]+?)(\s*(?:#.*)?)$")


def spoil_line(line):
    """A line `key = value` spoiled in all ways: another kind of value, no number, too much, twice, misspelt, cut."""
    indent, key, equals, value, rest = KEY.match(line).groups()
    for bad in ("{ x = 1 }", "nan", "1e300" if value[0] not in "\"[" else "-1", "[[1], 2", '"open'):
        yield f"{indent}{key}{equals}{bad}{rest}"
    yield f"{line}\n{line}"
    if key not in ("lynx", "roark", "shark"):  # names are the user's
        yield f"{indent}{key}_{equals}{value}{rest}"


def spoiled_files(folder):
    """Name of what is wrong, and the function that does it to a copy of the shipped experiment."""
    for name in IN_USE:
        lines = (folder / name).read_text().splitlines()
        for at, line in enumerate(lines):
            if not KEY.match(line):
                continue
            for bad in spoil_line(line):
                yield f"{name}:{at + 1}: {bad}", name, "\n".join([*lines[:at], bad, *lines[at + 1:]]).encode()
    whole = (folder / "shark.toml").read_bytes()
    yield "not UTF-8", "shark.toml", whole + b"# \xff\xfe\n[\xe9]\n"
    yield "NUL bytes", "shark.toml", b"\0" * 4096 + whole
    yield "10 MB", "shark.toml", whole + b"# more\n" * 1_500_000
    yield "empty", "shark.toml", b""
    yield "a table twice", "shark.toml", whole + b"[lab]\nname = \"shark\"\n"
    yield "deep nesting", "shark.toml", b"x = " + b"[" * 100_000 + b"]" * 100_000
    yield "many dots", "shark.toml", b"a" + b".a" * 10_000 + b" = 1"
    yield "includes itself", "common.toml", b'include = ["shark.toml"]\n'
    yield "a missing include", "common.toml", b'include = ["nothing.toml"]\n'
    yield "includes a folder", "common.toml", b'include = ["."]\n'
    yield "includes a device", "common.toml", b'include = ["/dev/zero"]\n'
    yield "no preset", "shark.toml", whole.replace(b'"paper"', b'"papers"')
    yield "a controller that is not there", "shark.toml", whole.replace(b"dhtf.c", b"none.c")


class BadConfig(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = pathlib.Path(scratch.name)
        self.folder = self.scratch / "dhtf"
        shutil.copytree(ROOT / "experiments/dhtf", self.folder)
        for name in IN_USE:
            file = self.folder / name
            file.write_text(file.read_text().replace("../../scenarios", str(ROOT / "scenarios")))

    def refusal(self):
        """What the program says to the file; it does not wait for anything, and leaves the folder as it was."""
        ran = subprocess.run([PROGRAM, "lab", "dhtf/shark.toml"], cwd=self.scratch, capture_output=True, timeout=600,
                             env=os.environ | {"PATH": "/usr/bin:/bin"})
        self.assertEqual(ran.stdout, b"")
        said = ran.stderr.decode()
        self.assertEqual(ran.returncode, 2, said)
        self.assertEqual(said.count("\n"), 1, said)
        self.assertFalse((self.scratch / "runs").exists(), said)
        return said

    def test_every_spoiled_file_is_refused(self):
        spoiled = list(spoiled_files(self.folder))
        self.assertGreater(len(spoiled), 100)
        for what, name, text in spoiled:
            with self.subTest(what):
                whole = (self.folder / name).read_bytes()
                (self.folder / name).write_bytes(text)
                try:
                    said = self.refusal()
                finally:
                    (self.folder / name).write_bytes(whole)
                self.assertRegex(said, r"^arkmesh: (/\S*/)?dhtf/\S+\.toml\b", what)


if __name__ == "__main__":
    unittest.main()
