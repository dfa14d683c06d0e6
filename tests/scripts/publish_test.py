"""`arkmesh publish`: what a crate holds and what it leaves out, that it is repeated from, and that its page replays the run from a file."""
import base64
import gzip
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest
import zipfile

import h5py
import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
ARKMESH = ROOT / "build/release/arkmesh"
sys.path.append(str(ROOT / "drawing"))
import chromium  # pylint: disable=wrong-import-position
import figure_style  # pylint: disable=wrong-import-position

LABS = [ROOT / "experiments/light_up/a.toml", ROOT / "experiments/light_up/b.toml"]
CITED = ["--author", "Ada Lovelace, 0000-0002-1825-0097", "--author", "Charles Babbage", "--licence", "CC-BY-4.0"]


def called(*words):
    return subprocess.run([str(word) for word in (ARKMESH, *words)], capture_output=True, text=True, timeout=600)


class Publish(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.folder = pathlib.Path(scratch.name)
        done = called("run", *LABS, "--seconds", "5", "--set", 'b:gateway.peers=[{lab="a",connect="tls://lab.secret.example:7444"}]', "--set", 'view.hosts=["secret.example"]', "--out", cls.folder / "run")
        assert done.returncode == 0, done.stderr
        cls.crate = cls.folder / "crate"
        done = called("publish", cls.folder / "run", *CITED, "--name", "Lights, TITLE and DATA", "--out", cls.crate)
        assert done.returncode == 0, done.stderr

    def test_metadata_names_what_is_there(self):
        """Each part is a file of the crate and each file but the metadata is a part; a run names program, inputs, seed, hash and results."""
        graph = {entity["@id"]: entity for entity in json.loads((self.crate / "ro-crate-metadata.json").read_text())["@graph"]}
        root = graph["./"]
        parts = {part["@id"] for part in root["hasPart"]}
        files = {file.relative_to(self.crate).as_posix() for file in self.crate.rglob("*") if file.is_file()}
        self.assertEqual(parts, files - {"ro-crate-metadata.json"})
        self.assertEqual([graph[person["@id"]]["name"] for person in root["author"]], ["Ada Lovelace", "Charles Babbage"])
        self.assertEqual(root["license"]["@id"], "https://spdx.org/licenses/CC-BY-4.0")
        action = graph[root["mentions"][0]["@id"]]
        self.assertEqual((action["@type"], graph[action["instrument"]["@id"]]["name"]), ("CreateAction", "arkmesh"))
        inputs, results = ({each["@id"] for each in action[key]} for key in ("object", "result"))
        self.assertLessEqual({"run/a/config.toml", "run/b/config.toml", "run/a/files/light_up.c", "#seed-0"}, inputs)
        self.assertLessEqual({"run/hash.csv", "run/a/trajectories.csv", "run/trajectories.h5", "replay.html", "#hash-0"}, results)
        self.assertEqual(graph["#hash-0"]["value"], json.loads((self.folder / "run/result.json").read_text())["final_hash"])
        with zipfile.ZipFile(f"{self.crate}.zip") as packed:
            self.assertLessEqual(files, set(packed.namelist()))
        self.assertIn("orcid: https://orcid.org/0000-0002-1825-0097", (self.crate / "CITATION.cff").read_text())

    def test_a_region_goes_along(self):
        """The page replays a polygon that the scenario draws."""
        for words in (["run", ROOT / "experiments/pieces/a.toml", "--set", "scenario.pieces.piece=region", "--seconds", "4", "--out", self.folder / "region"],
                      ["publish", self.folder / "region", *CITED, "--out", self.folder / "region-crate"]):
            done = called(*words)
            self.assertEqual(done.returncode, 0, done.stderr)
        packed = re.search(r'const packed = "([^"]+)"', (self.folder / "region-crate/replay.html").read_text())[1]
        self.assertIn(b'"close":1', gzip.decompress(base64.b64decode(packed)))

    def test_nothing_secret_goes_along(self):
        """Neither addresses nor this computer's name nor its folders are in any file."""
        host = json.loads((self.folder / "run/result.json").read_text())["process"]["host"]
        for file in self.crate.rglob("*"):
            if file.suffix in (".json", ".toml", ".csv", ".md", ".html", ".cff"):
                text = re.sub('const packed = "[^"]*"', "", file.read_text())
                for secret in ("secret.example", f'"{host}"', str(ROOT), str(self.folder)):
                    self.assertNotIn(secret, text, file)
        self.assertIn("secret.example", (self.folder / "run/b/config.toml").read_text())  # it was there

    def test_hdf5_has_what_csv_has(self):
        """Each row of a lab's CSV is at its frame and robot of the HDF5 file, no other is, and the file tells nothing secret."""
        self.assertNotIn(b"secret.example", (self.crate / "run/trajectories.h5").read_bytes())
        with h5py.File(self.crate / "run/trajectories.h5") as told:
            self.assertEqual(set(told), {"a", "b"})
            for name, lab in told.items():
                rows = numpy.loadtxt(self.crate / f"run/{name}/trajectories.csv", delimiter=",", skiprows=1)
                seen = ~numpy.isnan(lab["x_m"][:])
                frames, robots = numpy.nonzero(seen)
                table = numpy.column_stack([lab["time_s"][:][frames], lab["robot"][:][robots], *(lab[key][:][seen] for key in ("x_m", "y_m", "heading_rad", "led"))])
                self.assertGreater(len(rows), 100)
                numpy.testing.assert_allclose(table, rows, rtol=1e-5, atol=1e-6)

    def test_the_crate_repeats_its_run(self):
        """`rerun` of the crate alone gives the same hash."""
        again = called("rerun", self.crate / "run")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("equal: final hash", again.stdout)

    def test_the_page_replays_from_a_file(self):
        """From file:// robots are drawn where they were, and playing goes on to the end."""
        self.assertLess((self.crate / "replay.html").stat().st_size, 2_000_000)
        self.assertNotRegex((self.crate / "replay.html").read_text(), r'(src|href)="|https?://')
        with chromium.browser() as driver:
            driver.get((self.crate / "replay.html").as_uri())
            self.until(driver, "return typeof run !== 'undefined' && run.labs?.length === 2 && run.labs[0].xy")
            told = driver.execute_script("const lab = run.labs.find((l) => l.name === 'b'), f = run.frames - 1; return [run.frames, run.step_s, lab.ids, [...lab.xy.slice(2 * f * lab.n, 2 * (f + 1) * lab.n)]]")
            frames, step_s, ids, xy = told
            self.assertEqual((frames, step_s, ids), (51, 0.1, list(range(12))))
            rows = [line.split(",") for line in (self.crate / "run/b/trajectories.csv").read_text().splitlines()[1:]]
            last = {int(row[1]): (float(row[2]), float(row[3])) for row in rows if float(row[0]) == 5}
            for robot in ids:
                for axis in range(2):
                    self.assertAlmostEqual(xy[2 * robot + axis], last[robot][axis], delta=0.0001)
            self.assertEqual(driver.execute_script("return leds"), figure_style.LEDS)
            driver.find_element("id", "play").click()
            self.until(driver, "return document.getElementById('time').textContent === '0:05 / 0:05' && document.getElementById('play').textContent === '▶'")
            self.assertEqual([entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"], [])

    def until(self, driver, script, seconds=120):
        end = time.monotonic() + seconds
        while not driver.execute_script(script):
            self.assertLess(time.monotonic(), end, script)
            time.sleep(0.05)

    def test_what_a_citation_lacks_is_asked_for(self):
        for words, wanted in (([], '--author "NAME, ORCID" and --licence'), (CITED[:2], "lacks --licence"), ([*CITED[2:], "--author", "Ada, 0000-0002-1825-0098"], "its last digit is a checksum"),
                              ([*CITED, "--out", self.crate], "already exists")):
            refused = called("publish", self.folder / "run", *words)
            self.assertEqual((refused.returncode, refused.stderr.count("\n"), wanted in refused.stderr), (1, 1, True), refused.stderr)
        self.assertFalse((self.folder / "run-crate").exists())


if __name__ == "__main__":
    unittest.main()
