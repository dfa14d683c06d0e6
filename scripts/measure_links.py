"""Figures of gateways as real processes: what a peer costs in a mesh, what poses take on the wire, what an idle gateway holds. See scripts/measure."""
import contextlib
import ctypes
import os
import pathlib
import random
import re
import selectors
import shutil
import socket
import struct
import subprocess
import time

import read_log
from campaign_network import GROUP, say
from joined_networks import call, join_by_tls, joined_networks
from lab_processes import PROGRAM, Failed, end_all, end_with_parent

FIRST_BUS, FIRST_PORT, RATE_HZ, NUMBER_AT = 7720, 7840, 10, 16
CLONE_NEWNET, SO_RCVBUFFORCE = 0x40000000, 33
FILE_TEXT = """[lab]
name = "{lab}"
[bus]
url = "udpm://239.255.76.67:{bus}?ttl=0&recv_buf_size=4194304"
[run]
scenario = "dhtf"
[shared]
labs = {labs}
[gateway]
exports = []
ordered = ["poses"]
imports = ["poses"]
"""


def pose_frame(robots):
    """A message of channel `poses` with that many robots at random places."""
    poses = [read_log.new("robot_pose_t", robot=robot, x_m=random.uniform(-1, 1), y_m=random.uniform(-1, 1), heading_rad=random.uniform(-3, 3), led=2,
                          confidence=1.0, age_us=random.randrange(100000)) for robot in range(robots)]
    return bytearray(read_log.new("pose_frame_t", stamp_us=0, number=0, part=0, parts=1, robots=poses).encode())


@contextlib.contextmanager
def inside(words):
    """This thread is in the network namespace that `nsenter` would enter with these words; {} leaves it where it is."""
    if not words:
        yield
        return
    libc = ctypes.CDLL(None, use_errno=True)
    home, there = os.open("/proc/thread-self/ns/net", os.O_RDONLY), os.open(f"/proc/{words[2]}/ns/net", os.O_RDONLY)
    try:
        if libc.setns(there, CLONE_NEWNET) != 0:
            raise Failed("a network namespace cannot be entered")
        yield
    finally:
        libc.setns(home, CLONE_NEWNET)
        os.close(there)
        os.close(home)


class Talkers:
    """Labs in this process: each sends `poses` on its bus ten times a second, and notes by number what it hears of the others'."""

    def __init__(self, labs, robots, enter=None):
        self.labs, self.frame, self.number, self.came = labs, pose_frame(robots), 0, {}
        self.selector, self.mouths = selectors.DefaultSelector(), {}
        for lab, bus in labs.items():
            with inside((enter or {}).get(lab)):
                self.mouths[lab] = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                try:
                    ear.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 8 << 20)
                except PermissionError:
                    ear.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8 << 20)
                ear.bind((GROUP, bus))
                ear.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, struct.pack("4s4s", socket.inet_aton(GROUP), socket.inet_aton("127.0.0.1")))
            ear.setblocking(False)
            self.selector.register(ear, selectors.EVENT_READ, lab)

    def hear(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            for key, _ in self.selector.select(left):
                with contextlib.suppress(BlockingIOError):
                    while True:
                        self.note(key.data, key.fileobj.recv(1 << 16))

    def note(self, lab, datagram):
        channel, _, data = datagram[8:].partition(b"\0")
        if channel.endswith(b"/poses"):
            self.came.setdefault((channel[:-6].decode(), lab), []).append(struct.unpack_from(">i", data, NUMBER_AT)[0])

    def talk(self, seconds):
        """Ten frames a second; returns the first and the last number."""
        first, due = self.number + 1, time.monotonic()
        for _ in range(round(seconds * RATE_HZ)):
            self.number += 1
            struct.pack_into(">i", self.frame, NUMBER_AT, self.number)
            for lab, bus in self.labs.items():
                say(self.mouths[lab], bus, self.number, "poses", bytes(self.frame))
            due += 1 / RATE_HZ
            self.hear(max(0.001, due - time.monotonic()))
        return first, self.number

    def until_joined(self, patience_s=120):
        """Until each has heard each."""
        end, wanted = time.monotonic() + patience_s, len(self.labs) * (len(self.labs) - 1)
        while len(self.came) < wanted:
            if time.monotonic() > end:
                raise Failed(f"{wanted - len(self.came)} of {wanted} ways of the mesh carry nothing after {patience_s} s")
            self.talk(0.5)

    def lost(self, first, last):
        """How many of these numbers did not come, or not once and in order, on all ways together; waits for the last."""
        end = time.monotonic() + 300
        while any(way[-1] < last for way in self.came.values()) and time.monotonic() < end:
            self.hear(0.1)
        wrong = 0
        for way in self.came.values():
            numbers = [number for number in way if number >= first]
            wrong += 0 if numbers == list(range(first, last + 1)) else max(1, last - first + 1 - len(set(numbers)))
        return wrong


def cpu_s(process):
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(process):
    """Resident, and private of it."""
    text = pathlib.Path(f"/proc/{process.pid}/smaps_rollup").read_text()
    return tuple(sum(map(int, re.findall(rf"^{name}:\s+(\d+)", text, re.M))) / 1024 for name in ("Rss", "Private_(?:Clean|Dirty)"))


@contextlib.contextmanager
def gateways(files, folder, enter=None, sets=None):
    """{lab: process}"""
    running = {}
    try:
        for lab, file in files.items():
            with open(folder / f"{lab}.txt", "wb") as said:
                more = [part for each in (sets or {}).get(lab, []) for part in ("--set", each)]
                running[lab] = subprocess.Popen([*(enter or {}).get(lab, []), PROGRAM, "gateway", file, *more], stdin=subprocess.DEVNULL, stdout=said, stderr=said,
                                                preexec_fn=end_with_parent)
        yield running
        for lab, process in running.items():
            if process.poll() is not None:
                raise Failed(f"the gateway of {lab} has ended: {(folder / f'{lab}.txt').read_text().strip()[-200:]}")
    finally:
        end_all(running.values())


def mesh(folder, number, tls, seconds):
    """Labs that are all joined with each other: (ways with a loss, CPU per cent of a core, resident MB, private MB), each of a gateway's mean."""
    folder.mkdir(parents=True)
    labs = {f"lab{index:02}": FIRST_BUS + index for index in range(number)}
    names, files, kind = list(labs), {}, "tls://" if tls else ""
    if tls:
        for lab in names:
            call(PROGRAM, "keys", "init", lab, "--keys", folder / "keys" / lab)
        for lab in names:
            (folder / "keys" / lab / "trusted").mkdir(exist_ok=True)
            for other in names:
                if other != lab:
                    shutil.copy(folder / "keys" / other / f"{other}.crt", folder / "keys" / lab / "trusted")
    for index, lab in enumerate(names):
        lines = [f'listen = "{kind}127.0.0.1:{FIRST_PORT + index}"', f'keys = "{folder / "keys" / lab}"']
        for earlier, other in enumerate(names):
            if other != lab:
                lines += ["[[gateway.peers]]", f'lab = "{other}"', *([f'connect = "{kind}127.0.0.1:{FIRST_PORT + earlier}"'] if earlier < index else [])]
        files[lab] = folder / f"{lab}.toml"
        files[lab].write_text(FILE_TEXT.format(lab=lab, bus=labs[lab], labs=str(names).replace("'", '"')) + "\n".join(lines) + "\n")
    talkers = Talkers(labs, robots=100)
    with gateways(files, folder) as running:
        talkers.until_joined()
        talkers.talk(1)
        before, begin = {lab: cpu_s(process) for lab, process in running.items()}, time.monotonic()
        numbers = talkers.talk(seconds)
        took = time.monotonic() - begin
        used = sum(cpu_s(process) - before[lab] for lab, process in running.items())
        memory = [memory_mb(process) for process in running.values()]
        lost = talkers.lost(*numbers)
    return lost, 100 * used / took / number, sum(each[0] for each in memory) / number, sum(each[1] for each in memory) / number


def mesh_figure(bench, tls):
    sizes, seconds = ((2, 4, 8), 3) if bench.short else ((4, 8, 16), 30)
    rows = {number: mesh(bench.folder(), number, tls, seconds) for number in sizes}
    for number, (lost, cpu, resident, private) in rows.items():
        peers = number - 1
        print(f"  {number:>2} labs: of each gateway {cpu:.2f} % of a core, {cpu / peers:.3f} % a peer; {resident:.1f} MB resident, {private:.2f} MB private; "
              f"{lost} of {number * peers * seconds * RATE_HZ} messages lost")
    lost = sum(row[0] for row in rows.values())
    (few, first), (many, last) = min(rows.items()), max(rows.items())
    ratio = (last[1] / (many - 1)) / (first[1] / (few - 1)) if first[1] else float("nan")
    each_mb = (last[3] - first[3]) / (many - few)
    value = f"lost {lost}; {last[1]:.1f} % of a core at {many} labs, {ratio:.2f}x a peer's cost at {few}, {each_mb:.2f} MB a peer"
    return lost == 0 and (bench.short or ratio <= 1.2), value, "lost 0" + ("" if bench.short else ", at most 1.2x a peer")


def links_mesh_tcp(bench):
    """4, 8 and 16 labs, each joined with all others over plain TCP, 100-robot poses at 10 Hz each: losses; processor time and memory of a gateway."""
    return mesh_figure(bench, tls=False)


def links_mesh_tls(bench):
    """The same over TLS."""
    return mesh_figure(bench, tls=True)


@contextlib.contextmanager
def pair(bench):
    """Two labs in networks of their own, joined over TLS: (words to enter them, processes, talkers' buses)."""
    folder, labs = bench.folder(), {"shark": FIRST_BUS, "roark": FIRST_BUS + 1}
    folder.mkdir(parents=True)
    files = {lab: folder / f"{lab}.toml" for lab in labs}
    for lab, bus in labs.items():
        files[lab].write_text(FILE_TEXT.format(lab=lab, bus=bus, labs='["roark", "shark"]'))
    with joined_networks(list(labs)) as enter, gateways(files, folder, enter, join_by_tls(list(labs), folder / "keys")) as running:
        yield enter, running, labs


def sent_bytes(words):
    """What the cable has carried away from there, headers of Ethernet included."""
    done = subprocess.run([*words, "ip", "-s", "-s", "link", "show", "cable"], capture_output=True, text=True, check=True)
    return int(re.search(r"TX:.*\n\s*(\d+)", done.stdout)[1])


def links_poses(bench):
    """Poses of 1000 robots at 10 Hz to one peer over TLS: kB/s that leave the lab."""
    seconds = 3 if bench.short else 20
    with pair(bench) as (enter, _, labs):
        talkers = Talkers({"shark": labs["shark"]}, 1000, enter)
        ears = Talkers({"roark": labs["roark"]}, 1, enter)
        end = time.monotonic() + 300
        while not ears.came:
            if time.monotonic() > end:
                raise Failed("the two gateways do not meet")
            talkers.talk(0.2)
            ears.hear(0.05)
        begin, before = time.monotonic(), sent_bytes(enter["shark"])
        first, last = talkers.talk(seconds)
        rate = (sent_bytes(enter["shark"]) - before) / (time.monotonic() - begin) / 1000
        lost = ears.lost(first, last)
    return lost == 0, f"{rate:.0f} kB/s of {len(talkers.frame) * RATE_HZ / 1000:.0f} kB/s of messages, lost {lost}", "lost 0"


def links_idle(bench):
    """A gateway with one peer over TLS and nothing to do: memory and processor time; the larger of two."""
    seconds = 4 if bench.short else 60
    with pair(bench) as (enter, running, labs):
        # nsenter executes the program: the process is the gateway
        talkers = Talkers(labs, 1, enter)
        talkers.until_joined()
        time.sleep(2)
        before, begin = {lab: cpu_s(process) for lab, process in running.items()}, time.monotonic()
        time.sleep(seconds)
        cpu = 100 * max(cpu_s(process) - before[lab] for lab, process in running.items()) / (time.monotonic() - begin)
        resident, private = (max(each) for each in zip(*(memory_mb(process) for process in running.values())))
    met = resident <= 18 and private <= 5 and (bench.short or cpu < 0.5)
    return met, f"{resident:.1f} MB resident, {private:.1f} MB private, {cpu:.2f} % of a core", "18 MB, 5 MB, 0.5 %"


LINKS = [links_mesh_tcp, links_mesh_tls, links_poses, links_idle]
