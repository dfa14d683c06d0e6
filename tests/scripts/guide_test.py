"""`arkmesh guide` names commands for what lies in a folder, and they do what it says."""
import pathlib
import re
import shlex
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
ARKMESH = ROOT / "build/release/arkmesh"


class Guide(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def run_it(self, *words, code=0):
        done = subprocess.run([ARKMESH, *words], cwd=self.folder, capture_output=True, text=True, timeout=600)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def commands(self):
        """Those that it names for the folder, not for what runs on this machine."""
        said = re.sub(r"Running on this machine:\n(  .*\n)*\n", "", self.run_it("guide"))
        return re.findall(r"^  arkmesh (.*?)(?:  .*)?$", said, re.M)

    def test_an_empty_folder_begins_with_a_scenario(self):
        self.assertIn("scenario new my_swarm", self.commands())
        course = re.search(r"a first result of your own: (.*)", self.run_it("guide"))[1]
        self.assertIn("# Your own scenario in Python", pathlib.Path(course).read_text())
        self.run_it("scenario", "new", "my_swarm")
        self.folder /= "my_swarm"
        self.assertIn("run a.toml b.toml", self.commands())
        self.assertIn("controller check my_swarm.c", self.commands())

    def test_what_lies_there_and_what_it_names_works(self):
        """Labs that take part in one world are run together; a run is drawn, exported and repeated; files that are broken are said to be."""
        for name in "ab":
            (self.folder / f"{name}.toml").write_text(f'[lab]\nname = "{name}"\n[run]\nscenario = "light_up"\nduration_s = 10\n[shared]\nlabs = ["a", "b"]\n[arena]\nuse = "null"\n')
        (self.folder / "alone with a blank.toml").write_text('[lab]\nname = "c"\n[run]\nscenario = "light_up"\nduration_s = 10\n[arena]\nuse = "null"\n')
        (self.folder / "broken.toml").write_text("[lab]\nname = ")
        (self.folder / "all.toml").write_text('labs = ["a.toml", "b.toml"]\nseeds = "1..2"\n')
        (self.folder / "robot.c").write_text("#include <kilolib.h>\nint main(void) { kilo_init(); kilo_start(0, 0); }\n")
        (self.folder / "large.c").write_bytes(b"kilo_start\n" * 200_000)
        (self.folder / "none.py").symlink_to("missing")
        commands = self.commands()
        for wanted in ("run a.toml b.toml", "run 'alone with a blank.toml'", "batch all.toml", "controller run robot.c --open"):
            self.assertIn(wanted, commands)
        self.assertIn("cannot be read: broken.toml:2", self.run_it("guide"))
        self.assertNotIn("large.c", " ".join(commands))
        self.run_it(*shlex.split("run a.toml b.toml"))
        self.run_it(*shlex.split("batch all.toml"), "--out", "grid")
        self.assertIn("column -s, -t grid/summary.csv", self.run_it("guide"))
        self.assertTrue((self.folder / "grid/summary.csv").exists())
        named = [command for command in self.commands() if command.split()[0] in ("plot", "export", "rerun")]
        self.assertEqual(len(named), 3)
        for command in named:
            self.run_it(*shlex.split(command))

    def test_only_a_lab_with_peers_is_to_be_joined(self):
        """`up` is named for the first file that has peers, however they are written, and for none when no file has any."""
        alone = '[lab]\nname = "{}"\n[run]\nscenario = "light_up"\n[arena]\nuse = "null"\n'
        (self.folder / "a.toml").write_text(alone.format("a"))
        (self.folder / "b.toml").write_text(alone.format("b") + "[gateway]\npeers = []\n")
        ups = lambda: [command for command in self.commands() if command.startswith("up")]
        self.assertEqual(ups(), [])
        (self.folder / "c.toml").write_text(alone.format("c") + '[gateway]\npeers = [{lab = "a", connect = "127.0.0.1:7999"}]\n')
        self.assertEqual(ups(), ["up c.toml"])
        (self.folder / "b.toml").write_text(alone.format("b") + '[[gateway.peers]]\nlab = "a"\n')
        self.assertEqual(ups(), ["up b.toml"])

    def test_no_folder_is_one_sentence(self):
        self.assertEqual(self.run_it("guide", "nowhere", code=2), "arkmesh: nowhere: is not a folder\n")


if __name__ == "__main__":
    unittest.main()
