"""scripts/behaviour compare: on records made by hand; the program is not run."""
import pathlib
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/behaviour"
HELP = "$ arkmesh room --help\nexit code 0\n--- stdout\n  room          A virtual room\n--- stderr\n"
KEYS = "out/hash.csv digest = 1a9e1c8dedc6360c\nout/result.json.seed = 1\nout/result.json.table.lost = 3\n"


class Behaviour(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.record("a")

    def record(self, name, texts=(), short=False):
        """A record as `scripts/behaviour record` leaves it, with some texts changed; without those that are None."""
        about = f"short = {'yes' if short else 'no'}\n"
        for file, text in ({"about.txt": about, "commands/help-room.txt": HELP, "labs/one.keys": KEYS} | dict(texts)).items():
            if text is not None:
                (self.folder / name / file).parent.mkdir(parents=True, exist_ok=True)
                (self.folder / name / file).write_text(text)

    def compare(self, a="a", b="b", *options):
        done = subprocess.run([SCRIPT, "compare", self.folder / a, self.folder / b, *options], capture_output=True, text=True, timeout=60)
        return done.returncode, done.stdout + done.stderr

    def test_equal_records(self):
        self.record("b")
        self.assertEqual(self.compare(), (0, "2 texts are equal\n"))

    def test_a_difference_is_shown_where_it_is(self):
        """Only the lines that differ, under the name of their text."""
        self.record("b", {"labs/one.keys": KEYS.replace("= 3", "= 4")})
        code, said = self.compare()
        self.assertEqual(code, 1)
        self.assertEqual(said, "labs/one.keys differs\n  -out/result.json.table.lost = 3\n  +out/result.json.table.lost = 4\n"
                               "1 of 2 texts differ\n")

    def test_missing_text_is_a_difference(self):
        """Except what a short record leaves out of a full one."""
        self.record("b", {"labs/one.keys": None})
        self.assertEqual(self.compare()[0], 1)
        self.record("short", {"labs/one.keys": None}, short=True)
        self.assertEqual(self.compare("a", "short"), (0, "1 texts are equal\n"))
        self.assertEqual(self.compare("short", "a"), (0, "1 texts are equal\n"))
        self.record("other", {"labs/two.keys": KEYS}, short=True)
        self.assertEqual(self.compare("a", "other")[0], 1)

    def test_renamed_names(self):
        """What was renamed on purpose differs no more, wherever its column or its key now stands; everything else still does."""
        renamed = {"commands/help-room.txt": HELP.replace("arkmesh room", "arkmesh emulator").replace("  room     ", "  emulator "),
                   "labs/one.keys": "out/hash.csv digest = 1a9e1c8dedc6360c\nout/result.json.arena.lost = 3\nout/result.json.seed = 1\n"}
        self.record("b", renamed)
        self.record("worse", renamed | {"labs/one.keys": renamed["labs/one.keys"].replace("= 3", "= 4")})
        names = self.folder / "names.txt"
        names.write_text("# commands\narkmesh room -> arkmesh emulator\nroom A virtual -> emulator A virtual\n\ntable.lost -> arena.lost\n")
        self.assertEqual(self.compare()[0], 1)
        self.assertEqual(self.compare("a", "b", "--names", names), (0, "2 texts are equal\n"))
        code, said = self.compare("a", "worse", "--names", names)
        self.assertEqual((code, said.count("differs\n"), "+out/result.json.arena.lost = 4" in said), (1, 1, True))

    def test_what_is_no_record(self):
        """A record that was not finished, and a list of names that cannot be read, are refused in one sentence."""
        self.record("b", {"about.txt": None})
        code, said = self.compare()
        self.assertEqual((code, said.count("\n"), "no finished record" in said), (2, 1, True))
        (self.folder / "names.txt").write_text("room = emulator\n")
        code, said = self.compare("a", "a", "--names", self.folder / "names.txt")
        self.assertEqual((code, "names.txt:1: must be of the form" in said), (2, True))


if __name__ == "__main__":
    unittest.main()
