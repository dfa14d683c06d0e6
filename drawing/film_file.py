"""Pictures to a film: ffmpeg encodes them, and the film has its name only when it is whole."""
import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "scripts"))  # where arkmesh is not installed
from lab_processes import PROGRAM, Failed  # noqa: F401


def moments_of(begin_s, end_s, length_s, speed, per_s):
    """How many pictures that stretch of lab time has, and lab seconds from one to the next."""
    if begin_s >= end_s:
        raise Failed(f"nothing to film: the run ends at {length_s:g} s, and the film would begin at {begin_s:g} s")
    return max(1, round((end_s - begin_s) / speed * per_s)), speed / per_s


def draw(drawn, to, moments):
    """Writes what is drawn to ffmpeg, and tells how far it is; ends early when ffmpeg has gone, having said why."""
    begun = told = time.monotonic()
    with contextlib.suppress(BrokenPipeError):
        for i, data in drawn:
            to.write(data)
            if (now := time.monotonic()) - told > (1 if sys.stderr.isatty() else 10):
                told = now
                print(f"film: {i} of {moments} pictures, {(now - begun) / i * (moments - i):.0f} s left  ", file=sys.stderr,
                      end="\r" if sys.stderr.isatty() else "\n", flush=True)
        to.close()


def write(out, drawn, moments, per_s, data, how=None, begin=lambda: None):
    """Writes a film (.mp4, or .gif) of what is `drawn`, pairs of how many moments there are so far and their bytes, which ffmpeg reads as `data`. `begin`
    is called first."""
    out = pathlib.Path(out)
    part = out.with_name(f"{out.name}.{os.getpid()}.part")
    # Half as many colours as a GIF may have: much smaller, and nobody sees it. The encoder's fastest setting that costs no bytes.
    how = how or (["-filter_complex", "split[a][b];[a]palettegen=max_colors=96:stats_mode=full[p];[b][p]paletteuse=dither=none:diff_mode=rectangle", "-loop", "0"]
                  if out.suffix == ".gif" else ["-c:v", "libx264", "-preset", "veryfast", "-pix_fmt", "yuv420p", "-crf", "21", "-movflags", "+faststart", "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2"])
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", *data, "-framerate", str(per_s), "-i", "-", *how, "-f", out.suffix[1:], str(part)]
    try:
        # Ctrl-C is for us; a film that is stopped is taken away
        with tempfile.TemporaryFile("w+") as said, subprocess.Popen(command, stdin=subprocess.PIPE, stderr=said, start_new_session=True) as encoder:
            try:
                begin()
                draw(drawn, encoder.stdin, moments)
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
