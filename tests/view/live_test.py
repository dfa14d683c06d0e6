"""The real page of real labs in a real browser: STOP on an emulated testbed, restarted labs, pages of other sites, recorded runs."""
import contextlib
import csv
import functools
import http.server
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from selenium.webdriver.common.by import By

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "drawing")]
from chromium import browser  # noqa: E402
from demo_run import emulated_testbed  # noqa: E402
from film_frames import address_of, served  # noqa: E402
from lab_processes import PROGRAM, end_with_parent, run_delay_s  # noqa: E402
from read_log import decode, events  # noqa: E402

SHARK, ROARK = ROOT / "experiments/dhtf/shark.toml", ROOT / "experiments/dhtf/roark.toml"
# Robots that stand are seen to move less than this between two pictures, metres: true poses have no noise, but pushes fade.
STANDS_M = 2e-5
STANDS_WITHIN_S = 3.5  # of a run's end, in the emulator's time


class LiveTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.driver = cls.enterClassContext(browser())

    def setUp(self):
        self.out = self.folder / self._testMethodName
        self.out.mkdir()

    @contextlib.contextmanager
    def run_labs(self, *arguments, out="run"):
        """`arkmesh run` with these words, and the address of its page."""
        command = [PROGRAM, "run", *arguments, "--out", self.out / out]
        process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, preexec_fn=end_with_parent)
        try:
            url = address_of(process.stdout)
            rest = threading.Thread(target=process.stdout.read, daemon=True)
            rest.start()
            yield process, url
        finally:
            process.send_signal(signal.SIGTERM)
            process.wait(300)
            rest.join(5)
            process.stdout.close()

    def until(self, script, *arguments, seconds=300):
        end = time.monotonic() + seconds
        while not (value := self.driver.execute_script(script, *arguments)):
            if time.monotonic() > end:
                self.fail(f"after {seconds} s still not: {script}\n{self.driver.get_log('browser')}\n{self.driver.find_element(By.TAG_NAME, 'body').text}")
            time.sleep(0.02)
        return value

    def open(self, url, labs=1):
        self.driver.get("about:blank")
        self.driver.get(url)
        self.until("return window.arkmesh?.world.labs.length === arguments[0] && arkmesh.world.labs.every((l) => l.robots.length)", labs)

    def wait_for(self, condition, seconds=300):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)

    def truth(self, name="robot"):
        """Rows of the emulator's truth so far: {time_s: {robot: (x, y)}}, without a last one that is half written; robots by number, or by id."""
        text = (self.out / "truth.csv").read_text()
        frames = {}
        for row in csv.DictReader(text[:text.rindex("\n")].splitlines()):
            frames.setdefault(float(row["time_s"]), {})[row[name]] = (float(row["x_m"]), float(row["y_m"]))
        return frames

    def moves(self, frames):
        """Times at which some robot had moved since the picture before."""
        times = sorted(frames)
        return [now for before, now in zip(times, times[1:]) if any(
            abs(x - frames[before][r][0]) + abs(y - frames[before][r][1]) > STANDS_M for r, (x, y) in frames[now].items() if r in frames[before])]

    def run_delays(self):
        """{process: seconds} for which it wanted a processor and had none, of all that were started here: browser, labs, emulator."""
        parents = {}
        for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
            with contextlib.suppress(OSError):
                parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
        ours, size = {os.getpid()}, 0
        while len(ours) > size:
            size = len(ours)
            ours |= {process for process, parent in parents.items() if parent in ours}
        return {process: run_delay_s(process) for process in ours}

    @contextlib.contextmanager
    def run_swarm(self, program, *more):
        process = subprocess.Popen(list(map(str, [PROGRAM, "controller", "run", program, *more])), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   preexec_fn=end_with_parent)
        try:
            yield process, address_of(process.stdout)
        finally:
            process.send_signal(signal.SIGTERM)
            process.wait(300)
            process.stdout.close()

    def test_swarm_of_one_program(self):
        """`controller run --pace`: robots, their colours and what one prints; pause, restart, the next seed; a program that is broken and mended meanwhile."""
        source = """#include <kilolib.h>
#include <debug.h>
#include <stdio.h>
int n = 0, me = 0;
void setup() { me = kilo_uid; }
void loop() { printf("n is %d, hello from %d\\n", n++, me); set_color(RGB(3, 0, 0)); set_motors(kilo_turn_left, 0); delay(100); }
int main() { kilo_init(); debug_init(); kilo_start(setup, loop); return 0; }
"""
        program = self.out / "talks.c"
        program.write_text(source)
        clock = "return arkmesh.world.labs[0].t_us"
        shown = "return document.getElementById('side').innerText"

        def press(name):
            self.driver.find_element(By.ID, f"command-{name}").click()
            self.until("return document.querySelector('.said').textContent.startsWith(arguments[0])", f"talks.c: {name}: accepted")  # more follows a status

        def says(*words):
            self.wait_for(lambda: all(word in self.driver.execute_script(shown) for word in words))
        with self.run_swarm(program, "-D", "DEBUG", "--robots", 4, "--pace", 2, "--seed", 7) as (swarm, url):
            self.open(url)
            self.until("return arkmesh.world.labs[0].robots.length === 4 && arkmesh.world.labs[0].robots.every((r) => r.led === 1)")
            self.assertEqual([b.text for b in self.driver.find_elements(By.CSS_SELECTOR, ".control button") if b.is_displayed()],
                             ["Pause", "Resume", "Restart", "Next seed", "Slower", "Faster"])
            # panels of labs have nothing to say here
            self.assertEqual([s.text for s in self.driver.find_elements(By.CSS_SELECTOR, "#side > details > summary") if s.is_displayed()], ["World", "Robot", "Channels", "Events"])
            self.driver.execute_script("arkmesh.options.set({pick: {lab: 'talks.c', id: 2}})")
            says("Printed by its program", "n is ", "hello from 2", "seed 7, at most 2x real time")
            self.until(f"{clock} > 30e6")  # after the restart the clock shows less for so long
            press("pause")
            says("paused")
            paused_us = self.driver.execute_script(clock)
            time.sleep(0.5)
            self.assertEqual(self.driver.execute_script(clock), paused_us)
            press("resume")
            self.until("return arkmesh.world.labs[0].t_us > arguments[0]", paused_us)
            first = self.driver.execute_script("return arkmesh.world.labs[0].robots.map((r) => r.x)")
            press("restart")
            self.until("return arkmesh.world.labs[0].t_us < arguments[0]", paused_us)
            says("hello from 2")
            press("next_seed")
            says("seed 8")
            self.assertNotEqual(self.driver.execute_script("return arkmesh.world.labs[0].robots.map((r) => r.x)"), first)
            program.write_text(source.replace("n++", "m++"))
            press("restart")
            says("failed", "talks.c:6")
            program.write_text(source.replace("n is", "again"))
            press("restart")
            says("again ")
            swarm.send_signal(signal.SIGINT)
            self.assertEqual(swarm.wait(300), 0)

    def test_stop_stops_robots(self):
        """A click on STOP: by the emulator's truth no robot moves any more soon after, and the run ends as stopped."""
        with emulated_testbed(self.out), self.run_labs(ROARK, "--set", "arena.use=kilobot", "--set", "shared.owner=roark", "--set", "run.duration_s=600") as (labs, url):
            self.open(url)
            self.until("return arkmesh.world.labs[0].t_us > 5e6 && !document.getElementById('stop').disabled")
            self.driver.execute_script("document.getElementById('stop').addEventListener('click', () => (window.clicked_ms = Date.now()), {capture: true})")
            # What the emulator's clock shows less than ours, by the freshest of some looks.
            offset = min(time.time() - max(self.truth()) for _ in range(10) if not time.sleep(0.05))
            frames = self.truth()
            self.assertGreater(max(self.moves(frames), default=0), max(frames) - 2, "robots move before the click")
            delays = self.run_delays()
            self.driver.find_element(By.ID, "stop").click()
            clicked = self.driver.execute_script("return window.clicked_ms") / 1000 - offset
            self.assertIn(labs.wait(300), (3, 4), "the operator stopped the run; 4: a busy machine did not see robots stand in time")
            machine_late = sum(delay - delays.get(process, 0) for process, delay in self.run_delays().items())
            ended = max(self.truth())
            self.wait_for(lambda: max(self.truth()) > ended + STANDS_WITHIN_S + 3)
            moved = max(self.moves(self.truth()), default=0)
            self.assertLess(moved, ended + STANDS_WITHIN_S, "no robot moves after the run")
            self.assertLess(moved - clicked, 2 + machine_late, "seconds after the click in which a robot still moved")
            # The last word of the lab: where its results are, and whether cameras saw all robots stand.
            self.until("return document.getElementById('ended').textContent.startsWith(arguments[0])", f"ended; results in {self.out}/run; replay with arkmesh view {self.out}/run\nroark: stopped; robots told to stop; ")
            self.assertRegex(self.driver.execute_script("return document.getElementById('ended').textContent"), "all robots were seen standing$|not seen standing: ")
        self.assertEqual(json.loads((self.out / "run/result.json").read_text()).get("by_lab", {}).get("roark", {}).get("state", "stopped"), "stopped")

    def test_reset(self):
        """Robots that were reset at the page stand, and walk again after Resume."""
        places = "return [arkmesh.world.labs[0].t_us, arkmesh.world.labs[0].robots.map((r) => [r.x, r.y])]"

        def walk():
            begin_us, before = self.driver.execute_script(places)
            self.until("return arkmesh.world.labs[0].t_us > arguments[0]", begin_us + 1e6)
            return any(abs(x - u) + abs(y - v) > 1e-4 for (x, y), (u, v) in zip(before, self.driver.execute_script(places)[1]))
        with self.run_labs(ROARK, "--set", "arena.pace=1", "--set", "shared.owner=roark", "--set", "run.duration_s=600") as (_, url):
            self.open(url)
            self.wait_for(walk)
            self.driver.find_element(By.ID, "command-reset").click()
            self.until("return document.querySelector('.said').textContent .startsWith('roark: reset: accepted')")
            self.wait_for(lambda: not walk())
            self.until("return document.querySelector('.said').textContent === 'roark: reset: accepted; robots told to stop; all robots were seen standing'")
            self.until("return /^roark: robots are held by the operator; lab time continues/.test(document.getElementById('kept').textContent)")
            self.driver.find_element(By.ID, "command-resume").click()
            self.wait_for(walk)
            self.until("return document.getElementById('kept').hidden")

    def test_faults_reach_an_emulator_elsewhere(self):
        """Robots of an emulator that is a process of its own are moved from the lab's page, its cameras fail; when it is gone, a sentence says so."""
        ask = "const [what, done] = arguments; arkmesh.player.ask(what).then(({answer}) => done(answer.text ?? `refused: ${answer.refused}`))"
        with contextlib.ExitStack() as emulator:
            emulator.enter_context(emulated_testbed(self.out))
            with self.run_labs(ROARK, "--set", "arena.use=kilobot", "--set", "shared.owner=roark", "--set", "run.duration_s=600", "--set", "view.emulator=127.0.0.1:8092") as (_, url):
                self.open(url)
                robot = self.until("return arkmesh.control.may && arkmesh.world.labs[0].robots.find((r) => r.id > 0)?.id")
                # Somewhere nobody stands.
                places = [(x, y) for x in (-0.2, 0, 0.2) for y in (-0.2, 0, 0.2)]
                x, y = next(p for p in places if self.driver.execute_async_script(ask, {"move": {"lab": 0, "robot": robot, "x_m": p[0], "y_m": p[1]}}) == "ok")
                def newest():
                    frames = self.truth("id")
                    return frames[max(frames)][str(robot)]
                self.wait_for(lambda: abs(newest()[0] - x) + abs(newest()[1] - y) < 0.03)
                self.until("return [...document.querySelectorAll('#side button')].some((b) => b.textContent === 'darken')")
                self.driver.execute_script("[...document.querySelectorAll('#side button')].find((b) => b.textContent === 'darken').click()")
                self.until("return /camera camera0 dark: ok/.test(document.getElementById('side').textContent)")
                with socket.create_connection(("127.0.0.1", 8092), 10) as port, port.makefile("rw") as lines:
                    print("status", file=lines, flush=True)
                    self.assertIn(" camera0=dark ", lines.readline())
                emulator.close()
                said = self.driver.execute_async_script(ask, {"fault": {"lab": 0, "line": "camera camera0 ok"}})
                self.assertEqual(said, "refused: the emulator at 127.0.0.1:8092 (view.emulator) does not answer: Connection refused")

    def test_curves_begin_with_the_run(self):
        """A page that is opened late shows what was counted since the run began, and goes on with it; so does it after a reload."""
        with self.run_labs(SHARK, ROARK, "--set", "run.duration_s=1000000") as (_, url):
            self.open(url, labs=2)
            self.until("return arkmesh.world.labs.every((l) => l.t_us > 60e6)")
            for _ in range(2):
                self.open(url, labs=2)
                opened_us = self.until("return arkmesh.counts.series.has('shark completed') && arkmesh.world.labs[0].t_us")
                t_s, y, now = self.until("""arkmesh.counts.note(arkmesh.world);
                    const {t_s, y} = arkmesh.counts.series.get('shark completed'), lab = arkmesh.world.labs.find((l) => l.own === 'shark');
                    return t_s.at(-1) > arguments[0] / 1e6 + 5 && t_s.at(-1) === lab.status.stamp_us / 1e6 && [t_s, y, Number(lab.counter('counts.completed'))]""", opened_us)
                self.assertLessEqual(t_s[0], 2)
                self.assertEqual(t_s, sorted(set(t_s)))
                self.assertEqual((y[0], y[-1], y), (0, now, sorted(y)))
                self.assertGreater(len([t for t in t_s if t < opened_us / 1e6 - 5]), 15, "points from before the page was opened")

    def test_a_short_run_names_no_page_that_is_gone(self):
        """A run that is over at once tells how to see it, and no address of a page that nobody answers at any more; one that goes on tells its address."""
        out = self.out / "run"
        said = subprocess.run([PROGRAM, "run", ROARK, "--set", "shared.owner=roark", "--set", "run.duration_s=20", "--out", out], check=True, capture_output=True, text=True)
        self.assertNotIn("http://", said.stdout + said.stderr)
        self.assertIn(f"see it with arkmesh view {out}\n", said.stdout)
        with self.run_labs(ROARK, "--set", "arena.pace=1", "--set", "shared.owner=roark", "--set", "run.duration_s=600", out="long") as (_, url):
            self.open(url)

    def test_all_robots_of_a_large_swarm(self):
        """Of a lab with so many robots that a frame comes as two messages the page draws all, of one moment."""
        more = ["arena.robots=1023", "arena.width_m=3", "arena.height_m=3", "arena.pace=1", "shared.owner=roark", "run.duration_s=600"]
        with self.run_labs(ROARK, *(word for key in more for word in ("--set", key))) as (_, url):
            self.open(url)
            self.until("return arkmesh.world.labs[0].t_us > 5e5 && arkmesh.world.labs[0].robots.length === 1023")
            self.assertEqual(self.driver.execute_script("return [arkmesh.world.labs[0].robots.map((r) => r.id).join() === [...Array(1023).keys()].join(), [...arkmesh.world.not_understood]]"), [True, []])

    def test_reconnects_after_the_lab_restarts(self):
        """The page of a lab that went says so, and goes on by itself when a lab is there again; to command it takes the new address."""
        more = ["--set", "arena.pace=1", "--set", "shared.owner=roark", "--set", "run.duration_s=600"]
        with self.run_labs(ROARK, *more, out="first") as (_, url):
            self.open(url)
            self.until("return arkmesh.control.may")
        self.until("return !document.getElementById('banner').hidden")
        port = url.split(":")[2].split("/")[0]
        with self.run_labs(ROARK, *more, "--set", f"view.port={port}", out="second") as (_, again):
            self.assertEqual(again.split("/#")[0], url.split("/#")[0])
            self.until("return document.getElementById('banner').hidden")
            version = self.driver.execute_script("return arkmesh.world.labs[0].robots_version")
            self.until("return arkmesh.world.labs[0].robots_version > arguments[0] + 5", version)
            self.assertFalse(self.driver.execute_script("return arkmesh.control.may"))
            self.open(again)
            self.until("return arkmesh.control.may")

    def test_other_sites_get_nothing(self):
        """A page of another origin, in the browser that holds the cookie, gets no frame, reads nothing and commands nothing."""
        with self.run_labs(ROARK, "--set", "arena.pace=1", "--set", "shared.owner=roark", "--set", "run.duration_s=600") as (labs, url):
            self.open(url)
            self.until("return arkmesh.control.may")
            address = url.split("/#")[0].removeprefix("http://")
            other = self.out / "other"
            other.mkdir()
            (other / "index.html").write_text("<title>another site</title>")
            handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=str(other))
            handler.log_message = lambda *_: None
            with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as site:
                threading.Thread(target=site.serve_forever, daemon=True).start()
                for name in ("127.0.0.1", "localhost"):
                    self.driver.get(f"http://{name}:{site.server_port}/")
                    got = self.driver.execute_async_script("""const [address, done] = arguments, got = [];
                        const read = (path, how) => fetch(`http://${address}${path}`, how).then((r) => r.text()).then((t) => got.push(t.slice(0, 50)), () => {});
                        const socket = new WebSocket(`ws://${address}/ws`);
                        socket.onopen = () => { got.push("open"); socket.send('{"command": {"name": "stop"}}'); };
                        socket.onmessage = (m) => got.push("message");
                        socket.onclose = async () => {
                            await read("/about.json", {credentials: "include"}); await read("/token", {method: "POST", body: "x", credentials: "include"});
                            done(got); };""", address)
                    self.assertEqual(got, [])
                site.shutdown()
            self.open(f"http://{address}/")
            before = self.driver.execute_script("return arkmesh.world.labs[0].t_us")
            self.until("return arkmesh.world.labs[0].t_us > arguments[0] + 1e6", before)
            self.assertIsNone(labs.poll(), "the run goes on")

    def test_each_browser_of_a_batch_has_its_run(self):
        """Of two browsers before a batch one opens another run: the other one stays where it is, and each goes on with its own when the program is there again."""
        batch = self.out / "batch"
        subprocess.run([PROGRAM, "batch", ROARK, "--set", "shared.owner=roark", "--set", "recorder.log=true", "--seeds", "1..2", "--set", "run.duration_s=20", "--out", batch], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        shown = {}
        for run in ("00000", "00001"):
            log = events(batch / "runs" / run / "roark/log.lcm")
            frames = [m for m in (decode(data) for _, channel, data in log if channel == "poses") if m.stamp_us <= 10_000_000]
            shown[run] = [[r.robot, r.x_m, r.y_m] for r in frames[-1].robots]
        self.assertNotEqual(shown["00000"], shown["00001"])
        places = "return JSON.stringify(arkmesh.world.labs[0].robots.map((r) => [r.id, r.x, r.y])) === JSON.stringify(arguments[0]) && arkmesh.world.about.run === arguments[1]"
        with contextlib.ExitStack() as server:
            url = server.enter_context(served([batch]))
            self.open(url)
            first = self.driver.current_window_handle
            self.driver.switch_to.new_window("tab")
            second = self.driver.current_window_handle
            try:
                self.open(url)
                self.driver.execute_script("const c = document.querySelector('#side select'); c.selectedIndex = 1; c.dispatchEvent(new Event('change'))")
                for again in (False, True):
                    if again:
                        server.close()
                        self.until("return !document.getElementById('banner').hidden")
                        server.enter_context(served([batch]))
                    for tab, run in ((first, "00000"), (second, "00001"), (first, "00000")):
                        self.driver.switch_to.window(tab)
                        self.until("return document.getElementById('banner').hidden && arkmesh.world.about.run === arguments[0]", run)
                        for t_us in (0, 10_000_000):
                            self.driver.execute_script("arkmesh.player.seek(arguments[0])", t_us)
                        self.until(places, shown[run], run)
                        self.until("return document.querySelector('#side select').selectedOptions[0].textContent === arguments[0]", run)
            finally:
                self.driver.switch_to.window(second)
                self.driver.close()
                self.driver.switch_to.window(first)
            length_us = self.driver.execute_script("return arkmesh.player.length_us")
            self.driver.execute_script("document.getElementById('all-runs').click()")
            self.until("const seen = [...document.querySelectorAll('.batch canvas')]; return seen.length === 2 && new Set(seen.map((c) => c.toDataURL())).size === 2 && seen.every((c) => c.height > 80)")
            heads = self.driver.execute_script("return [...document.querySelectorAll('.batch th')].map((cell) => cell.innerText)")
            self.assertEqual(heads, ["seed 1", "seed 2"])
            with open(batch / "runs.csv", newline="") as table:
                done = [row["completed"] for row in csv.DictReader(table)]
            self.assertEqual(self.driver.execute_script("return [...document.querySelectorAll('.batch .run span')].map((cell) => cell.innerText)"), done)
            self.assertEqual(self.driver.execute_script("return [document.querySelector('.batch select').selectedOptions[0].textContent, arkmesh.player.length_us]"), ["completed tasks", length_us])
            self.driver.execute_script("document.querySelectorAll('.batch .run')[1].click()")
            self.until("return arkmesh.world.about.run === '00001' && !document.querySelector('.batch').open")

    def test_recorded_run(self):
        """Scrubbing a run folder shows the poses of its log at that time; every message of it is decoded as Python's decoder does."""
        subprocess.run([PROGRAM, "run", SHARK, ROARK, "--seed", "3", "--set", "run.duration_s=60", "--out", self.out / "run"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with served([self.out / "run"]) as url:
            self.open(url, labs=2)
            names = self.driver.execute_script("return arkmesh.world.labs.map((l) => l.own)")
            self.until("return Number(document.getElementById('scrub').max) >= 60000")  # the bar knows the run's length
            for t_us in (30_000_000, 12_340_000, 60_000_000):
                self.driver.execute_script("const b = document.getElementById('scrub'); b.value = arguments[0] / 1000; b.dispatchEvent(new Event('input'))", t_us)
                for index, lab in enumerate(names):
                    frames = [m for m in (decode(data) for _, channel, data in events(self.out / "run" / lab / "log.lcm") if channel == "poses") if m.stamp_us <= t_us]
                    wanted = [[r.robot, r.x_m, r.y_m, r.heading_rad, r.led] for r in frames[-1].robots]
                    self.until("return JSON.stringify(arkmesh.world.labs[arguments[0]].robots.map((r) => [r.id, r.x, r.y, r.heading, r.led])) === JSON.stringify(arguments[1])", index, wanted)
            self.assertEqual(self.driver.execute_script("return [...arkmesh.world.not_understood]"), [])
            data = {channel: data for _, channel, data in events(self.out / "run/shark/log.lcm")}
            for channel, message in data.items():
                told = self.driver.execute_script("return JSON.stringify(arkmesh.world.types.decode(Uint8Array.from(arguments[0])).value, (k, v) => typeof v === 'bigint' ? `${v}` : v instanceof Uint8Array ? [...v] : v)", list(message))
                self.assertEqual(as_json(json.loads(told)), as_json(plain(decode(message))), channel)


def plain(value):
    """A decoded message as lists, dicts and numbers."""
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, (list, tuple, bytes)):
        return [plain(item) for item in value]
    return value


def as_json(value):
    """The same for both: whole numbers as texts, because some have 64 bits."""
    if isinstance(value, dict):
        return {name: as_json(item) for name, item in value.items()}
    if isinstance(value, list):
        return [as_json(item) for item in value]
    if isinstance(value, bool):
        return value
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return str(value) if isinstance(value, int) else value


if __name__ == "__main__":
    unittest.main()
