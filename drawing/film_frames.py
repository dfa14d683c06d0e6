"""A recorded run as pictures of the page, each of a moment of lab time: for films and documents."""
import base64
import contextlib
import pathlib
import re
import subprocess
import time

from chromium import browser
from film_file import moments_of, write
from lab_processes import PROGRAM, Failed, end_all, end_with_parent

READY = "return Boolean(window.arkmesh?.world.labs.length && arkmesh.player.length_us)"
STEP = "const done = arguments[arguments.length - 1]; {}.then((value) => done([null, value]), (error) => done([String(error), null]))"
# Moments that the page encodes before it hands them out.
AT_ONCE = 25


def address_of(said):
    """The address of the page in what a program says, line by line."""
    lines = []
    for line in said:
        lines.append(line)
        if found := re.search(r"see it at (http://\S+)", line):
            return found[1]
    raise Failed(f"the program printed no page address, only: {''.join(lines).strip()}")


@contextlib.contextmanager
def served(runs, program=PROGRAM):
    """The address of the page that shows these run folders."""
    process = subprocess.Popen([program, "view", *map(str, runs)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, preexec_fn=end_with_parent)
    try:
        yield address_of(process.stdout)
    finally:
        end_all([process])
        process.stdout.close()


class Page:
    """The page in a browser, moved from moment to moment."""

    def __init__(self, driver, url, bare):
        self.driver = driver
        address, _, fragment = url.partition("#")
        driver.set_script_timeout(300)
        driver.get(address + ("?bare" if bare else "") + (f"#{fragment}" if fragment else ""))
        end = time.monotonic() + 300
        while not driver.execute_script(READY):
            if time.monotonic() > end:
                raise Failed(f"the page at {address} shows no recorded run")
            time.sleep(0.05)
        self.length_s = driver.execute_script("return arkmesh.player.length_us") / 1e6

    def call(self, expression, *arguments):
        error, value = self.driver.execute_async_script(STEP.replace("{}", expression), *arguments)
        if error:
            raise Failed(f"the page failed: {error}")
        return value

    def begin(self, t_s, speed=0, trail_s=None):
        """Goes to a time; with a speed, pictures have a caption with both. Trails show the last `trail_s` of lab time; None: as the page has it."""
        if trail_s is not None:
            self.driver.execute_script("arkmesh.options.set({shown: {...arkmesh.options.shown, trails: arguments[0] > 0}, trail_s: arguments[0] || arkmesh.options.trail_s})", trail_s)
        self.call("arkmesh.film.begin(arguments[0], arguments[1])", t_s * 1e6, speed)

    def next(self, step_s):
        self.call("arkmesh.film.next(arguments[0])", step_s * 1e6)

    def can_encode(self, per_s):
        """Whether the arenas can be had as H.264."""
        return self.call("arkmesh.film.encoder.begin(arguments[0])", per_s)

    def encoded(self, step_s, count, last):
        """The next moments of the arenas, as bytes of H.264."""
        return base64.b64decode(self.call("arkmesh.film.encoded(arguments[0], arguments[1], arguments[2])", step_s * 1e6, count, last).partition(",")[2])

    def picture(self, kind="jpeg"):
        """What is to be seen now, as a file's bytes."""
        options = {"format": kind} | ({"quality": 95} if kind == "jpeg" else {})
        return base64.b64decode(self.driver.execute_cdp_cmd("Page.captureScreenshot", options)["data"])


@contextlib.contextmanager
def page(url, width, height, bare=False, dark=False):
    with browser(width, height, dark) as driver:
        yield Page(driver, url, bare)


def pictures(shown, moments, step_s, kind):
    """Each moment as a picture of the page, and how many moments there are so far."""
    for i in range(1, moments + 1):
        shown.next(step_s)
        yield i, shown.picture(kind)


def encoded(shown, moments, step_s):
    """Moments of the arenas as H.264, some at once, and how many there are so far."""
    for i in range(0, moments, AT_ONCE):
        now = min(AT_ONCE, moments - i)
        yield i + now, shown.encoded(step_s, now, i + now == moments)


def film(url, out, begin_s, end_s, speed, per_s, width, height, bare, dark=False, trail_s=None, prepare=None):
    """Writes a film (.mp4, or .gif) of that stretch of lab time, under its name only when it is whole. `prepare` is JavaScript to run before the
    first moment."""
    with page(url, width, height, bare, dark) as shown:
        moments, step_s = moments_of(begin_s, min(end_s, shown.length_s), shown.length_s, speed, per_s)
        kind = "png" if pathlib.Path(out).suffix == ".gif" else "jpeg"
        # The page encodes its arenas itself, if this Chromium can; other pictures have to be taken and encoded one by one.
        if bare and kind == "jpeg" and shown.can_encode(per_s):
            drawn, data, how = encoded(shown, moments, step_s), ["h264"], ["-c", "copy", "-movflags", "+faststart"]
        else:
            drawn, data, how = pictures(shown, moments, step_s, kind), ["image2pipe", "-c:v", kind.replace("jpeg", "mjpeg")], None

        def begin():
            shown.begin(max(0, begin_s), speed, trail_s)
            if prepare:
                shown.driver.execute_script(prepare)
        write(out, drawn, moments, per_s, data, how, begin)
    return moments
