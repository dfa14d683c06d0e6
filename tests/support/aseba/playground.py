"""Aseba's own simulator on a screen of its own, a camera above it that sees its robots' markers, and their true poses over D-Bus. For Debian 12, in a
network namespace: the simulator listens on all addresses."""
import contextlib
import http.server
import math
import os
import pathlib
import shutil
import subprocess
import threading
import time

PROGRAMS = "asebaplayground", "asebamassloader", "asebaswitch", "Xvfb", "dbus-daemon", "localedef"
SERVICE = "ch.epfl.mobots.AsebaPlayground"
MARKER_M, CAMERA_M = 0.06, 2.0
WORLD = """<!DOCTYPE aseba-playground>
<aseba-playground>
<author name="" email=""/><description lang="en"></description>
<color name="grey" r="0.8" g="0.8" b="0.8"/>
<world w="{side}" h="{side}" color="grey"/>
{robots}
</aseba-playground>
"""
MAKES = {"thymio2": ("AsebaThymio2", 0.053), "e-puck": ("EPuck", 0.05)}  # how the world's file names them: their name on D-Bus, their height in metres
ROBOT = '<robot type="{make}" x="{x}" y="{y}" angle="{angle}" port="{port}" name="{name}" nodeId="{name}"/>'
CALIBRATION = """%YAML:1.0
---
cameras:
   -
      name: "top"
      lens: "pinhole"
      image_width: {px}
      image_height: {px}
      camera_matrix: !!opencv-matrix
         rows: 3
         cols: 3
         dt: d
         data: [ {focal}, 0., {middle}, 0., {focal}, {middle}, 0., 0., 1. ]
      distortion_coefficients: !!opencv-matrix
         rows: 1
         cols: 5
         dt: d
         data: [ 0., 0., 0., 0., 0. ]
      rotation: !!opencv-matrix
         rows: 3
         cols: 3
         dt: d
         data: [ 1., 0., 0., 0., -1., 0., 0., 0., -1. ]
      translation: !!opencv-matrix
         rows: 3
         cols: 1
         dt: d
         data: [ 0., 0., {height} ]
      arena_width_m: {side}
      arena_height_m: {side}
"""


def lacking():
    """Why none can be had here, or nothing."""
    for name in PROGRAMS:
        if not shutil.which(name):
            return f"{name} is not installed (scripts/setup test installs it on Debian 12)"
    if not pathlib.Path("/usr/share/i18n/locales/en_US").exists():
        return "locales is not installed (scripts/setup test installs it on Debian 12)"
    try:
        import cv2  # noqa: F401
        import dbus  # noqa: F401
    except ImportError as error:
        return f"{error.name} is not installed (scripts/setup test installs it on Debian 12)"
    return ""


class Playground:
    """`poses`: (x, y, heading) in metres and radians from the arena's middle, of robots 1, 2 and so on. Robot i listens on port first_port + i."""

    def __init__(self, folder, side_m, poses, first_port=34000, px=1100, make="thymio2"):
        import cv2
        self.folder, self.side_m, self.first_port, self.px = pathlib.Path(folder), side_m, first_port, px
        self.count = len(poses)
        self.type, self.top_m = MAKES[make]
        self.focal = px / side_m * CAMERA_M * 0.97
        self.history = []  # (monotonic time, {robot: pose})
        self.newest = {}
        self.processes, self.ended = [], threading.Event()
        family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
        # 8 squares across and a white border of one
        self.markers = {i + 1: cv2.cvtColor(cv2.copyMakeBorder(cv2.aruco.drawMarker(family, i + 1, 64), 8, 8, 8, 8, cv2.BORDER_CONSTANT, value=255),
                                            cv2.COLOR_GRAY2BGR) for i in range(self.count)}
        robots = [ROBOT.format(make=make, x=100 * (x + side_m / 2), y=100 * (y + side_m / 2), angle=angle, port=first_port + i, name=i)
                  for i, (x, y, angle) in enumerate(poses, 1)]
        (self.folder / "world.playground").write_text(WORLD.format(side=100 * side_m, robots="\n".join(robots)))
        self.calibration = self.folder / "camera.yaml"
        self.calibration.write_text(CALIBRATION.format(px=px, focal=self.focal, middle=px / 2, height=CAMERA_M, side=side_m))
        self.environment = {**os.environ, "DBUS_SESSION_BUS_ADDRESS": f"unix:path={self.folder}/bus"}

    def __enter__(self):
        try:
            self.start_all()
        except BaseException:
            self.end()
            raise
        return self

    def __exit__(self, *_):
        self.end()

    def end(self):
        self.ended.set()
        for process in reversed(self.processes):
            process.kill()
            process.wait()
        if server := getattr(self, "server", None):
            server.shutdown()
            server.server_close()

    def start(self, name, *command, **more):
        with open(self.folder / f"{name}.txt", "wb") as said:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=said, env=self.environment, **more)
        self.processes.append(process)
        return process

    def start_all(self):
        reader, writer = os.pipe()
        self.start("screen", "Xvfb", "-displayfd", str(writer), "-screen", "0", "320x240x24", pass_fds=[writer])
        os.close(writer)
        with open(reader) as display:
            self.environment["DISPLAY"] = ":" + display.readline().strip()
        self.start("bus", "dbus-daemon", "--session", "--nofork", f"--address={self.environment['DBUS_SESSION_BUS_ADDRESS']}")
        until(10, (self.folder / "bus").exists, "the D-Bus")
        self.start("playground", "asebaplayground", self.folder / "world.playground")
        threading.Thread(target=self.read_poses, daemon=True).start()
        until(60, lambda: len(self.newest) == self.count, "the playground's robots on D-Bus")
        self.server = Camera(("127.0.0.1", 0), CameraHandler)
        self.server.playground = self
        self.camera = f"http://127.0.0.1:{self.server.server_port}/"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def read_poses(self):
        """What robots there are does not change; which of them is which tell their first places, for the world's file has their order."""
        import dbus
        bus = robots = None
        while not self.ended.is_set():
            with contextlib.suppress(dbus.exceptions.DBusException):
                if not robots:
                    bus = bus or dbus.bus.BusConnection(self.environment["DBUS_SESSION_BUS_ADDRESS"])
                    world = dbus.Interface(bus.get_object(SERVICE, "/world"), "ch.epfl.mobots.EnkiWorld")
                    names = list(world.PhysicalObjectsByType(self.type))
                    if len(names) == self.count:
                        robots = [dbus.Interface(bus.get_object(SERVICE, world.PhysicalObject(name)), "org.freedesktop.DBus.Properties") for name in names]
                else:
                    seen = [robot.GetAll("ch.epfl.mobots.EnkiPhysicalObject") for robot in robots]
                    self.newest = {i: (float(one["x"]) / 100 - self.side_m / 2, float(one["y"]) / 100 - self.side_m / 2, float(one["angle"]))
                                   for i, one in enumerate(seen, 1)}
                    self.history.append((time.monotonic(), self.newest))
            time.sleep(0.04)

    def picture(self):
        import cv2
        import numpy
        out = numpy.full((self.px, self.px, 3), 190, numpy.uint8)
        size = 80  # pixels of a marker's picture
        px_per_m = self.focal / (CAMERA_M - self.top_m)
        for robot, (x, y, angle) in self.newest.items():
            scale = px_per_m * MARKER_M / 64
            turn = cv2.getRotationMatrix2D(((size - 1) / 2, (size - 1) / 2), math.degrees(angle) - 90, scale)  # its top is its front
            to = self.px / 2 + px_per_m * x, self.px / 2 - px_per_m * y
            reach = math.ceil(scale * size * 0.75)
            left, top = (max(0, int(at) - reach) for at in to)
            right, bottom = (min(self.px, int(at) + reach) for at in to)
            turn[0, 2] += to[0] - left - (size - 1) / 2
            turn[1, 2] += to[1] - top - (size - 1) / 2
            part = out[top:bottom, left:right]
            drawn = cv2.warpAffine(self.markers[robot], turn, (right - left, bottom - top), flags=cv2.INTER_AREA)
            inside = cv2.warpAffine(numpy.full((size, size), 255, numpy.uint8), turn, (right - left, bottom - top)) > 127
            part[inside] = drawn[inside]
        return cv2.imencode(".jpg", out, [cv2.IMWRITE_JPEG_QUALITY, 90])[1].tobytes()

    def load(self, program, port, robot, nodes=1):
        """Loads a robot's program over a port that leads to so many nodes, as users do."""
        locales = self.folder / "locales"
        if not locales.exists():  # asebamassloader ends without this one
            locales.mkdir()
            subprocess.run(["localedef", "-i", "en_US", "-f", "UTF-8", locales / "en_US.UTF-8"], capture_output=True, check=True)
        own, said = self.folder / "own.aesl", self.folder / f"load_{robot}.txt"
        own.write_text(program.read_text().replace('nodeId="1"', f'nodeId="{robot}"'))
        with open(said, "wb") as out:
            loader = subprocess.Popen(["asebamassloader", own, f"tcp:127.0.0.1;{port}"], stdout=out, stderr=out,
                                      env={**self.environment, "LOCPATH": str(locales), "LC_ALL": "en_US.UTF-8"})
        try:  # it loads, or fails to, at each node that it meets
            until(20, lambda: said.read_bytes().count(b"bytecodes loaded") + said.read_bytes().count(b"error") >= nodes, f"loading robot {robot}")
        finally:
            loader.kill()
            loader.wait()

    def moved_last(self, robot, by_m=0.002):
        """When it was last so far from where it is."""
        here = self.newest[robot]
        return next((when for when, poses in reversed(self.history) if math.dist(poses[robot][:2], here[:2]) > by_m), 0.0)

    def speed(self, robot, seconds=0.5):
        """Metres a second, over the newest samples."""
        end, new = self.history[-1]
        begin, old = next((when, poses) for when, poses in reversed(self.history) if when <= end - seconds or when == self.history[0][0])
        return math.dist(new[robot][:2], old[robot][:2]) / max(end - begin, 1e-3)


def until(seconds, condition, what, fails=AssertionError):
    end = time.monotonic() + seconds
    while not (found := condition()):
        if time.monotonic() > end:
            raise fails(f"{what}: not within {seconds} s")
        time.sleep(0.05)
    return found


class Camera(http.server.ThreadingHTTPServer):
    daemon_threads = True


class CameraHandler(http.server.BaseHTTPRequestHandler):
    def log_message(self, *_):
        pass

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        self.end_headers()
        with contextlib.suppress(OSError):
            while not self.server.playground.ended.is_set():
                jpeg = self.server.playground.picture()
                self.wfile.write(b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n%s\r\n" % (len(jpeg), jpeg))
                time.sleep(0.08)
