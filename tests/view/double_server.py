"""A stand-in for a lab's server: speaks the page's protocol and plays a run folder's log, live or recorded. For tests of the page alone."""
import asyncio
import json
import pathlib
import struct
import subprocess
import sys
import threading

import tornado.httpserver
import tornado.netutil
import tornado.web
import tornado.websocket

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "view/page"
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "drawing")]
from read_log import events  # noqa: E402

TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".json": "application/json", ".svg": "image/svg+xml"}
HEADERS = {"Content-Security-Policy": "default-src 'self'", "X-Content-Type-Options": "nosniff", "Cache-Control": "no-store"}


def types_json(folder):
    out = pathlib.Path(folder) / "types.json"
    subprocess.run([sys.executable, ROOT / "hal/layout/make_types.py", ROOT / "lcmtypes", out], check=True)
    return out.read_bytes()


def packed(lab, t_us, channel, data, request=0, kind=1):
    """One binary frame to the page."""
    return struct.pack("<BBBBIq", kind, lab, len(channel), 0, request, t_us) + channel.encode() + data


def log_of(run, labs):
    """All messages of a run as (t_us, lab, channel, data), in time order."""
    rows = []
    for index, lab in enumerate(labs):
        first = None
        for seconds, channel, data in events(pathlib.Path(run) / lab / "log.lcm"):
            first = seconds if first is None else first
            rows.append((round((seconds - first) * 1e6), index, channel, data))
    return sorted(rows, key=lambda row: row[0])


class Double:
    """The server in a thread of its own. `rows` as log_of gives them; `token` allows control."""

    def __init__(self, labs, rows, types, mode="live", speed=20, token="1234", port=0, hz=30, about=None, hold=False):
        self.labs, self.rows, self.mode, self.speed, self.token, self.hz = labs, rows, mode, speed, token, hz
        self.types = types
        self.deaf = False  # it answers no command
        self.full = False  # it lets nobody more watch
        self.mute = False  # viewers get nothing any more
        self.labs_mute = False  # nothing of the labs, only what the server says by itself
        self.channels = None  # what it counts of each lab's channels; None: what it sent
        self.hold = hold  # viewers get nothing as long as it is true
        self.heard, self.viewers, self.port = [], set(), port
        self.about = {"version": "1.0.0", "mode": mode, "labs": labs, "control": mode == "live", "run": "demo", "emulator": [mode == "live"] * len(labs)} | (about or {})
        self.length_us = rows[-1][0] if rows else 0
        ready = threading.Event()
        self.thread = threading.Thread(target=self.run, args=(ready,), daemon=True)
        self.thread.start()
        ready.wait(300)

    @property
    def url(self):
        return f"http://127.0.0.1:{self.port}/"

    def run(self, ready):
        self.loop = asyncio.new_event_loop()
        asyncio.set_event_loop(self.loop)
        application = tornado.web.Application([
            ("/ws", Socket, {"double": self}), ("/types.json", Bytes, {"data": self.types}),
            ("/about.json", Bytes, {"data": json.dumps(self.about)}), ("/token", Token, {"double": self}), ("/(.*)", File)])
        sockets = tornado.netutil.bind_sockets(self.port, "127.0.0.1", reuse_port=False)
        self.port = sockets[0].getsockname()[1]
        self.server = tornado.httpserver.HTTPServer(application)
        self.server.add_sockets(sockets)
        if self.mode == "live":
            self.loop.create_task(self.play())
        self.loop.call_soon(ready.set)
        self.loop.run_forever()
        self.loop.close()

    def stop(self):
        if self.thread.is_alive():
            asyncio.run_coroutine_threadsafe(self.finish(), self.loop)
            self.thread.join(10)

    async def finish(self):
        """Closes everything; the loop ends a moment later."""
        self.server.stop()
        for viewer in list(self.viewers):
            viewer.close()
        await asyncio.sleep(0.1)
        await self.server.close_all_connections()
        for task in asyncio.all_tasks(self.loop) - {asyncio.current_task()}:
            task.cancel()
        self.loop.call_later(0.05, self.loop.stop)

    async def play(self):
        """Sends the newest of each channel at 30 Hz, from the log's beginning to its end, then again."""
        while True:
            self.newest, at, t_us, counts = {}, 0, 0, {}
            second = 0
            while at < len(self.rows):
                await asyncio.sleep(1 / self.hz)
                t_us += self.speed * 1e6 / self.hz
                fresh = {}
                while at < len(self.rows) and self.rows[at][0] <= t_us:
                    time, lab, channel, data = self.rows[at]
                    fresh[lab, channel] = packed(lab, time, channel, data)
                    counts[lab, channel] = counts.get((lab, channel), 0) + 1
                    at += 1
                self.newest |= fresh
                self.send(fresh.values())
                second += 1
                if second % self.hz == 0:
                    labs = [{"channels": self.channels if self.channels is not None else {c: {"per_s": n / (second / self.hz), "bytes_per_s": 100.0 * n, "count": n} for (i, c), n in counts.items() if i == lab}} for lab in range(len(self.labs))]
                    # A lab tells its status at least once a second of wall time.
                    self.send(frame for (_, channel), frame in self.newest.items() if channel == "status")
                    self.send([json.dumps({"rates": {"t_us": t_us, "labs": labs, "viewer": {"replaced": 0}}})])

    def send(self, frames):
        frames = [] if self.mute else [f for f in frames if not self.labs_mute or isinstance(f, str)]
        for viewer in list(self.viewers):
            for frame in frames:
                viewer.put(frame)

    def tell(self, frame):
        """Puts a frame of a lab, from another thread, in place of what the log says."""
        def put():
            lab, length = frame[1], frame[2]
            self.newest[lab, frame[16:16 + length].decode()] = frame
            self.send([frame])
        self.loop.call_soon_threadsafe(put)


class Bytes(tornado.web.RequestHandler):
    def initialize(self, data):
        self.data = data

    def get(self):
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.set_header("Content-Type", "application/json")
        self.finish(self.data)


class Token(tornado.web.RequestHandler):
    def initialize(self, double):
        self.double = double

    def post(self):
        right = self.request.body.decode() == self.double.token
        if right:
            self.set_cookie("token", self.double.token, httponly=True)
        self.set_status(204 if right else 403)


class File(tornado.web.RequestHandler):
    def get(self, path):
        file = PAGE / (path.removeprefix("page/") or "index.html")
        if not file.is_file():
            raise tornado.web.HTTPError(404)
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.set_header("Content-Type", TYPES.get(file.suffix, "application/octet-stream"))
        self.finish(file.read_bytes())


class Socket(tornado.websocket.WebSocketHandler):
    def initialize(self, double):
        self.double, self.may = double, self.get_cookie("token") == double.token

    async def get(self, *arguments, **more):
        if self.double.full:
            self.set_status(503)
            return self.finish()
        await super().get(*arguments, **more)

    def put(self, frame):
        try:
            self.write_message(frame, binary=isinstance(frame, bytes))
        except tornado.websocket.WebSocketClosedError:
            pass

    def hello(self):
        more = {"length_us": self.double.length_us, "growing": False} if self.double.mode == "recorded" else {}
        self.put(json.dumps({"hello": {"about": self.double.about, "token_ok": self.may} | more}))

    async def open(self):
        while self.double.hold:
            await asyncio.sleep(0.01)
        self.hello()
        self.double.viewers.add(self)
        if self.double.mode == "live":
            self.put(json.dumps({"cameras": [{"lab": 0, "name": "camera0", "width_px": 200, "height_px": 100, "arena_to_px": [150, 0, 100, 0, -100, 50, 0, 0, 1]}]}))
        for frame in getattr(self.double, "newest", {}).values():
            self.put(frame)

    def on_close(self):
        self.double.viewers.discard(self)

    def on_message(self, message):
        said = json.loads(message)
        self.double.heard.append(said)
        request = said.get("request")
        if "seek" in said:
            newest = {}
            for time, lab, channel, data in self.double.rows:
                if time > said["seek"]["t_us"]:
                    break
                newest[lab, channel] = (time, data)
            for (lab, channel), (time, data) in newest.items():
                if channel in said["seek"].get("channels", [channel]):
                    self.put(packed(lab, time, channel, data, request))
            self.put(json.dumps({"done": {"request": request}}))
        elif "frames" in said:
            self.frames(request, said["frames"])
        elif "events" in said:
            self.put(json.dumps({"done": {"request": request, "events": [{"t_us": 0, "lab": 0, "kind": "begin", "text": "the run begins"}, {"t_us": 50_000_000, "lab": 1, "kind": "task", "text": "a task is done"}]}}))
        elif "series" in said:
            self.put(json.dumps({"done": {"request": request, "series": [
                {"name": "shark.completed", "t_s": [0, 50, 82, 90], "y": [0, 1, 2, 3]}, *({"name": f"shark.swarms.c{i}", "t_s": [70, 80], "y": [i, i]} for i in range(17))]}}))
        elif self.double.deaf:
            pass
        elif self.may:
            self.put(json.dumps({"done": {"request": request}}))
        else:
            self.put(json.dumps({"refused": {"request": request, "why": "this page is read-only"}}))

    def frames(self, request, asked):
        at, sent, newest = 0, set(), {}
        for k in range(asked["count"]):
            until = asked["from_us"] + k * asked["step_us"]
            while at < len(self.double.rows) and self.double.rows[at][0] <= until:
                time, lab, channel, data = self.double.rows[at]
                if channel in asked["channels"]:
                    newest[lab, channel] = (at, time, data)
                at += 1
            for (lab, channel), (row, time, data) in newest.items():
                if row not in sent and (k or time > asked["from_us"] - asked["step_us"]):
                    sent.add(row)
                    self.put(packed(lab, time, channel, data, request))
        self.put(json.dumps({"done": {"request": request}}))
