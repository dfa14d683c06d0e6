"""What a cell of the campaign does between labs: hears what a lab says on its LCM bus, cuts and mends the link between two gateways, and speaks
in place of a lab that stands still. See scripts/campaign."""
import contextlib
import copy
import random
import socket
import struct
import threading
import time

import read_log

GROUP = "239.255.76.67"
SHORT_MESSAGE = 0x4C433032  # LCM's datagram: magic, number, channel, 0, bytes


class BusEar:
    """Hears one lab's bus, on a thread of its own: the newest message of each channel that is asked for."""

    def __init__(self, port, channels):
        self.newest, self.channels = {}, {channel.encode() for channel in channels}
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8 << 20)
        self.socket.bind((GROUP, port))
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, struct.pack("4sl", socket.inet_aton(GROUP), socket.INADDR_ANY))
        self.ended = False
        self.socket.settimeout(0.2)
        threading.Thread(target=self.hear, daemon=True).start()

    def hear(self):
        while not self.ended:
            try:
                datagram = self.socket.recv(1 << 16)
            except TimeoutError:
                continue
            channel, _, data = datagram[8:].partition(b"\0")
            if channel in self.channels and datagram[:4] == struct.pack(">I", SHORT_MESSAGE):
                self.newest[channel.decode()] = data

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


class Link:
    """The TCP connection between two gateways, through this process: `cut` and `mend`."""

    def __init__(self, listen, connect):
        self.listen, self.connect, self.sockets, self.door = listen, connect, [], None
        self.mend()

    def mend(self):
        self.door = socket.create_server(("127.0.0.1", self.listen))
        threading.Thread(target=self.accept, args=(self.door,), daemon=True).start()

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
                try:
                    outer = socket.create_connection(("127.0.0.1", self.connect))
                except OSError:
                    inner.close()
                    continue
                self.sockets += [inner, outer]
                for ends in ((inner, outer), (outer, inner)):
                    threading.Thread(target=self.pass_on, args=ends, daemon=True).start()

    def pass_on(self, source, sink):
        with contextlib.suppress(OSError):
            while data := source.recv(1 << 16):
                sink.sendall(data)
        for each in (source, sink):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)


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
                head = struct.pack(">II", SHORT_MESSAGE, number & 0xFFFFFFFF) + channel.encode() + b"\0"
                with contextlib.suppress(OSError):
                    self.socket.sendto(head + message.encode(), (GROUP, self.port))
            time.sleep(0.1)
