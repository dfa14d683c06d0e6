"""Labs' LCM buses from outside: hears what a lab says, speaks on its bus, and measures what gateways carry from bus to bus."""
import contextlib
import ctypes
import os
import random
import selectors
import socket
import struct
import threading
import time

import read_log
from lab_processes import Failed, until

GROUP = "239.255.76.67"
# LCM's datagrams: magic, number, channel, 0, bytes; or a part of a message: magic, number, its size, where the part begins, which it is, how many there are
SHORT_MESSAGE, PART_OF_MESSAGE = b"LC02", b"LC03"
CLONE_NEWNET, SO_RCVBUFFORCE, SO_TIMESTAMPNS, TIMESTAMP_BYTES = 0x40000000, 33, 35, 64
NUMBER_AT = 16  # of `number` in a pose frame
GATEWAY_TEXT = """[lab]
name = "{lab}"
[bus]
url = "udpm://239.255.76.67:{bus}?ttl=0&recv_buf_size=4194304"
[run]
scenario = "dhtf"
[shared]
labs = {labs}
[gateway]
"""


def gateway_file(folder, lab, bus, labs, lines):
    """The file of a gateway without a lab, with these lines of [gateway]."""
    file = folder / f"{lab}.toml"
    file.write_text(GATEWAY_TEXT.format(lab=lab, bus=bus, labs=str(labs).replace("'", '"')) + "\n".join(lines) + "\n")
    return file


def say(sender, port, number, channel, data):
    """Sends one message of at most a datagram's size on the lab's bus, from a UDP socket."""
    head = SHORT_MESSAGE + struct.pack(">I", number & 0xFFFFFFFF) + channel.encode() + b"\0"
    with contextlib.suppress(OSError):
        sender.sendto(head + data, (GROUP, port))


def open_ear(port):
    """A socket that hears a bus, with the kernel's time of each datagram."""
    ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    ear.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
    try:
        ear.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 32 << 20)
    except OSError:
        ear.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 32 << 20)
    ear.bind((GROUP, port))
    ear.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, struct.pack("4sl", socket.inet_aton(GROUP), socket.INADDR_ANY))
    return ear


class BusEar:
    """Hears one lab's bus, on a thread of its own: the newest message of each channel that is asked for; `each(channel, bytes)` is told of all."""

    def __init__(self, port, channels, each=None):
        self.newest, self.channels, self.each, self.parts = {}, {channel.encode() for channel in channels}, each, {}
        self.socket, self.ended = open_ear(port), False
        self.socket.settimeout(0.2)
        threading.Thread(target=self.hear, daemon=True).start()

    def hear(self):
        while not self.ended:
            try:
                datagram, sender = self.socket.recvfrom(1 << 16)
            except TimeoutError:
                continue
            channel, _, data = self.whole(datagram, sender).partition(b"\0")
            if channel in self.channels:
                self.newest[channel.decode()] = data
                if self.each:
                    self.each(channel.decode(), data)
        self.socket.close()

    def whole(self, datagram, sender):
        """Channel, 0 and bytes of the message that is complete with this datagram; empty when none is."""
        if datagram[:4] == SHORT_MESSAGE:
            return datagram[8:]
        if datagram[:4] != PART_OF_MESSAGE:
            return b""
        number, _, _, index, count = struct.unpack(">IIIHH", datagram[4:20])
        if self.parts.get(sender, (None,))[0] != number:  # of a sender's messages one is under way
            self.parts[sender] = number, {}
        kept = self.parts[sender][1]
        kept[index] = datagram[20:]
        return b"".join(part for _, part in sorted(kept.items())) if len(kept) == count else b""

    def message(self, channel):
        """The newest message of a channel, decoded; None before the first."""
        data = self.newest.get(channel)
        return None if data is None else read_log.decode(data)

    def state(self):
        """What the lab says that it is doing."""
        status = self.message("status")
        return status.state if status else ""

    def period(self):
        """Of the newest state that it has published; -1 before the first."""
        world = self.message("world")
        return world.window[-1].period if world and world.window else -1

    def counters(self):
        """{counter: value} of what the gateway said last of itself, peers' own added up."""
        message = self.message("peers")
        counters = {counter.name: counter.value for counter in message.counters}
        for counter in (counter for peer in message.peers for counter in peer.counters):
            counters[counter.name] = counters.get(counter.name, 0) + counter.value
        return counters


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
    """Labs in this process: those that speak say `poses` of so many robots on their bus, all at once or each at its own moment, and all note by number and by
    the kernel's time what they hear of the others'."""

    def __init__(self, labs, robots=100, rate_hz=10, speaking=None, at_once=True, enter=None):
        self.labs, self.rate_hz, self.frame, self.number = labs, rate_hz, pose_frame(robots), 0
        self.speaking = list(labs) if speaking is None else speaking
        self.apart_s = 0 if at_once else 1 / rate_hz / len(self.speaking)
        self.said, self.came = {}, {}  # (lab, number) -> when; (from, to) -> [(number, when)]
        self.selector, self.mouths = selectors.DefaultSelector(), {}
        for lab, bus in labs.items():
            with inside((enter or {}).get(lab)):
                self.mouths[lab], ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), open_ear(bus)
            ear.setblocking(False)
            self.selector.register(ear, selectors.EVENT_READ, lab)

    def hear(self, seconds):
        end = time.monotonic() + seconds
        while True:
            for key, _ in self.selector.select(max(0, end - time.monotonic())):
                with contextlib.suppress(BlockingIOError):
                    while True:
                        self.note(key.data, *key.fileobj.recvmsg(1 << 16, TIMESTAMP_BYTES)[:2])
            if time.monotonic() >= end:
                return

    def note(self, lab, datagram, ancillary):
        channel, _, data = datagram[8:].partition(b"\0")
        if channel.endswith(b"/poses") and ancillary:
            s, ns = struct.unpack("qq", ancillary[0][2][:16])
            self.came.setdefault((channel[:-6].decode(), lab), []).append((struct.unpack_from(">i", data, NUMBER_AT)[0], s + ns * 1e-9))

    def talk(self, seconds):
        """Returns the first and the last number."""
        first, begin = self.number + 1, time.monotonic()
        for _ in range(round(seconds * self.rate_hz)):
            self.number += 1
            struct.pack_into(">i", self.frame, NUMBER_AT, self.number)
            for place, lab in enumerate(self.speaking):
                self.hear(max(0, begin + (self.number - first) / self.rate_hz + place * self.apart_s - time.monotonic()))
                self.said[lab, self.number] = time.time()
                say(self.mouths[lab], self.labs[lab], self.number, "poses", bytes(self.frame))
        self.hear(1 / self.rate_hz)
        return first, self.number

    def until_joined(self, patience_s=120):
        """Until each has heard each that speaks."""
        wanted = len(self.speaking) * (len(self.labs) - 1)
        until(patience_s, lambda: len(self.came) >= wanted or self.talk(max(0.5, 1 / self.rate_hz)) is None, f"of {wanted} ways some carry nothing after {patience_s} s", 0)

    def lost(self, first, last):
        """How many of these numbers did not come, or not once and in order, on all ways together; waits for the last."""
        end = time.monotonic() + 300
        while any(way[-1][0] < last for way in self.came.values()) and time.monotonic() < end:
            self.hear(0.1)
        wrong = 0
        for way in self.came.values():
            numbers = [number for number, _ in way if number >= first]
            wrong += 0 if numbers == list(range(first, last + 1)) else max(1, last - first + 1 - len(set(numbers)))
        return wrong

    def latencies_ms(self, first, last):
        """Sorted, of all ways."""
        return sorted(1000 * (when - self.said[way[0], number]) for way, heard in self.came.items() for number, when in heard if first <= number <= last)

    def end(self):
        for key in list(self.selector.get_map().values()):
            key.fileobj.close()
        for mouth in self.mouths.values():
            mouth.close()
