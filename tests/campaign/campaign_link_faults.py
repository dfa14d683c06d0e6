"""The faults between gateways: what a LinkCell (campaign_link.py) does to the connection of shark and roark, to their machines, or at shark's port."""
import contextlib
import functools
import pathlib
import resource
import signal
import socket
import time

import campaign_strangers as strangers
from campaign_cell import fill
from campaign_files import LISTENS, THROUGH
from joined_networks import call
from lab_bus import say
from lab_processes import Failed

RAVEN_BUS = 7704
SECOND_LISTENS = 7802                            # the second NATS server of a cluster
ROUTES = {LISTENS: 7821, SECOND_LISTENS: 7822}  # where each listens for the other
TLS_BEGINS = bytes.fromhex("1603010200010001fc0303")  # a client's first bytes


class LinkFaults:
    def gateway(self, lab):
        return self.labs.processes["gateway", lab]

    def lasting(self):
        """Faults that last for the cell's seconds, by how their names begin: how they begin, and how they end."""
        port = THROUGH if self.kind == "nats" else LISTENS  # between roark and all others
        both = (f"dport {port}", f"sport {port}")
        routes = [f"{end} {port}" for end in ("dport", "sport") for port in ROUTES.values()]

        def frozen(process):
            return (lambda: process().send_signal(signal.SIGSTOP)), (lambda: process().send_signal(signal.SIGCONT))

        def lost(*ports):
            return functools.partial(self.path.lose, *ports), self.path.mend

        def at_link(name, value, renew=False):
            return [functools.partial(self.link.have, name, each, renew) for each in (value, 0)]
        return {"gateway frozen": frozen(lambda: self.gateway("roark")), "server frozen": frozen(lambda: self.servers[LISTENS]), "half-open": lost(both[1]),
                "partition": lost(*both), "cluster partition": lost(*routes), "slow consumer": at_link("pace_back", 1000, True),
                "slow reader": at_link("pace", 1000), "one message in ten": at_link("loses", 10)}

    def do_fault(self):
        """Does it, and returns when the path was there again."""
        fault, of_kind = self.fault, self.kind
        if fault.endswith("gateway killed"):
            victim = "roark" if fault.startswith("connecting") else "shark"
            self.gateway(victim).kill()
            self.gateway(victim).wait()
            time.sleep(4)
            self.start_gateway(victim)
        elif steps := next((steps for name, steps in self.lasting().items() if fault.startswith(name)), None):
            steps[0]()
            time.sleep(self.seconds)
            steps[1]()
        elif fault.startswith("flapping"):
            both = self.lasting()["partition"]
            end = time.monotonic() + self.seconds
            while time.monotonic() < end:
                for step in both:
                    step()
                    time.sleep(0.2)
        elif fault.startswith("server"):
            self.harm_server()
        elif fault.startswith("cluster's server killed"):
            self.stop_server(SECOND_LISTENS)
            killed = time.monotonic()
            time.sleep(self.seconds)
            return killed  # the other server is the path
        elif fault.startswith("clock"):
            self.clock.write_text("3600" if fault.endswith("ahead") else "-3600")
            self.until(300, lambda: abs(self.views["shark"][-1][3]["roark"]) > 3500, "the offset of the peer's clock")
            time.sleep(1)
        elif fault == "old session replayed":
            for _ in range(3):
                strangers.send(LISTENS, b"".join(self.link.carried[:2000]), 1)
        elif fault == "garbage":
            self.send_garbage()
        elif fault == "another lab's name":
            self.must_close("a hello of another lab's name", strangers.hello("shark" if of_kind == "tcp" else "lynx"), **self.as_raven())
        elif fault == "channel not imported":
            self.start_raven()
            self.until(300, lambda: self.is_up("shark", "raven"), "the link with raven")
            sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            for number in range(20):
                say(sender, RAVEN_BUS, number, "stray", bytes(8))
                time.sleep(0.02)
        elif fault.startswith("flood"):
            self.flood(1000 // self.divide)
        elif fault == "wrong kind of link":
            if of_kind == "tls":
                self.must_close("a plain hello at a TLS port", strangers.hello("raven"))
            else:
                self.must_close("TLS at a plain port", TLS_BEGINS + bytes(506))
        elif fault.startswith("certificate"):
            self.show_certificate()
        elif fault == "full disk":
            fill(self.out)
            for _ in range(2):  # gateways have something to say
                self.link.cut()
                time.sleep(1.5)
                self.link.mend()
                time.sleep(1.5)
        elif fault == "descriptors exhausted":
            self.exhaust_descriptors()
        return time.monotonic()

    def harm_server(self):
        """Faults of the NATS server."""
        if "is full" in self.fault:
            with contextlib.ExitStack() as ending:
                while self.takes_place(ending):
                    pass
                self.link.cut()
                self.until(300, lambda: self.takes_place(ending), "that a stranger has the peer's place at the server")
                self.link.mend()
                time.sleep(self.seconds)
        elif "out of memory" in self.fault:
            self.exhaust_memory()
            self.began = time.monotonic()
            time.sleep(self.seconds)
            self.start_server()
        else:
            self.stop_server()
            if "takes 16 kB" in self.fault:
                self.start_server(max_payload=16 << 10)
            time.sleep(self.seconds)
            self.stop_server()
            self.start_server()

    @staticmethod
    def takes_place(ending):
        """Whether the NATS server has a place for one more stranger, who then keeps it until the end of `ending`."""
        stranger, said = ending.enter_context(strangers.connect(LISTENS)), b""
        with contextlib.suppress(OSError):
            stranger.sendall(b"CONNECT {\"verbose\":false}\r\nPING\r\n")
            while b"PONG" not in said and (more := stranger.recv(4096)):
                said += more
        if b"PONG" not in said:
            stranger.close()
        return b"PONG" in said

    def exhaust_memory(self):
        """The NATS server keeps what one client says for another that reads nothing, until it has no memory for it."""
        with contextlib.ExitStack() as ending, contextlib.suppress(OSError):  # the server's end
            reader, speaker = (ending.enter_context(strangers.connect(LISTENS)) for _ in range(2))
            for each in (reader, speaker):
                each.sendall(b"CONNECT {\"verbose\":false}\r\n")
            reader.sendall(b"SUB flood 1\r\n")
            for _ in range(512):
                speaker.sendall(b"PUB flood %d\r\n%s\r\n" % (1 << 20, bytes(1 << 20)))
        self.until(20, lambda: self.servers[LISTENS].poll() is not None, "the NATS server's end")
        if "out of memory" not in (self.out / f"server-{LISTENS}.txt").read_text(errors="replace"):
            raise Failed(f"the NATS server ended with code {self.servers[LISTENS].returncode} and was not out of memory")

    def as_raven(self):
        return {"keys": self.keys("raven"), "lab": "raven"} if self.kind == "tls" else {}

    def must_close(self, what, data, **how):
        came, closed = strangers.send(LISTENS, data, 20, **how)
        self.wrong_if(not closed, f"a connection with {what} is not closed within 20 s")
        return came

    def send_garbage(self):
        for what, data in strangers.before_hello("raven"):
            self.must_close(what, data)  # also below TLS
            if self.kind == "tls":
                self.must_close(what, data, **self.as_raven())
        for what, data in strangers.after_hello("raven"):
            self.must_close(what, data, **self.as_raven())

    def flood(self, number):
        with contextlib.ExitStack() as ending:
            idle = [ending.enter_context(strangers.connect(LISTENS)) for _ in range(number)]
            slow = [ending.enter_context(strangers.connect(LISTENS)) for _ in range(20)]
            word = strangers.hello("raven") if self.kind == "tcp" else TLS_BEGINS
            for byte in word[:6]:
                for each in slow:
                    with contextlib.suppress(OSError):
                        each.sendall(bytes([byte]))
                time.sleep(1)
            left = sum(not strangers.until_closed(each, 0.001)[1] for each in idle)
            self.wrong_if(left > 16, f"{left} of {number} idle connections are open after 6 s")

    def exhaust_descriptors(self):
        pid = self.gateway("shark").pid
        before = resource.prlimit(pid, resource.RLIMIT_NOFILE)
        open_ = len(list(pathlib.Path(f"/proc/{pid}/fd").iterdir()))
        resource.prlimit(pid, resource.RLIMIT_NOFILE, (open_ + 4, before[1]))
        with contextlib.ExitStack() as ending:
            for number in range(60):
                # of several addresses, as strangers of a network are
                ending.enter_context(strangers.connect(LISTENS, source=f"127.0.1.{number // 4 + 1}"))
            time.sleep(7)
        resource.prlimit(pid, resource.RLIMIT_NOFILE, before)
        began = time.monotonic()
        while not (came := strangers.send(LISTENS, strangers.hello("raven"), 2, **self.as_raven())[0]) and time.monotonic() < began + 20:
            time.sleep(0.2)
        self.wrong_if(not came, "a gateway whose descriptors were exhausted answers no hello within 20 s")

    def show_certificate(self):
        if self.fault == "certificate of another lab":
            self.start_raven(peer="lynx")
            self.until(300, lambda: self.count("raven", "session.refused.certificate_of_other_lab") > 0, "the refusal")
        elif self.fault == "certificate unknown":
            self.start_raven()
            self.until(300, lambda: self.count("shark", "session.refused.certificate_unknown") > 0, "the refusal")
        else:
            self.start_raven()
            self.until(300, lambda: self.is_up("shark", "raven"), "the link with raven")
            if self.fault == "certificate expired":
                self.until(300, lambda: self.views["raven"][-1][2].get("session.opened"), "what raven counts")
                self.wrong_if(self.views["shark"][-1][2].get("certificate.days_left") != 0, "`certificate.days_left` of a certificate that has ended is not 0")
                return
            call(self.program, "keys", "revoke", "raven", "--keys", self.keys("shark"))
            began = time.monotonic()
            self.until(300, lambda: not self.is_up("shark", "raven"), "the end of the revoked lab's link")
            self.wrong_if(time.monotonic() - began - self.late_s() > 1, f"a revoked lab's link is cut after {time.monotonic() - began:.1f} s")
            self.until(300, lambda: self.count("shark", "session.refused.certificate_revoked") > 0, "the refusal")
