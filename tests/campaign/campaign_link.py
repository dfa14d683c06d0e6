"""One cell of the campaign whose fault is between gateways: two labs in mid-run (strict DHTF), and a third gateway, lynx, that nothing happens to.
Runs in a network and mount namespace of its own. See tests/campaign/campaign.

shark listens, and roark connects to it, directly or through a Link of this process; shark connects to lynx. raven, a fourth lab, is expected at shark:
the cell speaks for it. Or all meet at a NATS server, roark through a Link; or roark at a second server of a cluster."""
import contextlib
import os
import pathlib
import re
import resource
import signal
import threading
import time

from campaign_cell import Cell, Pace, small_disk
from campaign_files import LISTENS, PORTS, THROUGH
from campaign_link_faults import RAVEN_BUS, ROUTES, SECOND_LISTENS, LinkFaults
from campaign_network import Marks, Path
from campaign_promises import LINK_FAULTS
from lab_bus import BusEar, gateway_file
from lab_processes import ROOT, Failed, begin, end_with_parent, run_delay_s
from joined_networks import call, start_nats_server

BUSES = PORTS | {"lynx": 7703}
LYNX_LISTENS = 7803
DOWN_S, FLOWS_S = 3.0, 1.0  # promised: a link that is down is shown so; data flows after the path's return
SERVER_DOWN_S, SERVER_FLOWS_S = 4.0, 8.0  # likewise, at a server
STARTS_S = 1.0              # what a gateway that is started again takes before that
GROWTH_MIB = 8.0            # of a gateway's resident memory, at its highest: what may wait for one peer (twice), and sessions of strangers
LONG_AGO_S = -11 * 365 * 86400
SERVER_TEXT = """listen: "127.0.0.1:{port}"
max_payload: {max_payload}
max_pending: {max_pending}
max_connections: 64
"""
# The first server waits for the second.
CLUSTER_TEXT = """cluster {{
  name: "hall"
  listen: "127.0.0.1:{listens}"
  routes: [{routes}]
}}
"""
THROUGH_US = {"slow reader 40 s", "old session replayed", "full disk"}  # faults for which the link passes through this process
WAYS = (("shark", "roark"), ("roark", "shark"))


class LinkCell(LinkFaults, Cell):
    def __init__(self, kind, phase, fault, out, program, hash_text, divide=1):
        super().__init__("simulated", "running", "", out, program, hash_text)
        self.kind, self.phase, self.fault, self.divide, self.about = kind, phase, fault, divide, LINK_FAULTS[fault]
        self.pace, self.patience_s = Pace(2.0, 4000.0, 50), 300
        self.peaks, self.views, self.others, self.servers, self.hurry = {}, {}, [], {}, threading.Event()
        self.clock = out / "clock_jump.txt"
        whole = next((float(number) for number in re.findall(r"(\d+) s$", fault)), 0)
        self.seconds = max(whole / divide, min(whole, 4.0))  # 4 s: longer than what is noticed

    # ------------------------------------------------------------ preparation

    def tls(self, port):
        return ("tls://" if self.kind == "tls" else "") + f"127.0.0.1:{port}"

    def keys(self, lab):
        return self.out / "keys" / lab

    def make_keys(self):
        labs = ("shark", "roark", "lynx", "raven")
        for lab in labs:
            call(self.program, "keys", "init", lab, "--keys", self.keys(lab))
        if self.fault == "certificate expired":
            self.clock.write_text(str(LONG_AGO_S))
            call("env", *self.jumping(), self.program, "keys", "renew", "raven", "--keys", self.keys("raven"))
            self.clock.write_text("0")
        for one, other in (("shark", "roark"), ("shark", "lynx"), ("shark", "raven"), ("raven", "lynx")):
            call(self.program, "keys", "trust", self.keys(one) / f"{one}.crt", "--keys", self.keys(other))
            call(self.program, "keys", "trust", self.keys(other) / f"{other}.crt", "--keys", self.keys(one))
        if self.fault == "certificate unknown":
            call(self.program, "keys", "renew", "raven", "--new-key", "--keys", self.keys("raven"))

    def jumping(self):
        """Words after `env` with which a program's wall clock can be moved."""
        library = self.out / "clock_jump.so"
        if not library.exists():
            call("cc", "-shared", "-fPIC", "-O1", "-o", library, ROOT / "tests/campaign/clock_jump.c", "-ldl")
        return [f"LD_PRELOAD={library}", f"CLOCK_JUMP={self.clock}"]

    def of_gateway(self, lab):
        """Overrides of the two labs' gateways."""
        own = ['gateway.imports=["world","status","marks"]', 'gateway.ordered=["marks"]', f'gateway.keys="{self.keys(lab)}"']
        if lab == "shark":
            own.append('shared.labs=["lynx","raven","roark","shark"]')
        if self.kind == "nats":
            ports = [LISTENS] if lab == "shark" else [SECOND_LISTENS, LISTENS] if self.in_cluster() else [THROUGH]
            own += ['gateway.listen=""', "gateway.peers=[]", f'gateway.connect="nats://{",".join(f"127.0.0.1:{port}" for port in ports)}"']
        elif lab == "shark":
            own += [f'gateway.listen="{self.tls(LISTENS)}"', f'gateway.peers=[{{lab="roark"}},{{lab="raven"}},{{lab="lynx",connect="{self.tls(LYNX_LISTENS)}"}}]']
        else:
            own.append(f'gateway.peers=[{{lab="shark",connect="{self.tls(THROUGH if self.fault in THROUGH_US else LISTENS)}"}}]')
        return [part for each in own for part in ("--set", each)]

    def in_cluster(self):
        return self.fault.startswith("cluster")

    def start_server(self, max_payload=1 << 20, max_pending=8 << 20, port=LISTENS, memory=None):
        """The NATS server, where labs meet, or the second of a cluster; with so many bytes of memory."""
        text = SERVER_TEXT.format(port=port, max_payload=max_payload, max_pending=max(max_pending, max_payload))
        if self.in_cluster():
            text += CLUSTER_TEXT.format(listens=ROUTES[port], routes="" if port == LISTENS else f'"nats://127.0.0.1:{ROUTES[LISTENS]}"')
        def with_memory():
            end_with_parent()
            if memory:
                resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
        self.servers[port] = start_nats_server(self.out, text, name=f"server-{port}", preexec_fn=with_memory)

    def start_servers(self):
        """As the fault wants them."""
        if self.fault.startswith("slow consumer"):
            self.start_server(max_payload=64 << 10, max_pending=64 << 10)
        elif "out of memory" in self.fault:
            self.start_server(max_pending=1 << 30, memory=192 << 20)
        else:
            self.start_server()
        if self.in_cluster():
            self.start_server(port=SECOND_LISTENS)

    def stop_server(self, port=LISTENS):
        self.servers[port].kill()
        self.servers[port].wait()

    def start_gateway(self, lab):
        self.labs.start("gateway", lab, more=self.of_gateway(lab))
        self.watch(lab, self.labs.processes["gateway", lab])

    def start_other(self, lab, file):
        """A gateway beside the two labs'; ended with the cell."""
        self.others.append(begin([self.program, "gateway", file], self.out / f"{lab}-gateway.txt"))
        return self.others[-1]

    def start_raven(self, peer="shark"):
        """raven's gateway, for faults in which it is a real one."""
        lines = [f'keys = "{self.keys("raven")}"', 'exports = ["status", "stray"]', "[[gateway.peers]]", f'lab = "{peer}"', f'connect = "{self.tls(LISTENS)}"']
        self.ears["raven"] = BusEar(RAVEN_BUS, ["peers"], lambda *_: self.note("raven"))
        self.start_other("raven", gateway_file(self.out, "raven", RAVEN_BUS, ["raven", peer], lines))

    def watch(self, lab, process):
        """Notes how far the resident memory of a gateway grows from when it has begun, as long as it lives."""
        def look():
            first, begun = None, time.monotonic() + 1.5
            with contextlib.suppress(OSError, TypeError):
                while process.poll() is None:
                    now = int(re.search(r"VmRSS:\s+(\d+)", pathlib.Path(f"/proc/{process.pid}/status").read_text())[1]) / 1024
                    if first is None and self.views.get(lab) and self.views[lab][-1][0] > begun:
                        first = now
                    if first is not None:
                        self.peaks[lab] = max(self.peaks.get(lab, 0), now - first)
                    time.sleep(0.2)
        threading.Thread(target=look, daemon=True).start()

    def note(self, lab):
        """Of each `peers`: when, which peers are up, all counters."""
        message = self.ears[lab].message("peers")
        offsets = {peer.lab: peer.clock_offset_us / 1e6 for peer in message.peers}
        self.views.setdefault(lab, []).append((time.monotonic(), {peer.lab: bool(peer.up) for peer in message.peers}, self.ears[lab].counters(), offsets))

    def is_up(self, lab, peer):
        return bool(self.views.get(lab)) and self.views[lab][-1][1].get(peer, False)

    def count(self, lab, name, since=0):
        """Of a counter's newest value what is more than it was then; a gateway that was started again begins at 0."""
        views = self.views.get(lab, [])
        before = next((view[2].get(name, 0) for view in reversed(views) if view[0] <= since), 0)
        now = views[-1][2].get(name, 0) if views else 0
        return now - before if now >= before else now

    def listen(self):
        return {lab: BusEar(port, ["status", "world", "peers"], lambda channel, _, lab=lab: channel == "peers" and self.note(lab))
                for lab, port in BUSES.items()}

    @contextlib.contextmanager
    def prepared(self):
        self.out.mkdir(parents=True, exist_ok=True)
        if self.fault == "full disk":
            small_disk(self.out)
        self.clock.write_text("0")
        if self.kind != "tcp":
            self.make_keys()
        with super().prepared():
            if self.in_cluster():
                # Servers of a cluster (2.9.10) leave a path between them that is lost only when TCP gives it up, which takes a quarter of an hour as it is.
                pathlib.Path("/proc/sys/net/ipv4/tcp_retries2").write_text("5")
            if self.kind == "nats":
                self.link.loses = 0
                self.start_servers()
            if self.fault.startswith("clock"):
                self.labs.enter["roark"] = ["env", *self.jumping()]
            # 20 a second would fill a link of 1 kB/s
            self.path, self.marks = Path(), Marks(BUSES, 0.5 if self.fault.startswith("slow reader") else 0.05)
            if self.fault == "old session replayed":
                self.link.carried = []
            lines = [f'keys = "{self.keys("lynx")}"', 'ordered = ["marks"]', 'imports = ["marks"]']
            if self.kind == "nats":
                lines.append(f'connect = "nats://127.0.0.1:{LISTENS}"')
            else:
                lines += [f'listen = "{self.tls(LYNX_LISTENS)}"', "[[gateway.peers]]", 'lab = "shark"']
            try:
                self.watch("lynx", self.start_other("lynx", gateway_file(self.out, "lynx", BUSES["lynx"], ["lynx", "shark"], lines)))
                yield
            finally:
                self.hurry.set()
                self.path.mend()
                for process in [*self.others, *self.servers.values()]:
                    process.kill()
                    process.wait()

    def slow_labs(self):
        """A run of mid-length lasts through the fault, and leaves the processors to the gateways: shark computes a tenth of the time, less in long
        faults, and roark waits for it. Until `self.hurry`."""
        process, pause_s = self.process("shark"), 0.18 if self.seconds <= 10 else 0.6
        while not self.hurry.is_set() and process.poll() is None:
            process.send_signal(signal.SIGSTOP)
            self.hurry.wait(pause_s)
            process.send_signal(signal.SIGCONT)
            self.hurry.wait(0.02)
        process.send_signal(signal.SIGCONT)

    # ------------------------------------------------------------ judgement

    def alive(self):
        """The ends of the link that can show it as down."""
        stood = {"connecting gateway killed": "roark", "listening gateway killed": "shark"}.get(self.fault) or ("roark" if "frozen" in self.fault else None)
        return [pair for pair in WAYS if pair[0] != stood]

    def run_delays(self):
        return {process: run_delay_s(process) for process in (os.getpid(), *(self.gateway(lab).pid for lab in PORTS))}

    def late_s(self):
        """For how long this process and the gateways wanted a processor and had none since the fault: no deadline of theirs includes that."""
        return sum(delay - self.delays.get(process, 0) for process, delay in self.run_delays().items())

    def judge_link(self, began, returned):
        """How soon it was shown as down, how soon data flowed again, what was counted."""
        def shown_down(lab, peer):
            return next((view[0] - began for view in list(self.views[lab]) if view[0] > began and not view[1].get(peer)), None)

        def flows():
            return [self.marks.first_after(way, returned) for way in WAYS]
        self.until(300, lambda: all(flows()), "data after the path's return")
        flowed, late_s = max(flows()) - returned, self.late_s()
        self.figures["flows_s"] = round(flowed, 2)
        if flowed - late_s > (limit := SERVER_FLOWS_S if self.kind == "nats" else FLOWS_S + (STARTS_S if "killed" in self.fault else 0)):
            self.problems.append(f"data flows {flowed:.2f} s after the path's return instead of {limit} s")
        downs = [shown_down(*pair) for pair in self.alive()]
        known = [down for down in downs if down is not None]
        self.figures["down_s"] = round(max(known), 2) if known else None
        self.wrong_if(self.about.down and len(known) < len(downs), "an end of the link did not show it as down")
        if self.about.down is False and known:
            self.problems.append(f"the link was shown as down after {min(known):.1f} s")
        if self.about.down and known and max(known) - late_s > (down_s := SERVER_DOWN_S if self.kind == "nats" else DOWN_S):
            self.problems.append(f"the link was shown as down after {max(known):.2f} s instead of {down_s} s")

    def judge_counter(self, began):
        pattern = self.about.counter(self.kind)
        if not pattern:
            return
        def grown():
            return {f"{lab}.{name}": self.count(lab, name, began) for lab, views in list(self.views.items()) for name in dict(views[-1][2])
                    if re.fullmatch(pattern, f"{lab}.{name}") and self.count(lab, name, began) > 0}
        with contextlib.suppress(Failed):
            self.until(60, grown, "")
        self.figures["counter"] = ", ".join(f"{name} {number}" for name, number in sorted(grown().items()))
        self.wrong_if(not grown(), f"no counter /{pattern}/ grew")

    def judge_others(self, began, ended):
        """lynx notices nothing; marks are neither lost nor repeated; gateways live and have not grown."""
        if self.fault != "listening gateway killed" and not self.about.of_server:
            pause = max(self.marks.longest_pause(way, began, ended) for way in (("shark", "lynx"), ("lynx", "shark")))
            self.figures["lynx_pause_s"] = round(pause, 2)
            if pause > DOWN_S + self.late_s() or any(not view[1]["shark"] for view in self.views["lynx"] if view[0] > began):
                self.problems.append(f"the link with lynx was disturbed: {pause:.1f} s without data")
        if "gateway killed" not in self.fault:
            for way in WAYS:
                wrong = self.marks.out_of_order(way)
                self.wrong_if(wrong, f"{wrong} ordered messages from {way[0]} to {way[1]} are lost or repeated")
        for lab in PORTS:
            self.wrong_if(self.gateway(lab).poll() is not None, f"the gateway of {lab} has ended: {self.labs.last_words('gateway', lab)}")
        self.figures["growth_mib"] = round(max(self.peaks.values(), default=0), 1)
        self.wrong_if(self.figures["growth_mib"] > GROWTH_MIB, f"a gateway grew by {self.figures['growth_mib']} MiB: {self.peaks}")

    def play(self):
        for lab in PORTS:
            self.start_gateway(lab)
        for lab in PORTS:
            self.start_lab(lab)
        self.until(300, lambda: self.ears["roark"].period() >= self.pace.fault_at or not self.lives(), "the run's beginning")
        if not self.lives():
            raise Failed(f"the lab ended before the fault: {self.labs.last_words('lab', 'roark')}")
        threading.Thread(target=self.slow_labs, daemon=True).start()
        self.until(300, lambda: all(self.is_up(*pair) for pair in (*WAYS, ("lynx", "shark"))), "the links")
        self.until(300, lambda: len(self.marks.came) >= 4, "data on each way")
        time.sleep(1)
        self.began, self.delays = time.monotonic(), self.run_delays()
        returned = self.do_fault()
        self.wrong_if(not self.lives(), "the run had ended before the fault was over")
        self.judge_link(self.began, returned)
        self.judge_counter(self.began)
        self.hurry.set()
        self.wait_for_ends(time.monotonic())
        time.sleep(1)
        self.judge_others(self.began, returned + 1)
        for lab in PORTS:
            self.judge_lab(lab, "failed" if self.fault == "full disk" else "finished", "")  # a log that is not whole
        self.marks.stop()
