"""A recorded run as pictures of the page, each of a moment of lab time: for films and documents."""
import base64
import contextlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

from chromium import browser
from lab_processes import PROGRAM, Failed, end_with_parent

READY = "return Boolean(window.arkmesh?.world.labs.length && arkmesh.player.length_us)"
STEP = "const done = arguments[arguments.length - 1]; {}.then(() => done(null), (error) => done(String(error)))"


def address_of(said):
    """The address of the page in what a program says, line by line."""
    lines = []
    for line in said:
        lines.append(line)
        if found := re.search(r"see it at (http://\S+)", line):
            return found[1]
    raise Failed(f"no address of a page was told, only: {''.join(lines).strip()}")


@contextlib.contextmanager
def served(runs, program=PROGRAM):
    """The address of the page that shows these run folders."""
    process = subprocess.Popen([program, "view", *map(str, runs)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, preexec_fn=end_with_parent)
    try:
        yield address_of(process.stdout)
    finally:
        process.terminate()
        process.wait(10)
        process.stdout.close()


class Page:
    """The page in a browser, moved from moment to moment."""

    def __init__(self, driver, url, bare):
        self.driver = driver
        address, _, fragment = url.partition("#")
        driver.set_script_timeout(60)
        driver.get(address + ("?bare" if bare else "") + (f"#{fragment}" if fragment else ""))
        end = time.monotonic() + 30
        while not driver.execute_script(READY):
            if time.monotonic() > end:
                raise Failed(f"the page at {address} shows no recorded run")
            time.sleep(0.05)
        self.length_s = driver.execute_script("return arkmesh.player.length_us") / 1e6

    def call(self, expression, *arguments):
        if error := self.driver.execute_async_script(STEP.replace("{}", expression), *arguments):
            raise Failed(f"the page failed: {error}")

    def begin(self, t_s):
        self.call("arkmesh.film.begin(arguments[0])", t_s * 1e6)

    def next(self, step_s):
        self.call("arkmesh.film.next(arguments[0])", step_s * 1e6)

    def picture(self, kind="jpeg"):
        """What is to be seen now, as a file's bytes."""
        options = {"format": kind} | ({"quality": 95} if kind == "jpeg" else {})
        return base64.b64decode(self.driver.execute_cdp_cmd("Page.captureScreenshot", options)["data"])


@contextlib.contextmanager
def page(url, width, height, bare=False, dark=False):
    with browser(width, height, dark) as driver:
        yield Page(driver, url, bare)


def draw(shown, to, moments, step_s, kind):
    """Writes one picture after the other to an encoder, and tells how far it is; ends early when the encoder has gone, having said why."""
    begun = told = time.monotonic()
    with contextlib.suppress(BrokenPipeError):
        for i in range(1, moments + 1):
            shown.next(step_s)
            to.write(shown.picture(kind))
            if (now := time.monotonic()) - told > (1 if sys.stderr.isatty() else 10):
                told = now
                print(f"film: {i} of {moments} pictures, {(now - begun) / i * (moments - i):.0f} s left  ", file=sys.stderr,
                      end="\r" if sys.stderr.isatty() else "\n", flush=True)
        to.close()


def film(url, out, begin_s, end_s, speed, per_s, width, height, bare, dark=False, prepare=None):
    """Writes a film (.mp4, or .gif) of that stretch of lab time, under its name only when it is whole. `prepare` is JavaScript to run before the
    first moment."""
    out = pathlib.Path(out)
    part = out.with_name(f"{out.name}.{os.getpid()}.part")
    # Half as many colours as a GIF may have: much smaller, and nobody sees it.
    how = (["-filter_complex", "split[a][b];[a]palettegen=max_colors=96:stats_mode=full[p];[b][p]paletteuse=dither=none:diff_mode=rectangle", "-loop", "0"]
           if out.suffix == ".gif" else ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "21", "-movflags", "+faststart", "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2"])
    with page(url, width, height, bare, dark) as shown:
        end_s = min(end_s, shown.length_s)
        if begin_s >= end_s:
            raise Failed(f"nothing to film: the run ends at {shown.length_s:g} s, and the film would begin at {begin_s:g} s")
        command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "image2pipe", "-c:v", "mjpeg" if out.suffix != ".gif" else "png", "-framerate", str(per_s), "-i", "-", *how, "-f", out.suffix[1:], str(part)]
        moments = max(1, round((end_s - begin_s) / speed * per_s))
        try:
            # Ctrl-C is for us; a film that is stopped is taken away
            with tempfile.TemporaryFile("w+") as said, subprocess.Popen(command, stdin=subprocess.PIPE, stderr=said, start_new_session=True) as encoder:
                try:
                    shown.begin(max(0, begin_s))
                    if prepare:
                        shown.driver.execute_script(prepare)
                    draw(shown, encoder.stdin, moments, speed / per_s, "png" if out.suffix == ".gif" else "jpeg")
                except BaseException:
                    encoder.kill()
                    raise
                encoder.wait()
                said.seek(0)
                # on a full disk it may end with 0
                if (words := said.read().strip()) or encoder.returncode:
                    raise Failed(f"{out} cannot be written: {words.splitlines()[-1] if words else f'ffmpeg ended with {encoder.returncode}'}")
            os.replace(part, out)
        finally:
            part.unlink(missing_ok=True)
    return moments
