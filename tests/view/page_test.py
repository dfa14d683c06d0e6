"""The page in a real browser before a stand-in for a lab's server: what it shows, what its controls send, and how it plays a recorded run."""
import io
import json
import pathlib
import re
import subprocess
import tempfile
import time
import unittest

from PIL import Image, ImageChops, ImageStat
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from double_server import Double, packed, types_json  # also finds scripts/
from made_run import encode, pose, rows
from chromium import browser
import figure_style
import film_frames

LABS = ["shark", "roark"]


class PageTest(unittest.TestCase):
    """Starts a browser once; each test has servers of its own."""

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            cls.types = types_json(folder)
        cls.of = json.loads(cls.types)["types"]
        cls.rows = rows(cls.of)
        cls.driver = cls.enterClassContext(browser())
        cls.driver.set_script_timeout(300)

    def serve(self, **more):
        server = Double(more.pop("labs", LABS), more.pop("rows", self.rows), self.types, **more)
        self.addCleanup(server.stop)
        return server

    def open(self, server, token=None):
        self.driver.delete_all_cookies()
        self.driver.get("about:blank")
        self.driver.get_log("browser")
        self.driver.get(server.url + (f"#token={token}" if token else ""))
        self.until("return window.arkmesh?.world.labs.length === 2 && arkmesh.world.labs.every((l) => l.robots.length && l.shared) && arkmesh.stage.panes.list.length")

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def until(self, script, *arguments, seconds=300):
        """Waits for a condition in the page, and returns what it was."""
        end = time.monotonic() + seconds
        while not (value := self.js(script, *arguments)):
            if time.monotonic() > end:
                self.fail(f"after {seconds} s still not: {script}\n{self.driver.get_log('browser')}\n{self.text()}")
            time.sleep(0.02)
        return value

    def heard(self, server, name, count=1, seconds=300):
        """Waits until the server has heard so many such messages, and returns all of them."""
        end = time.monotonic() + seconds
        while len(said := [m[name] for m in server.heard if name in m]) < count:
            self.assertLess(time.monotonic(), end, f"the server heard fewer than {count} of {name}: {server.heard}")
            time.sleep(0.02)
        return said

    def drawn(self):
        """Returns when what has been done before is on the canvases."""
        self.driver.execute_async_script("const [done] = arguments; requestAnimationFrame(() => requestAnimationFrame(() => done()))")

    def text(self):
        return self.driver.find_element(By.ID, "side").text

    def at_robot(self, lab, robot):
        """Offset of a robot from the middle of the stage, CSS pixels."""
        self.until("return /▶ running/.test(document.getElementById('side').innerText)")  # panels and header have what labs said
        self.drawn()  # where the stage is as large as it is now
        return self.js("""const {stage, world} = arkmesh, lab = world.labs[arguments[0]], r = lab.robots.find((x) => x.id === arguments[1]);
            const {placement: p} = stage.panes.list.flatMap((x) => x.labs).find((x) => x.lab === lab);
            return [Math.round(p.x(r.x, r.y) - stage.root.clientWidth / 2), Math.round(p.y(r.x, r.y) - stage.root.clientHeight / 2)]""", lab, robot)

    def drag(self, begin, by, steps=4):
        stage = self.driver.find_element(By.ID, "stage")
        chain = ActionChains(self.driver, duration=20).move_to_element_with_offset(stage, *begin).click_and_hold()
        for _ in range(steps):
            chain = chain.move_by_offset(by[0] // steps, by[1] // steps)
        chain.release().perform()

    def test_shows_what_labs_send(self):
        """Decoded places are those that were encoded, panels say them in words, and nothing was misunderstood or complained of."""
        self.open(self.serve())
        robots, t_us = self.js("const lab = arkmesh.world.labs[0]; return [lab.robots, lab.newest.get('poses').t_us]")
        self.assertEqual([(r["id"], r["x"], r["y"], r["heading"], r["led"]) for r in robots],
                         [(i, p["x_m"], p["y_m"], p["heading_rad"], p["led"]) for i, p in enumerate(pose(i, t_us) for i in range(12))])
        ghost = self.js("return arkmesh.world.labs[0].ghosts[0].robots.find((g) => g.id === 4)")
        self.assertLess(abs(ghost["x"] - pose(4, 0, 0.5)["x_m"] * 2), 0.2)
        self.until("return /▶ running/.test(document.getElementById('side').innerText)")
        self.until("return /waiting for roark: link down/.test(document.getElementById('side').innerText)")
        self.until("return /to_robots.replaced/.test(document.getElementById('side').textContent) && /round trip\\s+850 µs/.test(document.getElementById('side').innerText)")
        self.js("[...document.querySelectorAll('#side summary')].find((s) => /of dropped messages$/.test(s.textContent)).click()")
        self.until("return document.querySelector('#side dl').innerText !== arguments[0]", self.js("return document.querySelector('#side dl').innerText"))  # panels are written anew
        self.until("return /to_robots.replaced/.test(document.getElementById('side').innerText)")  # what was unfolded stays so
        self.assertEqual(self.js("return [...arkmesh.world.not_understood]"), [])
        self.assertEqual([m for m in self.driver.get_log("browser") if m["level"] == "SEVERE"], [])

    def test_channels_are_decoded(self):
        """The table of channels opens the newest message of any channel, field by field."""
        self.open(self.serve())
        self.js("document.querySelectorAll('#side > details').forEach((d) => (d.open = true))")
        self.until("return [...document.querySelectorAll('#side button.link')].find((b) => b.textContent === 'roark: world')")
        self.js("[...document.querySelectorAll('#side button.link')].find((b) => b.textContent === 'roark: world').click()")
        self.until(r"""const words = document.querySelector('.message')?.textContent;
            return /world_t, \d+ B\nlab = roark\nnonce = 6\n/.test(words) && /window\[0\]\n  period = \d+\n  behaviour = 1\d\d\d/.test(words)""")

    def test_tables_break_no_word(self):
        """In the side column numbers and the parts of names stand whole on a line, of long names and large numbers; nothing is cut off, or lies on its neighbour."""
        for width, height in ((1280, 800), (1920, 1080), (390, 844)):
            with self.subTest(width=width), browser(width, height, phone=width < 400) as self.driver:
                self.check_tables()

    def check_tables(self):
        server = self.serve(speed=0.01)  # it tells of peers once, before we do
        self.open(server)
        channels = [{"channel": f"roark/{name}", "age_us": 72_345_000, "messages": 154_369, "bytes": 468_000_000} for name in ("operator_command", "world")]
        server.tell(packed(0, 0, "peers", encode(self.of, "peers_t", {"lab": "shark", "peers": [{
            "lab": "roark", "up": True, "why": "connected", "version": "1", "round_trip_us": 850, "channels": channels,
            "counters": [{"name": "link.dropped.no_room_in_the_outbox_of_this_channel", "value": 1_154_369}]}]})))
        server.channels = {c: {"per_s": 13_612.5, "bytes_per_s": 468_000, "count": 1_154_369} for c in ("roark/operator_command", "roark/world", "poses")}
        self.js("document.querySelectorAll('#side details').forEach((d) => (d.open = true))")
        self.until("return /154.369/.test(document.getElementById('side').innerText) && /13.613/.test(document.getElementById('side').innerText)")
        broken = self.js(r"""const broken = [], nodes = document.createTreeWalker(document.getElementById('side'), NodeFilter.SHOW_TEXT), side = document.getElementById('side').getBoundingClientRect();
            for (let node; (node = nodes.nextNode());) {
                const cell = node.parentElement.closest('td, th');
                if (!cell) continue;
                const words = cell.cellIndex ? /.+/g : /[^\s./:_]+[./:_]*/g;
                for (const word of node.data.matchAll(words)) {
                    const range = document.createRange();
                    range.setStart(node, word.index);
                    range.setEnd(node, word.index + word[0].length);
                    const boxes = [...range.getClientRects()];
                    const own = cell.getBoundingClientRect();
                    if (new Set(boxes.map((b) => Math.round(b.top))).size > 1 || boxes.some((b) => b.right > side.right || b.right > own.right + 1 || b.left < own.left - 1)) broken.push(word[0]);
                }
            }
            return broken""")
        self.assertEqual(broken, [])
        wide = self.js("return [...document.querySelectorAll('#side, #side .body, #side table')].filter((e) => e.scrollWidth > e.clientWidth + 1).map((e) => [e.id, e.className, e.scrollWidth, e.clientWidth])")
        self.assertEqual((wide, self.js("return document.documentElement.scrollWidth <= innerWidth")), ([], True))

    def test_pick_follow_and_measure(self):
        """A click picks the robot under it, its panel tells its messages, the view follows it, and a drag measures metres."""
        self.open(self.serve(speed=0.1))
        stage = self.driver.find_element(By.ID, "stage")
        ActionChains(self.driver).move_to_element_with_offset(stage, *self.at_robot(0, 2)).click().perform()
        self.assertEqual(self.until("return arkmesh.options.pick"), {"lab": "shark", "id": 2})
        self.until("return /robot\\s+shark\\/2/.test(document.getElementById('side').innerText) && /Latest messages/.test(document.getElementById('side').innerText)")
        self.until("return document.querySelector('#side h2 + table')")
        self.driver.find_element(By.TAG_NAME, "body").send_keys("f")
        self.until("const p = arkmesh.stage.panes.list[0], r = arkmesh.world.labs[0].robots[2]; return Math.abs(p.view.x_m - r.x) < 0.02 && Math.abs(p.view.y_m - r.y) < 0.02")
        self.driver.find_element(By.TAG_NAME, "body").send_keys("f0m")
        self.until("return arkmesh.options.tool === 'measure' && !arkmesh.options.follow && arkmesh.stage.panes.moved.size === 0")
        px_per_m = self.js("return arkmesh.stage.panes.list[0].labs[0].placement.scale")
        self.drag((-200, 0), (100, 0))
        words = self.until("return arkmesh.options.ruler?.words")
        self.assertAlmostEqual(float(words.split()[0]) / 1000, 100 / px_per_m, delta=2 / px_per_m)

    def test_what_somebody_selects_stays_selected(self):
        """Panels are written anew four times a second, and a text in them can be copied all the same."""
        self.open(self.serve())
        self.until("return /▶ running/.test(document.getElementById('side').innerText)")
        self.js("const cell = document.querySelector('.world td[colspan]'); getSelection().selectAllChildren(cell); window.selected = getSelection().toString()")
        time_then = self.js("return document.querySelector('.world tr td').textContent")
        self.until("return document.querySelector('.world tr td').textContent !== arguments[0]", time_then)
        self.assertEqual(*self.js("return [getSelection().toString(), selected]"))
        self.assertIn("robots", self.js("return selected"))

    def test_keys_can_be_switched_off(self):
        """A single key acts, unless the box in the help says otherwise; the browser remembers that."""
        server = self.serve()
        self.open(server)
        body = self.driver.find_element(By.TAG_NAME, "body")
        body.send_keys("m")
        self.until("return arkmesh.options.tool === 'measure'")
        self.js("document.getElementById('keys-on').click()")
        body.send_keys("l")
        self.drawn()
        self.assertEqual(self.js("return [arkmesh.options.tool, localStorage.getItem('arkmesh.keys')]"), ["measure", "off"])
        self.open(server)
        self.assertFalse(self.js("return document.getElementById('keys-on').checked"))
        self.js("document.getElementById('keys-on').click()")
        self.driver.find_element(By.TAG_NAME, "body").send_keys("m")
        self.until("return arkmesh.options.tool === 'measure'")

    def test_the_address_holds_what_is_shown(self):
        """Picked robot and layers stand in the address, and who opens it sees the same."""
        server = self.serve(speed=0.1)
        self.open(server)
        self.js("arkmesh.options.set({pick: {lab: 'shark', id: 2}}); arkmesh.options.toggle('labels')")
        self.until("return location.hash === '#robot=shark/2&layers=trails,ghosts,overlay,pictures'")
        self.driver.refresh()
        self.until("return window.arkmesh?.options.pick?.id === 2 && !arkmesh.options.shown.labels && arkmesh.options.shown.trails")

    def test_a_distance_is_measured_within_one_arena(self):
        """A drag from one lab's arena into another's has no length: each has metres of its own."""
        self.open(self.serve(speed=0.1))
        self.driver.find_element(By.TAG_NAME, "body").send_keys("m")
        panes = self.js("return arkmesh.stage.panes.list.map((p) => p.rectangle)")
        across = (0, panes[1]["y"] - panes[0]["y"]) if panes[1]["x"] == panes[0]["x"] else (panes[1]["x"] - panes[0]["x"], 0)
        self.drag((-across[0] // 2, -across[1] // 2), (int(across[0]), int(across[1])))
        self.assertEqual(self.until("return arkmesh.options.ruler?.words"), "measure within one arena")

    def test_only_who_has_the_token_controls(self):
        """Without a token there is no button to press, and the key sends nothing; with a wrong one neither."""
        server = self.serve()
        for token in (None, "wrong"):
            self.open(server, token)
            self.assertFalse(self.driver.find_element(By.ID, "stop").is_enabled())
            self.driver.find_element(By.TAG_NAME, "body").send_keys("s")
            self.until("return /was not sent/.test(document.querySelector('.said').textContent)")
        self.assertEqual([m for m in server.heard if "series" not in m], [])

    def test_who_watches_is_told_of_no_token(self):
        """Where nobody can control, as at a page of a federation, there is no button, and no word of an address that would have one."""
        self.open(self.serve(about={"control": False}))
        self.assertEqual(self.until("return document.querySelector('.said').textContent"), "read-only")
        self.assertFalse(self.driver.find_element(By.ID, "stop").is_displayed())

    def test_nothing_to_press_before_the_page_is_ready(self):
        """Until the server has said what there is, no button, list or bar is to be seen or reached; then only those that are of use."""
        seen = """return [...document.querySelectorAll('button, select, input, summary')].filter((e) => e.checkVisibility({visibilityProperty: true})).map((e) => e.id || e.textContent)"""
        for mode, there, absent in (("live", "stop", "scrub"), ("recorded", "scrub", "stop")):
            server = self.serve(mode=mode, hold=True)
            self.driver.delete_all_cookies()
            self.driver.get("about:blank")
            self.driver.get(server.url + "#token=1234")
            self.until("return window.arkmesh?.connection.socket.readyState === 1")
            self.js(f"window.early = new Set(); (function look() {{ if (!document.body.classList.contains('waiting')) return; (() => {{ {seen} }})().forEach((e) => early.add(e)); requestAnimationFrame(look); }})()")
            ActionChains(self.driver).send_keys("s", Keys.TAB, Keys.ENTER).perform()
            self.assertEqual(self.js(seen), [])
            server.hold = False
            shown = self.until(f"const all = (() => {{ {seen} }})(); return all.includes(arguments[0]) && all", there)
            self.assertNotIn(absent, shown)
            self.assertEqual(self.js("return [...early]"), [])
            self.assertEqual([m for m in server.heard if "command" in m], [])

    def test_a_command_that_nobody_hears_says_so(self):
        """What was under way when the connection broke is called lost at once, not when there is another one."""
        server = self.serve()
        self.open(server, "1234")
        self.until("return !document.getElementById('stop').disabled")
        server.deaf = True
        self.driver.find_element(By.ID, "stop").click()
        self.heard(server, "command", 2)
        server.stop()
        self.until("return /stop was refused: the connection broke before the answer/.test(document.querySelector('.said').textContent)")
        self.driver.find_element(By.ID, "stop").click()
        self.until("return /stop was refused: there is no connection/.test(document.querySelector('.said').textContent)")

    def test_control(self):
        """STOP by button and by key goes to all labs, others to the chosen one; the token leaves the address bar."""
        server = self.serve()
        self.open(server, "1234")
        self.assertNotIn("1234", self.driver.current_url)
        self.until("return !document.getElementById('stop').disabled && document.querySelector('.control select').offsetParent !== null")
        self.driver.find_element(By.ID, "stop").click()
        self.assertEqual(self.heard(server, "command", 2), [{"lab": 0, "name": "stop"}, {"lab": 1, "name": "stop"}])
        self.until("return document.querySelector('.said').textContent === 'shark: stop: accepted\\nroark: stop: accepted'")
        server.heard.clear()
        self.driver.find_element(By.TAG_NAME, "body").send_keys("s")
        self.assertEqual(self.heard(server, "command", 2), [{"lab": 0, "name": "stop"}, {"lab": 1, "name": "stop"}])
        server.heard.clear()
        self.driver.find_element(By.CSS_SELECTOR, ".control select").send_keys("roark")
        self.driver.find_element(By.ID, "command-pause").click()
        self.assertEqual(self.heard(server, "command"), [{"lab": 1, "name": "pause"}])

    def status(self, lab, **values):
        """A status of one of the labs; numbers as in lcmtypes/lab_status_t.lcm."""
        return packed(lab, 3_000_000, "status", encode(self.of, "lab_status_t", {"lab": LABS[lab], "nonce": 7, "phase": 2, "state": "running", "stamp_us": 3_000_000, "period": 1, "last_period": 30, "speed": 1.0} | values))

    def test_tells_what_cameras_saw_of_a_command(self):
        """A pause is only said until cameras have seen all robots stand; meanwhile a banner names who keeps them still; the end tells where results are."""
        server = self.serve(speed=0.01, about={"folder": "runs/demo"})
        self.open(server, "1234")
        self.until("return !document.getElementById('stop').disabled && document.querySelector('.control select').offsetParent !== null")
        for lab in (0, 1):
            server.tell(self.status(lab))
        Select(self.driver.find_element(By.CSS_SELECTOR, ".control select")).select_by_visible_text("shark")  # not by its first letter, which is STOP
        self.driver.find_element(By.ID, "command-pause").click()
        self.until("return document.querySelector('.said').textContent === 'shark: pause: accepted'")
        self.assertTrue(self.js("return document.getElementById('kept').hidden"))
        words = "robots told to stop; not seen standing: 17 (moving), 3, 40 (not in sight)"
        kept = {"wanted": 1, "kept_still": "operator", "state": f"running, with its robots paused by the operator; {words}"}
        unseen = [{"robot": 3, "why": 3}, {"robot": 17, "why": 2}, {"robot": 40, "why": 3}]
        server.tell(self.status(0, **kept, not_standing=unseen))
        self.until("return document.querySelector('.said').textContent === arguments[0]", f"shark: pause: accepted; {words}")
        self.until("return document.getElementById('kept').innerText === arguments[0]", f"shark: robots are held by the operator; lab time continues; {words}.")
        self.until("return document.getElementById('side').innerText.includes(arguments[0])", words)
        said = [self.js("return document.body.innerText") for _ in range(3) if not time.sleep(0.3)]
        for text in said:
            self.assertNotRegex(text.replace("tasks done", "a curve"), "paused|done|were seen standing")
        server.tell(self.status(0, **kept))
        self.until("return document.querySelector('.said').textContent === 'shark: pause: accepted; robots told to stop; all robots were seen standing'")
        server.tell(self.status(0))
        self.until("return document.getElementById('kept').hidden && /have since been told to run/.test(document.querySelector('.said').textContent)")
        end = {"phase": 4, "outcome": 2, "wanted": 1, "kept_still": "end", "state": "failed: stopped by the operator"}
        server.tell(self.status(0, **end, not_standing=unseen))
        server.tell(self.status(1, **end))
        self.until("return document.getElementById('ended').innerText === arguments[0]", f"ended; results in runs/demo; replay with arkmesh view runs/demo\nshark: stopped; {words}\nroark: stopped; robots told to stop; all robots were seen standing")
        server.stop()
        self.until("return /run and its program have ended/.test(document.getElementById('banner').textContent)")
        self.assertFalse(self.js("return document.getElementById('ended').hidden"))

    def test_says_when_it_hears_nothing(self):
        """After 3 s in which nothing comes, of the server or of its labs, the page says so and greys what it shows; then all is as before."""
        server = self.serve()
        self.open(server)
        self.until("return document.getElementById('banner').hidden && !document.body.classList.contains('apart')")
        before = self.js("return getComputedStyle(document.getElementById('stage')).opacity")
        for what, words in (("mute", "Nothing received from this page's server for 3 s"), ("labs_mute", "Nothing received from shark, roark for 3 s")):
            setattr(server, what, True)
            since = time.monotonic()
            self.until("return !document.getElementById('banner').hidden && document.getElementById('banner').textContent.startsWith(arguments[0])", words)
            self.assertGreater(time.monotonic() - since, 2)
            self.assertLess(float(self.js("return getComputedStyle(document.getElementById('stage')).opacity")), 0.5)
            setattr(server, what, False)
            self.until("return document.getElementById('banner').hidden && !document.body.classList.contains('apart')")
            self.assertEqual(self.js("return getComputedStyle(document.getElementById('stage')).opacity"), before)

    def test_faults_and_moving_by_hand(self):
        """In an emulator the picked robot gets faults, and a drag puts a robot where it ends, in its arena's metres."""
        server = self.serve(speed=0.1)
        self.open(server, "1234")
        self.until("return document.getElementById('tool-hand').offsetParent !== null")  # when the page may control
        self.driver.find_element(By.ID, "tool-hand").click()
        begin = self.at_robot(0, 5)
        self.drag(begin, (40, -20))
        [move] = self.heard(server, "move")
        scale = self.js("return arkmesh.stage.panes.list[0].labs[0].placement.scale")
        before = self.js("return arkmesh.world.labs[0].robots.find((r) => r.id === 5)")
        self.assertEqual((move["lab"], move["robot"]), (0, 5))
        self.assertAlmostEqual(move["x_m"], before["x"] + 40 / scale, delta=6 / scale)
        self.assertAlmostEqual(move["y_m"], before["y"] + 20 / scale, delta=6 / scale)
        self.js("arkmesh.options.set({pick: {lab: 'shark', id: 5}})")
        self.until("return [...document.querySelectorAll('#side .buttons button')].some((b) => b.textContent === 'kill')")
        self.js("[...document.querySelectorAll('#side .buttons button')].find((b) => b.textContent === 'kill').click()")
        self.assertEqual(self.heard(server, "fault"), [{"lab": 0, "robot": 5, "line": "kill"}])
        server.heard.clear()
        self.until("return [...document.querySelectorAll('#side button')].some((b) => b.textContent === 'darken')")
        self.js("[...document.querySelectorAll('#side button')].find((b) => b.textContent === 'darken').click()")
        self.assertEqual(self.heard(server, "fault"), [{"lab": 0, "line": "camera camera0 dark"}])

    def test_camera_picture_lies_under_the_arena(self):
        """A picture is placed by its arena_to_px: the corner that is red in it is red on the floor, and stays so when zoomed."""
        server = self.serve(speed=0.01)
        picture = Image.new("RGB", (200, 100), (0, 0, 200))
        picture.paste((200, 0, 0), (150, 0, 200, 30))  # x above 1/3 m, y above 0.2 m
        jpeg = io.BytesIO()
        picture.save(jpeg, "JPEG", quality=95)
        self.open(server)
        server.loop.call_soon_threadsafe(server.send, [packed(0, 0, "camera0", jpeg.getvalue(), kind=2)])
        at = """const {placement: p} = arkmesh.stage.panes.list[0].labs[0], c = document.querySelector('canvas[data-layer=floor]').getContext('2d');
            const [r, g, b] = c.getImageData(Math.round(p.x(arguments[0], arguments[1])), Math.round(p.y(arguments[0], arguments[1])), 1, 1).data; return r > 150 && b < 60 ? 'red' : b > 150 && r < 60 ? 'blue' : `${r} ${g} ${b}`"""
        for _ in range(2):
            self.until(at.replace("return r >", "return 'red' === (r >").replace("`${r} ${g} ${b}`", "'')"), 0.42, 0.26)
            self.assertEqual([self.js(at, 0.42, 0.15), self.js(at, 0.2, 0.26), self.js(at, -0.15, -0.42)], ["blue", "blue", "blue"])
            self.js("arkmesh.pointer.zoom(1.3); arkmesh.pointer.pan(40, -50)")
            self.drawn()

    def test_reconnects(self):
        """When the lab goes, the page says so; when it comes again on that port, the page goes on by itself."""
        server = self.serve()
        self.open(server)
        server.stop()
        self.until("return !document.getElementById('banner').hidden && /Not connected/.test(document.getElementById('banner').textContent)")
        again = self.serve(port=server.port)
        self.until("return document.getElementById('banner').hidden")
        before = self.js("return arkmesh.world.labs[0].robots_version")
        self.until("return arkmesh.world.labs[0].robots_version > arguments[0] + 3", before)
        self.assertEqual(len(again.viewers), 1)

    def test_says_when_its_place_went_to_somebody_else(self):
        """A page that had to make way says that too many watch, not that the lab is gone, and watches again when there is room."""
        server = self.serve()
        self.open(server)
        server.full = True
        server.loop.call_soon_threadsafe(lambda: [viewer.close() for viewer in list(server.viewers)])
        self.until("return /the lab is reachable, but has too many viewers/.test(document.getElementById('banner').textContent)")
        server.full = False
        self.until("return document.getElementById('banner').hidden")

    def test_plays_a_recorded_run(self):
        """Scrubbing shows that moment exactly, a step is a frame, and it plays at the speed that was chosen to the end."""
        server = self.serve(mode="recorded")
        self.open(server)
        bar = self.driver.find_element(By.ID, "scrub")
        self.until("return Number(arguments[0].max) >= 60000", bar)  # the bar knows the run's length
        self.js("arguments[0].value = 20000; arguments[0].dispatchEvent(new Event('input'))", bar)
        self.until("return arkmesh.world.labs[0].newest.get('poses').t_us === 20000000")
        self.assertEqual(self.until("return arkmesh.world.labs[0].robots[1]?.x"), pose(1, 20_000_000)["x_m"])
        self.driver.find_element(By.ID, "stage").click()
        ActionChains(self.driver).send_keys(Keys.ARROW_RIGHT).perform()
        self.until("return arkmesh.world.labs[0].robots[1]?.x === arguments[0]", pose(1, 20_100_000)["x_m"])
        ActionChains(self.driver).send_keys(Keys.ARROW_LEFT).perform()
        self.until("return arkmesh.world.labs[0].robots[1]?.x === arguments[0]", pose(1, 20_000_000)["x_m"])
        self.driver.find_element(By.ID, "speed").send_keys("20×")
        begin = time.monotonic()
        self.driver.find_element(By.ID, "play").click()
        self.until("return arkmesh.player.t_us === 60000000 && !arkmesh.player.playing")
        self.assertGreater(time.monotonic() - begin, 1.8, "40 s of lab time at 20x")
        self.assertEqual(self.js("return arkmesh.world.labs[1].newest.get('poses').t_us"), 60_000_000)
        self.until(r"return /shark\s+1:00.0\s+30 of 30\s+20.0×/.test(document.getElementById('side').innerText)")
        self.assertNotRegex(self.text(), "▶|can wait|real time")
        self.until(r"return /^\s*count\s+shark\s+tasks done\s+1$/.test(document.querySelector('.counts').innerText)")  # as the curve, not as the newest status
        self.js("[...document.querySelectorAll('.events button')].find((b) => b.textContent === '0:50.0').click()")
        self.until("return arkmesh.world.labs[0].robots[1]?.x === arguments[0]", pose(1, 50_000_000)["x_m"])

    def test_curves_are_those_that_the_scenario_names_and_the_viewer_adds(self):
        """One of 18 is named and drawn, in its words; others can be added, up to six at once; the table has all."""
        self.open(self.serve(mode="recorded"))
        series = "return arkmesh.counts.plot?.series.slice(1).map((s) => s.label)"
        self.assertEqual(self.until(series), ["tasks done, shark"])
        # Panels grow and push those below them down, so a pointer may miss: the boxes are clicked as such.
        self.js("document.querySelector('.body > details > summary').click()")
        self.assertEqual(self.js("return document.querySelectorAll('.choices input').length"), 18)
        for i in (1, 2, 3):
            self.js("document.getElementById(arguments[0]).click()", f"curve-{i}")
            self.until("return arkmesh.counts.plot?.series.length === arguments[0]", i + 2)
        self.js("document.getElementById('curve-4').click(); document.getElementById('curve-5').click()")  # before the panel is written anew
        self.until("return arkmesh.counts.plot?.series.length === 7")
        self.assertEqual(self.js("return [...document.querySelectorAll('.choices input')].filter((box) => box.disabled).length"), 12)
        self.js("document.getElementById('curve-0').click()")
        self.until("return arkmesh.counts.plot?.series.length === 6 && arkmesh.counts.plot.series[1].label === 'swarms c0, shark'")
        self.assertEqual(self.js("return [...document.querySelectorAll('.choices input')].filter((box) => box.disabled).length"), 0)
        table = self.driver.execute_async_script("""const [done] = arguments; URL.createObjectURL = (blob) => { blob.text().then(done); return "#"; };
            HTMLAnchorElement.prototype.click = () => {}; document.getElementById("curves-csv").dispatchEvent(new Event("click"))""")
        self.assertEqual(table.splitlines()[0], "time_s,shark.completed," + ",".join(f"shark.swarms.c{i}" for i in range(17)))
        self.assertEqual(table.splitlines()[1], "0,0" + "," * 17)

    def test_the_legend_is_the_scenarios(self):
        """Each colour that is drawn and each LED with words has a line; light and dark have samples of their own."""
        self.open(self.serve())
        lines = self.until("const found = [...document.querySelectorAll('.legend li')].map((line) => line.innerText.trim()); return found.length > 2 && found")
        self.assertEqual(lines[:2], ["task: robots here + there", "walks"])
        self.assertIn("pheromone trail", lines)
        self.assertNotIn("of other labs", lines)
        sample = "return document.querySelector('.legend canvas').toDataURL()"
        before = self.js(sample)
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        self.addCleanup(self.driver.execute_cdp_cmd, "Emulation.setEmulatedMedia", {"features": []})
        self.until(sample + ' !== arguments[0]', before)

    def test_compares_two_runs(self):
        """Two runs lie side by side, and a button goes to where they first differ and says who lies apart there."""
        other = [(t_us, lab + 2, channel, data) for t_us, lab, channel, data in self.rows]
        server = self.serve(mode="recorded", rows=sorted(self.rows + other, key=lambda row: row[0]), labs=[f"{run}/{lab}" for run in ("a", "b") for lab in LABS],
                            about={"first_difference": {"period": 17, "lab": "shark", "t_us": 34_000_000}, "notes": ["The log of b was cut off."]})
        self.driver.get(server.url)
        self.until("return window.arkmesh?.world.labs.length === 4 && arkmesh.world.labs.every((l) => l.robots.length && l.shared)")
        self.assertEqual(self.js("return arkmesh.stage.panes.list.length"), 4)
        self.until("return /The log of b was cut off/.test(document.getElementById('side').innerText)")
        self.js("document.getElementById('difference').click()")
        self.until("return /shark: all robots at the same positions/.test(document.getElementById('side').innerText)")
        self.assertEqual(self.js("return arkmesh.player.t_us"), 34_000_000)

    def test_film_draws_what_the_page_draws(self):
        """A moment of a film, drawn as one picture, has the pixels that the page's layers have; films are the same each time."""
        server = self.serve(mode="recorded")
        compose = """const done = arguments[0]; (async () => {
            const {stage, film} = arkmesh; await film.begin(10e6); for (let i = 0; i < 20; ++i) await film.next(1e6);
            const [floor] = stage.contexts, w = floor.canvas.width, h = floor.canvas.height;
            const flat = new OffscreenCanvas(w, h).getContext('2d'); for (const c of stage.contexts) flat.drawImage(c.canvas, 0, 0);
            const one = new OffscreenCanvas(w, h).getContext('2d'), {whole} = await import('/page/draw/scene.js');
            for (const pane of stage.panes.list) whole(one, stage.scene(pane, true));
            const a = flat.getImageData(0, 0, w, h).data, b = one.getImageData(0, 0, w, h).data; let apart = 0, hash = 0;
            for (let i = 0; i < a.length; ++i) { hash = (hash * 31 + a[i]) | 0; if (Math.abs(a[i] - b[i]) > 12) apart += 1; }
            done([apart / a.length, hash, w * h]); })()"""
        seen = []
        for _ in range(2):
            self.open(server)
            apart, hashed, pixels = self.driver.execute_async_script(compose)
            self.assertLess(apart, 1e-3)
            self.assertGreater(pixels, 300_000)
            seen.append(hashed)
        self.assertEqual(seen[0], seen[1])

    def test_a_film_shows_what_pictures_show(self):
        """What the page encodes itself has the moments, pixels and caption that pictures of it have."""
        server = self.serve(mode="recorded")
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "film.mp4"
            self.assertEqual(film_frames.film(server.url, out, 10, 20, 5, 30, 801, 450, bare=True), 60)
            said = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames,width,height,duration", "-of", "csv=p=0", out], capture_output=True, text=True)
            *size, length_s, moments = map(float, said.stdout.split(","))
            self.assertEqual((size, moments), ([800, 450], 60))
            self.assertAlmostEqual(length_s, 2, 2)
            last = subprocess.run(["ffmpeg", "-loglevel", "error", "-i", out, "-vf", "select=eq(n\\,59)", "-f", "image2pipe", "-c:v", "png", "-"], capture_output=True)
        with film_frames.page(server.url, 801, 450, bare=True) as shown:
            self.assertTrue(shown.can_encode(30), "this Chromium encodes no H.264, and films take several times longer")
            shown.begin(10, 5, 0)
            self.assertEqual(shown.driver.execute_script("return [arkmesh.options.shown.trails, arkmesh.options.trail_s]"), [False, 30])
            shown.begin(10, 5, 30)
            self.assertEqual(shown.driver.execute_script("return [arkmesh.options.shown.trails, arkmesh.options.trail_s]"), [True, 30])
            for _ in range(60):
                shown.next(1 / 6)
            self.assertEqual(shown.driver.execute_script("return arkmesh.stage.caption"), "0:20.0 of 1:00.0, 5×, grid 0.1 m")
            picture = shown.picture("png")
        film, pictures = (Image.open(io.BytesIO(data)).convert("RGB").crop((0, 0, 800, 450)) for data in (last.stdout, picture))
        apart = ImageChops.difference(film, pictures)
        self.assertLess(ImageStat.Stat(apart).mean[1], 3)
        # the caption is there, and in its strip nothing else
        below = pictures.crop((0, 424, 800, 450)).convert("L")
        self.assertGreater(sum(below.histogram()[:100]), 300)
        self.assertEqual(below.crop((0, 0, 250, 26)).getextrema(), below.crop((550, 0, 800, 26)).getextrema())

    def test_ids_cover_nothing(self):
        """Ids of 50 robots, and of ghosts, lie on no robot, no other id and no word that the scenario draws; nearly every robot has its own."""
        self.open(self.serve())
        own, ghosts, on = self.driver.execute_async_script("""const done = arguments[0]; (async () => {
            const {names_of} = await import('/page/draw/scene.js'), {overlay_words} = await import('/page/draw/overlay.js'), {stage, world} = arkmesh;
            const [pane] = stage.panes.list, [{lab, placement: p}] = pane.labs;
            // a spiral: close together in the middle
            lab.robots = Array.from({length: 50}, (_, id) => ({id, x: 0.064 * Math.sqrt(id) * Math.cos(2.4 * id), y: 0.064 * Math.sqrt(id) * Math.sin(2.4 * id), heading: id, led: 1, confidence: 1, age_us: 0}));
            const scene = stage.scene(pane, true), names = names_of(scene), radius = lab.body_radius_m() * p.scale, on = [];
            const apart = (a, b) => Math.abs(a.x - b.x) >= (a.width + b.width) / 2 - 0.5 || Math.abs(a.y - b.y) >= (a.height + b.height) / 2 - 0.5;
            const words = lab.overlay ? overlay_words(lab.overlay, p, stage.sprites.colours, stage.px) : [];
            names.forEach((name, i) => {
                for (const other of names.slice(i + 1)) if (!apart(name.box, other.box)) on.push(`${name.words} on ${other.words}`);
                for (const {words: text, place} of words) if (!apart(name.box, place)) on.push(`${name.words} on ${text}`);
                for (const r of lab.robots) {
                    const dx = Math.abs(name.box.x - p.x(r.x, r.y)) - name.box.width / 2, dy = Math.abs(name.box.y - p.y(r.x, r.y)) - name.box.height / 2;
                    if (Math.hypot(Math.max(0, dx), Math.max(0, dy)) < radius - 0.5) on.push(`${name.words} on robot ${r.id}`);
                }
            });
            done([names.filter((n) => !n.ghost).length, names.filter((n) => n.ghost).length, on]); })()""")
        self.assertEqual(on, [])
        self.assertGreaterEqual(own, 45)
        self.assertGreater(ghosts, 0)

    def test_labs_together(self):
        """In the shared frame a robot lies at the same pixel as its ghost would: projections are right."""
        self.open(self.serve(speed=0.01))
        self.driver.find_element(By.TAG_NAME, "body").send_keys("t")
        self.until("return arkmesh.stage.panes.list.length === 1")
        apart = self.js("""const [a, b] = arkmesh.stage.panes.list[0].labs, g = a.lab.ghosts[0].robots[3], r = b.lab.robots[3];
            return Math.hypot(a.placement.x(g.x, g.y) - b.placement.x(r.x, r.y), a.placement.y(g.x, g.y) - b.placement.y(r.x, r.y))""")
        self.assertLess(apart, 3)

    def test_every_layer_draws(self):
        """Pixels of each layer are there, in the colours of the table, and switching a layer off takes them away."""
        self.open(self.serve(speed=1))
        count = """const c = document.querySelector(`canvas[data-layer=${arguments[0]}]`), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
            let n = 0; for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return n"""
        self.until(count.replace("return n", "return n > 2000"), "robots")
        self.until(count.replace("return n", "return n > 50"), "trails")
        has = """const c = document.querySelector('canvas[data-layer=floor]'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
            let n = 0; for (let i = 0; i < d.length; i += 4) n += d[i] === 0xe8 && d[i + 1] === 0x48 && d[i + 2] === 0x1c; return n"""
        self.until(has.replace("return n", "return n > 50"))  # site_hard's outline
        self.js("arkmesh.options.toggle('overlay')")
        self.until(has.replace("return n", "return n === 0"))

    def test_leds_look_different(self):
        """Any two LED colours differ in a good part of their mark, on light and dark grounds, of robots and of ghosts, large and small."""
        self.open(self.serve())
        least = self.driver.execute_async_script("""const done = arguments[0]; (async () => {
            const {Sprites} = await import('/page/draw/sprites.js'), {Colours, led_names} = await import('/page/draw/colours.js'), table = arkmesh.stage.sprites.colours.table, least = {};
            for (const dark of [false, true]) for (const ghost of [false, true]) for (const radius of [4, 12]) {
                const colours = new Colours(table, dark), sprites = new Sprites(colours);
                const pixels = led_names.map((_, led) => {
                    const sprite = sprites.robot(led, 0.3, radius, ghost), c = new OffscreenCanvas(sprite.width, sprite.height).getContext('2d');
                    c.fillStyle = colours.inks.ground;
                    c.fillRect(0, 0, sprite.width, sprite.height);
                    c.drawImage(sprite, 0, 0);
                    return c.getImageData(0, 0, sprite.width, sprite.height).data;
                });
                const area = Math.PI * (0.55 * radius) ** 2;
                pixels.forEach((a, i) => pixels.forEach((b, j) => {
                    let apart = 0;
                    for (let p = 0; p < a.length; p += 4) apart += Math.max(...[0, 1, 2].map((k) => Math.abs(a[p + k] - b[p + k]))) > 50;
                    if (i < j) least[`${dark ? 'dark' : 'light'} ${ghost ? 'ghost' : 'robot'} ${radius} ${led_names[i]} ${led_names[j]}`] = apart / area;
                }));
            }
            done(least); })()""")
        self.assertEqual({what: round(share, 2) for what, share in least.items() if share < 0.3}, {})
        middle = self.driver.execute_async_script("""const done = arguments[0]; (async () => {
            const {Sprites} = await import('/page/draw/sprites.js'), {Colours} = await import('/page/draw/colours.js');
            const sprite = new Sprites(new Colours(arkmesh.stage.sprites.colours.table, false)).robot(4, 0, 12, false), c = new OffscreenCanvas(sprite.width, sprite.height).getContext('2d');
            c.drawImage(sprite, 0, 0);
            done([...c.getImageData(sprite.width / 2, sprite.height / 2, 1, 1).data]); })()""")
        self.assertEqual(bytes(middle[:3]).hex(), figure_style.LEDS[4][1:])  # as figures and films have it

    def test_phone(self):
        """On a phone nothing is wider than the screen, STOP is in reach, and two fingers zoom."""
        server = self.serve()
        with browser(390, 844, phone=True) as phone:
            phone.get(server.url + "#token=1234")
            end = time.monotonic() + 300
            while not phone.execute_script("return window.arkmesh?.world.labs[0]?.robots.length"):
                self.assertLess(time.monotonic(), end)
                time.sleep(0.02)
            self.assertLessEqual(phone.execute_script("return document.documentElement.scrollWidth"), 390)
            self.assertLessEqual(phone.execute_script("return Math.max(...[...document.querySelectorAll('header :is(button, select)')].map((e) => e.getBoundingClientRect().right))"), 390)
            stop = phone.find_element(By.ID, "stop").rect
            self.assertGreaterEqual(stop["height"], 36)
            self.assertLess(stop["x"] + stop["width"], 390)
            phone.execute_script("scrollTo(0, 9999)")
            self.assertGreater(phone.execute_script("return document.getElementById('stop').getBoundingClientRect().top"), 0)
            phone.execute_script("scrollTo(0, 0)")
            before = phone.execute_script("return arkmesh.stage.panes.list[0].view.px_per_m")
            box = phone.execute_script("const r = document.getElementById('stage').getBoundingClientRect(); return [r.x + 190, r.y + 120]")
            touch = lambda kind, spread: phone.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [] if spread is None else [{"x": box[0] - spread, "y": box[1], "id": 1}, {"x": box[0] + spread, "y": box[1], "id": 2}]})
            for kind, spread in (("touchStart", 20), ("touchMove", 40), ("touchMove", 60), ("touchEnd", None)):
                touch(kind, spread)
            after = phone.execute_script("return arkmesh.stage.panes.list[0].view.px_per_m")
            self.assertGreater(after / before, 2)

    def test_dark(self):
        """In the dark the ground is dark."""
        server = self.serve()
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        self.addCleanup(self.driver.execute_cdp_cmd, "Emulation.setEmulatedMedia", {"features": []})
        self.open(server)
        rgb = re.findall(r"\d+", self.js("return getComputedStyle(document.body).backgroundColor"))
        self.assertLess(int(rgb[0]), 40)
        self.until("return arkmesh.stage.sprites.colours.dark")


if __name__ == "__main__":
    unittest.main()
