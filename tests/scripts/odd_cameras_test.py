"""Cameras and videos as they are met: what a lab's camera serves at each connection is odd in another way, and whole in between. The lab goes on, and
robots stand at its end. Videos that are damaged are read as far as they go; those of a variable rate keep the times that ffprobe tells."""
import contextlib
import csv
import io
import json
import random
import re
import shutil
import socket
import struct
import subprocess
import threading
import time
import unittest
import urllib.request

import PIL.Image

from emulated_lab import EmulatedLab
from lab_processes import PROGRAM, ROOT

HEAD = b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=frame\r\n\r\n"
CLIP = ROOT / "tests/data/kilobot-images/bodyguard_clip.mp4"


def part(jpeg, length=None, kind=b"image/jpeg"):
    return b"--frame\r\nContent-Type: %s\r\nContent-Length: %d\r\n\r\n%s\r\n" % (kind, len(jpeg) if length is None else length, jpeg)


def again(jpeg, change=lambda image: image, kind="JPEG", **how):
    """The picture, changed and encoded otherwise."""
    out = io.BytesIO()
    change(PIL.Image.open(io.BytesIO(jpeg))).save(out, kind, **how)
    return out.getvalue()


def says_size(jpeg, pixels):
    """The picture with another size in its head."""
    at = re.search(b"\xff[\xc0\xc2]..\x08", jpeg, re.S).end()
    return jpeg[:at] + struct.pack(">HH", pixels, pixels) + jpeg[at + 4:]


def chunked(data):
    return b"%x\r\n%s\r\n" % (len(data), data)


def exif_turned(image):
    image.getexif()[0x112] = 6
    return image


def stream(of, head=HEAD):
    """A camera: `of` makes what it sends of the i-th picture."""
    def serve(client, newest):
        client.sendall(head)
        for i in range(12):
            client.sendall(of(newest(), i))
            time.sleep(0.1)
    return serve


def reply(status, *lines):
    return lambda client, newest: client.sendall(f"HTTP/1.1 {status}\r\n".encode() + b"".join(line + b"\r\n" for line in lines) + b"Content-Length: 0\r\n\r\n")


def drip(of, seconds):
    """Byte by byte, until whoever waits gives up."""
    def serve(client, newest):
        for byte in of(newest):
            client.sendall(bytes([byte]))
            time.sleep(seconds)
    return serve


def hold(of):
    """Nothing after that, until the other side closes."""
    def serve(client, newest):
        client.sendall(of(newest))
        client.recv(1)
    return serve


def flood(before, data):
    def serve(client, newest):
        client.sendall(before)
        for _ in range(4000):
            client.sendall(data)
            time.sleep(0.002)
    return serve


def reset(client, newest):
    client.sendall(HEAD + part(newest())[:1000])
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def blank(pixels):
    out = io.BytesIO()
    PIL.Image.new("L", (pixels, pixels)).save(out, "JPEG")
    return out.getvalue()


HUGE = blank(9000)
NOISE = random.Random(1).randbytes(30_000)
# what the camera does : how
ODD = {
    "a slow head": drip(lambda newest: HEAD, 0.3),
    "a byte a second": drip(lambda newest: HEAD + part(newest()), 1),
    "no boundary": stream(lambda jpeg, i: part(jpeg), HEAD.replace(b"; boundary=frame", b"")),
    "no lengths": stream(lambda jpeg, i: b"--frame\r\n\r\n" + jpeg),
    "lengths too long": stream(lambda jpeg, i: part(jpeg, 2 * len(jpeg))),
    "lengths too short": stream(lambda jpeg, i: part(jpeg, 10)),
    "lengths that are none": stream(lambda jpeg, i: part(jpeg, -7)),
    "a length of 4 GB": hold(lambda newest: HEAD + part(b"\xff\xd8\xff", 4_294_967_290)),
    "chunks": stream(lambda jpeg, i: chunked(part(jpeg)), HEAD.replace(b"\r\n\r\n", b"\r\nTransfer-Encoding: chunked\r\n\r\n")),
    "an endless head": flood(b"HTTP/1.1 200 OK\r\n", b"X-Camera: yes\r\n" * 100),
    "an endless head of a part": flood(HEAD + b"--frame\r\n", b"X-Camera: yes\r\n" * 100),
    "nothing": hold(lambda newest: b""),
    "nothing after the head": hold(lambda newest: HEAD),
    "silence after one picture": hold(lambda newest: HEAD + part(newest())),
    "silence within a picture": hold(lambda newest: HEAD + part(newest())[:2000]),
    "a connection that is reset": reset,
    "a redirection to itself": reply("302 Found", b"Location: /cam"),
    "401": reply("401 No", b'WWW-Authenticate: Basic realm="cam"'),
    "404": reply("404 Not Found"),
    "500": reply("500 No"),
    "a web page": lambda client, newest: client.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: text/html\r\n\r\n<html></html>"),
    "no HTTP": lambda client, newest: client.sendall(b"220 camera FTP server ready\r\n"),
    "noise": stream(lambda jpeg, i: NOISE),
    "noise between pictures": stream(lambda jpeg, i: part(NOISE if i % 2 else jpeg)),
    "a video that is cut": lambda client, newest: client.sendall(b"HTTP/1.1 200 OK\r\nContent-Type: video/mp4\r\n\r\n" + CLIP.read_bytes()[:90_000]),
    "empty parts": stream(lambda jpeg, i: part(b"")),
    "PNG": stream(lambda jpeg, i: part(again(jpeg, kind="PNG"), kind=b"image/png")),
    "progressive JPEG": stream(lambda jpeg, i: part(again(jpeg, progressive=True))),
    "CMYK": stream(lambda jpeg, i: part(again(jpeg, lambda image: image.convert("CMYK")))),
    "grey": stream(lambda jpeg, i: part(again(jpeg, lambda image: image.convert("L")))),
    "cut pictures": stream(lambda jpeg, i: part(jpeg[:len(jpeg) // (1 + i % 3)])),
    "formats in turn": stream(lambda jpeg, i: part(again(jpeg, subsampling=i % 3))),
    "sizes in turn": stream(lambda jpeg, i: part(again(jpeg, lambda image: image.resize((320 + 32 * i, 240))))),
    "pictures turned": stream(lambda jpeg, i: part(again(jpeg, lambda image: image.rotate(90, expand=True)))),
    "a note that they are turned": stream(lambda jpeg, i: part(again(jpeg, exif_turned))),
    "pictures of 81 million pixels": stream(lambda jpeg, i: part(HUGE)),
    "a size that is a lie": stream(lambda jpeg, i: part(says_size(jpeg, 65_535 if i % 2 else 8000))),
}


class OddCamera:
    """In front of a camera, at the address `url`: its pictures as they are until `odd` is set, then at every other connection one of the table."""

    def __init__(self, behind):
        self.behind, self.picture, self.odd, self.survived = behind, b"", threading.Event(), []
        self.server = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self.server.getsockname()[1]}/cam"
        for work in (self.look, self.serve):
            threading.Thread(target=work, daemon=True).start()

    def look(self):
        with urllib.request.urlopen(self.behind) as pictures:
            while line := pictures.readline():
                if line.lower().startswith(b"content-length:"):
                    pictures.readline()
                    self.picture = pictures.read(int(line.split(b":")[1]))

    def newest(self):
        while not self.picture:
            time.sleep(0.01)
        return self.picture

    def serve(self):
        left, tried = list(ODD), None
        while True:
            client, _ = self.server.accept()
            with client, contextlib.suppress(OSError):
                client.settimeout(60)
                client.recv(2000)
                if self.odd.is_set() and left and tried is None:
                    tried = left.pop(0)
                    ODD[tried](client, self.newest)
                    continue
                client.sendall(HEAD)
                while not (self.odd.is_set() and left and tried is None):
                    for _ in range(10):
                        client.sendall(part(self.newest()))
                        time.sleep(0.1)
                    if tried is not None:
                        self.survived.append(tried)
                        tried = None


class OddCameras(EmulatedLab):
    def stand(self):
        done = subprocess.run([PROGRAM, "pause", self.folder / "lab.toml"], capture_output=True, text=True, timeout=300)
        self.assertIn(done.returncode, (0, 4), done.stderr)
        return done.returncode == 0

    def test_lab(self):
        camera = None

        def before(url):
            nonlocal camera
            camera = OddCamera(url)
            return camera.url
        self.begin(before)
        camera.odd.set()
        for number, name in enumerate(ODD):
            self.until(300, lambda: len(camera.survived) > number, f"a whole stream after {name}")
        self.until(300, self.stand, "that robots are named anew, and seen to stand")
        code, result = self.end_lab()
        self.assertEqual(code, 3, self.said("lab")[-1500:])  # ended by its operator, and robots were seen to stand
        for name in ("camera.gone", "camera.refused.damaged", "camera.refused.changed"):
            self.assertGreater(result["counters"].get(f"arena.{name}", 0), 0, f"{name} of {result['counters']}")
        for sentence in ("does not answer", "is connected and sends no pictures", "has ended its stream", "(404)", "(5xx)", "is a web page", "now sends pictures of"):
            self.assertIn(sentence, self.said("lab"))


def noise_in(data, at=0.5):
    """2 kB of the file are noise."""
    at = int(len(data) * at)
    return data[:at] + NOISE[:2000] + data[at + 2000:]


def without_rate(data):
    """An AVI whose heads tell of no time between pictures."""
    main, stream = data.index(b"avih") + 8, data.index(b"strh") + 8
    data = bytearray(data)
    data[main:main + 4] = data[stream + 24:stream + 28] = bytes(4)
    return bytes(data)


# a file's name : how it is made of those that are whole
VIDEOS = {
    "nothing.mp4": lambda whole: b"",
    "words.mkv": lambda whole: b"no pictures at all, but words\n" * 50,
    "no_index.mp4": lambda whole: whole["mp4"][:len(whole["mp4"]) // 2],
    "cut.mkv": lambda whole: whole["mkv"][:len(whole["mkv"]) // 2],
    "cut.avi": lambda whole: whole["avi"][:len(whole["avi"]) // 2],
    "cut.ts": lambda whole: whole["ts"][:len(whole["ts"]) // 2],
    "no_head.mkv": lambda whole: whole["mkv"][3000:],
    "noise.mp4": lambda whole: noise_in(whole["mp4"]),
    "noise.mkv": lambda whole: noise_in(whole["mkv"]),
    "noise.avi": lambda whole: noise_in(whole["avi"]),
    "noise.ts": lambda whole: noise_in(whole["ts"]),
    "noise_in_head.avi": lambda whole: noise_in(whole["avi"], 0),
    "no_rate.avi": lambda whole: without_rate(whole["avi"]),
    "times_go_back.ts": lambda whole: whole["ts"] + whole["ts"],
    "times_stand_still.mkv": lambda whole: whole["same.mkv"],
    "size_changes.ts": lambda whole: whole["ts"] + whole["small.ts"],
    "one_picture.mjpeg": lambda whole: whole["mjpeg"],
    "sound.mp4": lambda whole: whole["m4a"],
}
# of them, all pictures are there
WHOLE = ("noise_in_head.avi", "no_rate.avi", "one_picture.mjpeg")


@unittest.skipUnless(shutil.which("ffmpeg") and shutil.which("ffprobe"), "ffmpeg makes the videos, and it is not installed")
class OddVideos(EmulatedLab):
    def ffmpeg(self, *words):
        file = self.folder / words[-1]
        subprocess.run(["ffmpeg", "-v", "error", "-y", *words[:-1], file], check=True, timeout=300)
        return file

    def track(self, file):
        """Exit code, what was said, and the time of each picture in which robots were seen, by its number."""
        rows = self.folder / "rows.csv"
        rows.unlink(missing_ok=True)
        done = subprocess.run([PROGRAM, "track", file, "--csv", rows], capture_output=True, text=True, errors="replace", timeout=300)
        times = {int(row["frame"]): float(row["time_s"]) for row in csv.DictReader(rows.read_text().splitlines())} if rows.exists() else {}
        return done.returncode, done.stderr, times

    def test_damage(self):
        clip = ("-i", CLIP, "-t", "1.5")
        whole = {name: self.ffmpeg(*words, f"whole.{name}").read_bytes() for name, words in {
            "mp4": (*clip, "-c", "copy"), "mkv": (*clip, "-c", "copy"), "ts": clip, "avi": (*clip, "-c:v", "mjpeg"),
            "small.ts": (*clip, "-s", "640x360"), "same.mkv": (*clip, "-c:v", "mjpeg", "-bsf:v", "setts=ts=0"), "mjpeg": (*clip, "-frames:v", "1"), "m4a": ("-f", "lavfi", "-i", "sine", "-t", "1")}.items()}
        for name, make in VIDEOS.items():
            with self.subTest(name):
                file = self.folder / name
                file.write_bytes(make(whole))
                code, said, times = self.track(file)
                self.assertIn(code, (0, 1), said)
                self.assertEqual(code == 0, name in WHOLE, said)
                self.assertTrue(code == 0 or name in said, said)
                self.assertEqual(sorted({*times.values()}), list(times.values()))

    def test_variable_rate(self):
        """Every picture of five containers is within 5 ms of the time that ffprobe tells."""
        odd = "select='not(eq(mod(n,7),3))*not(eq(mod(n,11),5))',settb=1/1000,setpts='PTS+13*sin(N)'"
        for name, coder in (("v.mp4", "h264"), ("v.mkv", "h264"), ("v.mov", "mjpeg"), ("v.ts", "h264"), ("v.webm", "vp8")):
            file = self.ffmpeg("-i", CLIP, "-t", "3", "-vf", odd, "-enc_time_base", "1:1000", "-vsync", "passthrough", "-c:v", coder, name)
            told = json.loads(subprocess.run(["ffprobe", "-v", "error", "-select_streams", "v", "-show_entries", "frame=best_effort_timestamp_time", "-of", "json", file],
                                             check=True, capture_output=True, timeout=300).stdout)["frames"]
            told = [float(frame["best_effort_timestamp_time"]) for frame in told]
            _, said, times = self.track(file)
            steps = {round(1000 * (b - a)) for a, b in zip(told, told[1:])}
            self.assertGreater(len(steps), 10, "the rate does not vary")
            self.assertEqual(len(times), len(told), said)
            self.assertLess(max(abs(time - (told[number] - told[0])) for number, time in times.items()), 0.005, name)


if __name__ == "__main__":
    unittest.main()
