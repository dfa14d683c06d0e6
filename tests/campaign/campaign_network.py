"""What a cell of the campaign does between labs: cuts and mends the link between two gateways, and speaks in place of a lab that stands still. See
tests/campaign/campaign."""
import contextlib
import copy
import functools
import pathlib
import random
import socket
import struct
import subprocess
import threading
import time

import read_log
from lab_bus import BusEar, say
from lab_processes import Failed


class Link:
    """The TCP connection between two gateways, or of one to its server, through this process: `cut` and `mend`; `pace` is bytes/s towards who listens
    (0: all that comes), `pace_back` the other way. What goes there is kept in `carried` when that is a list. `loses` is the nth of a NATS
    server's messages that is dropped (0: none is); None: who connects here is no such server."""

    def __init__(self, listen, connect):
        self.listen, self.connect, self.sockets, self.door = listen, connect, [], None
        self.pace, self.pace_back, self.carried, self.loses = 0, 0, None, None
        self.mend()

    def mend(self):
        self.door = socket.create_server(("127.0.0.1", self.listen))
        threading.Thread(target=self.accept, args=(self.door,), daemon=True).start()

    def have(self, name, value, renew):
        """Sets one of its properties; of connections that begin then, when they are to be renewed."""
        setattr(self, name, value)
        if renew:
            self.cut()
            self.mend()

    def cut(self):
        # shutdown wakes the thread that accepts; a closed descriptor alone would not
        for each in [self.door, *self.sockets]:
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
        self.sockets = []

    def accept(self, door):
        with contextlib.suppress(OSError):
            while True:
                inner, _ = door.accept()
                outer = socket.socket()
                try:
                    if self.pace_back:  # what waits is to wait at the other end
                        outer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                    outer.connect(("127.0.0.1", self.connect))
                except OSError:
                    outer.close()
                    inner.close()
                    continue
                self.sockets += [inner, outer]
                for ends in ((inner, outer, True), (outer, inner, False)):
                    threading.Thread(target=self.pass_on, args=ends, daemon=True).start()

    def pass_on(self, source, sink, inwards):
        messages = NatsMessages()
        with contextlib.suppress(OSError):
            while data := source.recv(max(1, pace // 20) if (pace := self.pace if inwards else self.pace_back) else 1 << 16):
                if self.pace if inwards else self.pace_back:
                    time.sleep(0.05)
                if inwards and self.carried is not None:
                    self.carried.append(data)
                sink.sendall(data if inwards or self.loses is None else messages.without_each(self.loses, data))
        for each in (source, sink):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)


class NatsMessages:
    """What a NATS server sends, cut into lines and messages: `MSG SUBJECT ID BYTES`, the bytes, and a line's end."""

    def __init__(self):
        self.rest, self.number = b"", 0

    def without_each(self, nth, data):
        """What goes on of all that came so far: everything that is whole, but for each nth message (0: all messages)."""
        self.rest, passed = self.rest + data, b""
        while (end := self.rest.find(b"\r\n") + 2) > 1:
            is_message = self.rest.startswith(b"MSG ")
            whole = end + (int(self.rest[:end].split()[-1]) + 2 if is_message else 0)
            if len(self.rest) < whole:
                break
            self.number += is_message
            if not (nth and is_message and self.number % nth == 0):
                passed += self.rest[:whole]
            self.rest = self.rest[whole:]
        return passed


class Impostor:
    """Speaks on a lab's bus in its place while it stands still: it lives, and its next state breaks the rules (a robot that the platform cannot
    address)."""

    def __init__(self, port, ear, other):
        self.port, self.ear, self.other, self.ended = port, ear, other, False
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.world, self.status = copy.deepcopy(ear.message("world")), ear.message("status")
        state = self.world.window[-1]
        if state.period > 0:
            state = copy.deepcopy(state)
            state.period += 1
            self.world.window.append(state)
            self.world.n_states += 1
        state.robots[-1].robot = 60000
        threading.Thread(target=self.speak, daemon=True).start()

    def speak(self):
        number = random.getrandbits(16)
        while not self.ended:
            # whoever is spoken to must be known by its run
            if heard := self.ear.message(f"{self.other}/world"):
                ack = read_log.new("ack_t", peer=self.other, nonce=heard.nonce, received=heard.window[-1].period if heard.window else -1)
                self.world.acks, self.world.n_acks = [ack], 1
            for channel, message in (("status", self.status), ("world", self.world)):
                number += 1
                say(self.socket, self.port, number, channel, message.encode())
            time.sleep(0.1)


class Path:
    """Makes packets of TCP ports vanish within this network namespace: routes lead them where nobody is. Nothing is closed or refused."""
    TABLE = "66"

    def __init__(self):
        for words in ("link add drain type veth peer name drained", "link set drain arp off up", "link set drained up", "rule add pref 100 lookup local",
                      "rule del pref 0", f"route add 127.0.0.0/8 dev drain table {self.TABLE}"):
            self.ip(words)
        pathlib.Path("/proc/sys/net/ipv4/conf/drain/route_localnet").write_text("1")
        self.lost = []

    @staticmethod
    def ip(words):
        done = subprocess.run(["ip", *words.split()], capture_output=True, text=True)
        if done.returncode != 0:
            raise Failed(f"`ip {words}` failed: {done.stderr.strip()}")

    def lose(self, *ports):
        """Loses what goes to "dport N" or comes from "sport N"."""
        for port in ports:
            self.ip(f"rule add pref 10 ipproto tcp {port} lookup {self.TABLE}")
            self.lost.append(port)

    def mend(self):
        while self.lost:
            self.ip(f"rule del pref 10 ipproto tcp {self.lost.pop()} lookup {self.TABLE}")


class Marks:
    """Numbered messages of labs on channel `marks`, which gateways carry in order; and what of them came where."""

    def __init__(self, ports, period_s=0.05):
        self.ports, self.period_s, self.ended = ports, period_s, False
        self.came = {}  # (from, to) -> [(when, number)]
        self.ears = [BusEar(port, [f"{other}/marks" for other in ports if other != lab], functools.partial(self.hear, lab)) for lab, port in ports.items()]
        threading.Thread(target=self.speak, daemon=True).start()

    def hear(self, lab, channel, data):
        self.came.setdefault((channel.partition("/")[0], lab), []).append((time.monotonic(), struct.unpack(">q", data[:8])[0]))

    def speak(self):
        sender, number = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), 0
        while not self.ended:
            number += 1
            for port in self.ports.values():
                say(sender, port, number, "marks", struct.pack(">q", number))
            time.sleep(self.period_s)

    def stop(self):
        self.ended = True
        for ear in self.ears:
            ear.ended = True

    def first_after(self, way, when):
        """When the first one came after that; None: none has."""
        return next((came for came, _ in list(self.came.get(way, [])) if came > when), None)

    def out_of_order(self, way):
        """How many numbers do not follow the one before."""
        numbers = [number for _, number in self.came.get(way, [])]
        return sum(after != before + 1 for before, after in zip(numbers, numbers[1:]))

    def longest_pause(self, way, begin, end):
        """The longest time without one between two moments, in seconds."""
        times = [begin, *(came for came, _ in self.came.get(way, []) if begin < came < end), end]
        return max(after - before for before, after in zip(times, times[1:]))
