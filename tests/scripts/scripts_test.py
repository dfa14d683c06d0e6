"""The scripts that read run folders: on whole folders, and on folders of runs that were killed or whose disk ran full."""
import pathlib
import re
import struct
import subprocess
import tempfile
import unittest

import run_folder
from run_folder import read_log

ROOT = pathlib.Path(__file__).resolve().parents[2]


def script(name, *arguments):
    return subprocess.run([ROOT / ("scripts" if name == "read_log.py" else "drawing") / name, *map(str, arguments)], capture_output=True, text=True, timeout=600)


class Scripts(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.run_dir = pathlib.Path(self.temporary.name) / "run"
        run_folder.make(self.run_dir)
        self.log = self.run_dir / "shark/log.lcm"

    def test_every_cut_log_is_read_up_to_its_last_whole_event(self):
        """A log cut at any byte gives exactly the events that are whole, and nothing else."""
        whole = self.log.read_bytes()
        ends, at = [], 0
        for _, channel, data in read_log.events(self.log):
            at += 28 + len(channel) + len(data)
            ends.append(at)
        self.assertEqual((ends[-1], len(ends)), (len(whole), 11))
        cut = self.run_dir / "cut.lcm"
        for size in list(range(0, ends[2] + 30)) + [len(whole) - 1]:
            cut.write_bytes(whole[:size])
            self.assertEqual(len(list(read_log.events(cut))), sum(end <= size for end in ends), f"cut at {size}")

    def test_compressed_log_is_read_like_the_plain_one(self):
        """Events of log.lcm.zst, whole and cut, by its name in a folder and by its bytes; plot draws it."""
        plain = list(read_log.events(self.log))
        subprocess.run(["zstd", "-q", "--rm", self.log], check=True)
        packed = read_log.log_in(self.log.parent)
        self.assertEqual((packed.name, list(read_log.events(packed))), ("log.lcm.zst", plain))
        self.assertEqual(script("plot", self.run_dir).returncode, 0)
        self.assertRegex(script("read_log.py", packed).stdout, r"shared +5 ")
        whole = packed.read_bytes()
        packed.write_bytes(whole + whole[:len(whole) // 2])
        self.assertEqual(list(read_log.events(packed))[:len(plain)], plain)

    def test_damaged_log_is_read_on_behind_the_damage(self):
        """An event that claims 4 GiB, one that claims others' bytes, a hole and a lost beginning cost no other event, and it is said; what is no log is refused."""
        whole, good = self.log.read_bytes(), list(read_log.events(self.log))
        begins = [0]
        for _, channel, data in good[:-1]:
            begins.append(begins[-1] + 28 + len(channel) + len(data))

        def with_bytes(at, text):
            self.log.write_bytes(whole[:at] + text + whole[at + len(text):])
            return list(read_log.events(self.log))

        for i in (0, 5, 9):
            for text in (b"\xff\xff\xff\xff", struct.pack(">I", len(good[i][2]) + 40)):
                self.assertEqual(with_bytes(begins[i] + 24, text), good[:i] + good[i + 1:])
            self.assertEqual(with_bytes(begins[i], b"four"), good[:i] + good[i + 1:])
        self.assertEqual(with_bytes(begins[3] + 10, bytes(begins[7] - begins[3])), good[:3] + good[8:])
        self.assertRegex(script("read_log.py", self.log).stderr, r"log.lcm is cut or damaged: \d+ bytes at 1 place left out\n")
        self.log.write_bytes(b"Once upon a time there was no log." * 9)
        refused = script("read_log.py", self.log)
        self.assertEqual((refused.returncode, refused.stderr), (1, f"{self.log} is not an LCM log.\n"))

    def test_a_lab_whose_log_is_gone_is_not_left_out_unsaid(self):
        """plot refuses the rest, and draws the lab that is there when it is asked for."""
        (self.run_dir / "result.json").write_text('{"labs": ["roark", "shark"]}')
        self.assertEqual(script("plot", self.run_dir).returncode, 0)
        (self.run_dir / "roark/log.lcm").unlink()
        refused = script("plot", self.run_dir)
        self.assertEqual((refused.returncode, "has no log of lab roark, which took part" in refused.stderr), (1, True), refused.stderr)
        self.assertEqual(script("plot", self.run_dir / "shark").returncode, 0)

    def test_reader_decodes(self):
        """read_log.py lists channels with counts, and shows the fields of our messages."""
        listing = script("read_log.py", self.log)
        self.assertRegex(listing.stdout, r"shared +5 ")
        shown = script("read_log.py", self.log, "shared").stdout
        self.assertIn("  robots[47]", shown)
        self.assertIn("    name = team", shown)
        self.assertIn("an unknown type", script("read_log.py", self.log, "foreign").stdout)
        missing = script("read_log.py", self.log, "nowhere")
        self.assertEqual((missing.returncode, "it holds: arena, foreign, shared" in missing.stderr), (1, True))

    def test_plot_draws_both_arenas(self):
        """A run folder gives a picture; another moment gives another picture; one lab's folder will do."""
        self.assertEqual(script("plot", self.run_dir).returncode, 0)
        first = (self.run_dir / "picture.png").read_bytes()
        self.assertEqual(first[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(script("plot", self.run_dir, "--at", 2).returncode, 0)
        self.assertNotEqual((self.run_dir / "picture.png").read_bytes(), first)
        self.assertEqual(script("plot", self.run_dir / "roark").returncode, 0)
        self.assertTrue((self.run_dir / "roark/picture.png").is_file())

    def test_plot_refuses_what_a_run_has_not(self):
        """A moment before the run or after its end, and a second run, are refused in a sentence that tells what there is; a run counts once in curves."""
        self.assertEqual(script("plot", self.run_dir, "--at", 8).returncode, 0)
        (self.run_dir / "picture.png").unlink()
        for at in (8.1, 9999, -1, "nan"):
            refused = script("plot", self.run_dir, "--at", at)
            self.assertEqual((refused.returncode, refused.stderr), (1, f"plot: --at {float(at):g}: {self.run_dir} covers lab time 0 to 8 s; give a time in that range, or none for its end.\n"))
        refused = script("plot", self.run_dir, self.run_dir)
        self.assertEqual((refused.returncode, refused.stderr), (1, "plot: 2 runs were given; this draws one, and drawing/plot_curves the curves of several.\n"))
        self.assertFalse((self.run_dir / "picture.png").exists())
        refused = script("plot_curves", self.run_dir, self.run_dir / "../run")
        self.assertEqual((refused.returncode, refused.stderr), (1, f"plot_curves: {self.run_dir}/../run is named twice; each run counts once\n"))

    def test_pictures_are_of_the_kind_that_their_names_say(self):
        """A JPEG is a JPEG, whatever draws it; an ending that nobody writes is refused in one sentence, and so is a folder that is not there."""
        poses = self.run_dir / "poses.csv"
        poses.write_text("time_s,robot,x_m,y_m,heading_rad,led\n0,0,0.1,0.2,1,red\n1,0,0.12,0.2,1,off\n")
        (self.run_dir / "runs.csv").write_text("run,setting,pair,seed,state,completed\n0,0,a,1,finished,3\n1,0,a,2,finished,5\n")
        drawers = [["plot", self.run_dir, "--out"], ["plot_curves", self.run_dir / "shark", "--out"], ["draw_swarm", poses, "--diameter", 0.033, "--png"],
                   ["plot_batch", self.run_dir, "--column", "completed", "--over", "pair", "--out"]]
        begins = {"png": b"\x89PNG", "jpg": b"\xff\xd8\xff", "JPEG": b"\xff\xd8\xff", "pdf": b"%PDF", "svg": b"<?xml"}
        for name, *words in drawers:
            for ending, begin in begins.items() if name == "plot" else [("jpg", begins["jpg"])]:  # all draw by figure_style
                out = self.run_dir / f"{name}.{ending}"
                drawn = script(name, *words, out)
                self.assertEqual((drawn.returncode, drawn.stderr), (0, ""))
                self.assertEqual(out.read_bytes()[:len(begin)], begin, f"{name} {ending}")
            for out in ("picture.xyz", "picture", "/nowhere/a.jpg") if name == "plot" else ("picture.xyz",):
                refused = script(name, *words, out)
                why = "cannot be written: No such file or directory; choose" if out[0] == "/" else "pictures end in .png, .jpg, .jpeg, .pdf or .svg; give a name with one of these"
                self.assertEqual((refused.returncode, refused.stderr.count("\n"), refused.stderr.startswith(f"{name}: {out}") and why in refused.stderr), (1, 1, True), refused.stderr)

    def test_pictures_say_what_is_to_be_seen(self):
        """Scale, seed, time and a legend, which names robots of other labs only where there are some."""
        def words(name, *arguments):
            out = self.run_dir / "words.svg"
            drawn = script(name, *arguments, out)
            self.assertEqual((drawn.returncode, drawn.stderr), (0, ""))
            return re.findall("<!-- (.*) -->", out.read_text())  # matplotlib's note of each text

        told = [run_folder.new("shown_words_t", of=of, words=meaning) for of, meaning in (("led.4", "walking"), ("led.2", "dwelling"))]
        with self.log.open("ab") as log:
            log.write(run_folder.event(99, 1e9 + 8, "shown", run_folder.new("shown_t", words=told, n_words=len(told)).encode()))
        both = words("plot", self.run_dir, "--out")
        for said in ("lab time 8 s, period 4, seed 7", "x (m)", "y (m)", "robot of another lab", "walking", "dwelling"):
            self.assertIn(said, both)
        alone = self.run_dir.parent / "alone"
        run_folder.make(alone, labs=["shark"])
        self.assertNotIn("robot of another lab", words("plot", alone, "--out"))
        self.assertIn("LED blue", words("plot", alone, "--out"))  # of which nobody has told the meaning
        self.assertIn(f"{self.run_dir / 'shark'}, seed 7", words("plot_curves", self.run_dir / "shark", "--out"))
        poses = self.run_dir / "poses.csv"
        poses.write_text("time_s,robot,x_m,y_m,heading_rad,led\n0,0,0.1,0.2,1,red\n1,0,0.12,0.2,1,off\n")
        self.assertEqual(set(words("draw_swarm", poses, "--diameter", 0.033, "--arena", "0.9x0.5", "--caption", "walk.c, seed 7", "--png")), {"walk.c, seed 7, 1 s", "0.2 m", "off"})

    def test_plot_of_a_killed_run(self):
        """Logs and tables cut in mid-record are drawn up to the last whole period; a log without one gives a sentence."""
        whole = self.log.read_bytes()
        table = self.run_dir / "shark/completed.csv"
        table.write_bytes(table.read_bytes()[:-3])
        self.log.write_bytes(whole[: len(whole) // 2])
        drawn = script("plot", self.run_dir)
        self.assertEqual((drawn.returncode, drawn.stderr.count("\n"), "is cut or damaged: its last" in drawn.stderr), (0, 1, True), drawn.stderr)
        self.log.write_bytes(whole[:100])
        refused = script("plot", self.run_dir)
        self.assertEqual((refused.returncode, "holds no complete period" in refused.stderr, "Traceback" in refused.stderr), (1, True, False))

    def test_plot_of_another_version(self):
        """A log whose arena has a layout of another version is refused with a sentence."""
        known = next(fingerprint for fingerprint, cls in read_log.types().items() if cls.__name__ == "arena_info_t")
        whole = self.log.read_bytes()
        self.assertIn(known, whole)
        self.log.write_bytes(whole.replace(known, bytes(8)))
        refused = script("plot", self.run_dir)
        self.assertEqual((refused.returncode, "is from another version of arkmesh" in refused.stderr, "Traceback" in refused.stderr), (1, True, False), refused.stderr)

    def test_plot_of_another_scenario(self):
        """Without sites and tasks the robots are drawn alone; with the overlay that a scenario shows, and with the swarms of CRE over time."""
        for lab in run_folder.LABS:
            (self.run_dir / lab / "config.toml").unlink()
            (self.run_dir / lab / "completed.csv").unlink()

        def picture():
            drawn = script("plot", self.run_dir)
            self.assertEqual((drawn.returncode, drawn.stderr), (0, ""))
            return (self.run_dir / "picture.png").read_bytes()

        alone = picture()
        circles = [run_folder.new("overlay_circle_t", x_m=0.1, y_m=-0.1, radius_m=0.1, colour=colour, dashed=colour == "site_idle", label="10")
                   for colour in ("site_idle", "site_hard", "own")]
        overlay = run_folder.new("overlay_t", stamp_us=8_000_000, circles=circles)
        self.log.write_bytes(self.log.read_bytes() + run_folder.event(11, 1e9 + 8, "overlay", overlay.encode()))
        with_overlay = picture()
        self.assertNotEqual(with_overlay, alone)
        header = "period,time_s,uncommitted,north,south,ground,ground_south\n"
        (self.run_dir / "shark/swarms.csv").write_text(header + "0,0.0,20,0,0,80,40\n1,2.0,10,2,8,80,50\n2,4.0,9,1,1")
        self.assertNotEqual(picture(), with_overlay)
        (self.run_dir / "shark/swarms.csv").write_text(header)
        picture()


if __name__ == "__main__":
    unittest.main()
