"""Figures of labs that meet at a NATS server: fifty at once beside direct TCP, what a sender pays by the number of its peers, how long a message takes, what
signatures cost, sixteen labs of DHTF, and what watchers cost the labs. See scripts/measure."""
import contextlib
import functools
import json
import re
import resource
import selectors
import shutil
import socket
import statistics
import struct
import subprocess
import threading
import time
import urllib.request

import read_log
from campaign_network import say
from joined_networks import make_keys
from lab_processes import PROGRAM, ROOT, Failed, LabProcesses, end_all, end_with_parent, join_results
import intervals
from measure_links import FILE_TEXT, FIRST_BUS, FIRST_PORT, NUMBER_AT, SO_RCVBUFFORCE, cpu_s, gateways, memory_mb, pose_frame
from measure_simulator import commit, machine, write_between

SERVER, NATS_PORT, MONITOR_PORT, ROBOTS = "/usr/sbin/nats-server", 7970, 7971, 100
PAGE, SIZING_PLACE = ROOT / "docs/federation.md", "sizing: written by scripts/measure federation_crowd"
SIZING_HEADER = ["labs", "joined", "a gateway: % of a core", "MB", "the server: % of a core", "MB", "MB/s in, out", "p50, p99 ms", "states, lost"]
WATCHERS_PLACE, VIEW_PORT = "watchers: written by scripts/measure federation_watchers", 7972
SO_TIMESTAMPNS, TIMESTAMP_BYTES = 35, 64
GROUP = "239.255.76.67"


@contextlib.contextmanager
def nats_server(folder):
    """A server on this machine, ready: its process."""
    file, said = folder / "server.conf", folder / "server.txt"
    file.write_text(f'listen: "127.0.0.1:{NATS_PORT}"\nhttp: "127.0.0.1:{MONITOR_PORT}"\nmax_pending: 64MB\n')
    with open(said, "wb") as words:
        server = subprocess.Popen([SERVER, "-c", file], stdin=subprocess.DEVNULL, stdout=words, stderr=words, preexec_fn=end_with_parent)
    try:
        end = time.monotonic() + 300
        while "Server is ready" not in said.read_text(errors="replace"):
            if server.poll() is not None or time.monotonic() > end:
                raise Failed(f"the NATS server did not start: {(said.read_text().strip().splitlines() or ['it said nothing'])[-1]}")
            time.sleep(0.05)
        yield server
    finally:
        end_all([server])


class Speakers:
    """Labs in this process: some say a state at their own moment of each second, and all that listen note how long what they hear took, by the kernel's
    stamps of both."""

    def __init__(self, labs, speaking, rate_hz=1):
        self.labs, self.speaking, self.rate_hz, self.frame, self.number = labs, speaking, rate_hz, pose_frame(ROBOTS), 0
        self.said, self.came = {}, {}  # (lab, number) -> when; (from, to) -> [(number, when)]
        self.selector, self.mouth = selectors.DefaultSelector(), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for lab, bus in labs.items():
            ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            ear.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
            try:
                ear.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 32 << 20)
            except OSError:
                ear.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 32 << 20)
            ear.bind((GROUP, bus))
            ear.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, struct.pack("4sl", socket.inet_aton(GROUP), socket.INADDR_ANY))
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
                due = begin + (self.number - first + place / len(self.speaking)) / self.rate_hz
                self.hear(max(0, due - time.monotonic()))
                self.said[lab, self.number] = time.time()
                say(self.mouth, self.labs[lab], self.number, "poses", bytes(self.frame))
        self.hear(1 / self.rate_hz)
        return first, self.number

    def until_joined(self, patience_s=120):
        end, wanted = time.monotonic() + patience_s, len(self.speaking) * (len(self.labs) - 1)
        while len(self.came) < wanted:
            if time.monotonic() > end:
                raise Failed(f"{wanted - len(self.came)} of {wanted} ways carry nothing after {patience_s} s")
            self.talk(1)

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
        self.mouth.close()


def server_bytes():
    """What the server has taken and given, by itself."""
    with urllib.request.urlopen(f"http://127.0.0.1:{MONITOR_PORT}/varz", timeout=10) as told:
        of = json.load(told)
    return of["in_bytes"], of["out_bytes"]


def part(values, of):
    return values[min(len(values) - 1, int(of * len(values)))] if values else float("nan")


def gateway_counters(bus, patience_s=5):
    """{counter: value} of what a gateway says of itself on its lab's bus, peers' own added up."""
    ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    ear.bind((GROUP, bus))
    ear.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, struct.pack("4sl", socket.inet_aton(GROUP), socket.INADDR_ANY))
    ear.settimeout(patience_s)
    parts = {}  # of a message of several datagrams
    with ear:
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            data = ear.recv(1 << 16)
            whole = None
            if data[:4] == b"LC02":
                channel, _, body = data[8:].partition(b"\0")
                whole = body if channel == b"peers" else None
            elif data[:4] == b"LC03":
                number, size, offset, index, count = struct.unpack(">IIIHH", data[4:20])
                kept = parts.setdefault(number, {})
                kept[index] = data[20:]
                if len(kept) == count:
                    channel, _, body = b"".join(kept[i] for i in range(count)).partition(b"\0")
                    whole = body if channel == b"peers" else None
                    del parts[number]
            if whole:
                message = read_log.decode(whole)
                counters = {each.name: each.value for each in message.counters}
                for peer in message.peers:
                    for each in peer.counters:
                        counters[each.name] = counters.get(each.name, 0) + each.value
                return counters
    raise Failed("a gateway says nothing of itself")


def write_files(folder, names, kind):
    """Labs that meet at the server, or are joined by TCP each with each: {lab: file}."""
    files = {}
    if kind == "nats":
        quick_keys(names, folder / "keys")
    for index, lab in enumerate(names):
        lines = [f'keys = "{folder / "keys" / lab}"']
        if kind == "nats":
            lines.append(f'connect = "nats://127.0.0.1:{NATS_PORT}"')
        else:
            lines.append(f'listen = "127.0.0.1:{FIRST_PORT + index}"')
            for earlier, other in enumerate(names):
                if other != lab:
                    lines += ["[[gateway.peers]]", f'lab = "{other}"', *([f'connect = "127.0.0.1:{FIRST_PORT + earlier}"'] if earlier < index else [])]
        files[lab] = folder / f"{lab}.toml"
        files[lab].write_text(FILE_TEXT.format(lab=lab, bus=FIRST_BUS + index, labs=str(names).replace("'", '"')) + "\n".join(lines) + "\n")
    return files


def quick_keys(names, folder):
    """As make_keys, without a process for each pair."""
    make_keys(names[:1], folder)
    for lab in names[1:]:
        subprocess.run([PROGRAM, "keys", "init", lab, "--keys", folder / lab], check=True, capture_output=True)
    for lab in names:
        (folder / lab / "trusted").mkdir(exist_ok=True)
        for other in names:
            if other != lab:
                shutil.copy(folder / other / f"{other}.crt", folder / lab / "trusted")


@functools.cache
def crowd(bench, number, kind, seconds, speakers=None, rate_hz=1):
    """So many labs, all or some of which say a state of 100 robots: what that costs, and how long states take."""
    folder = bench.folder()
    folder.mkdir(parents=True)
    names = [f"lab{index:02}" for index in range(number)]
    files = write_files(folder, names, kind)
    labs = {lab: FIRST_BUS + index for index, lab in enumerate(names)}
    with contextlib.ExitStack() as ending:
        server = ending.enter_context(nats_server(folder)) if kind == "nats" else None
        running = ending.enter_context(gateways(files, folder))
        talkers = Speakers(labs, names[:speakers], rate_hz)
        ending.callback(talkers.end)
        talkers.until_joined()
        talkers.talk(2)
        watched = running | ({"server": server} if server else {})
        used_idle, begin = cpu_s(running[names[0]]), time.monotonic()
        talkers.hear(5 if speakers == 1 else 0)
        idle = 100 * (cpu_s(running[names[0]]) - used_idle) / (time.monotonic() - begin)
        before, bytes_before, begin = {name: cpu_s(process) for name, process in watched.items()}, server_bytes() if server else (0, 0), time.monotonic()
        numbers = talkers.talk(seconds)
        took = time.monotonic() - begin
        passed = [(after - was) / took / 1e6 for was, after in zip(bytes_before, server_bytes() if server else (0, 0))]
        used = {name: 100 * (cpu_s(process) - before[name]) / took for name, process in watched.items()}
        lost = talkers.lost(*numbers)
        latencies = talkers.latencies_ms(*numbers)
        memory = {name: memory_mb(process)[0] for name, process in watched.items()}
        time.sleep(0.5)
        counters = [gateway_counters(labs[lab]) for lab in (names[0], names[-1])]
    others = [lab for lab in names if lab != names[0]] if speakers == 1 else names
    return {"labs": number, "kind": kind, "lost": lost, "sent": numbers[1] - numbers[0] + 1, "p50_ms": part(latencies, 0.5), "p99_ms": part(latencies, 0.99),
            "gateway_cpu": sum(used[lab] for lab in others) / len(others), "sender_cpu": used[names[0]], "sender_idle_cpu": idle, "gateway_mb": sum(memory[lab] for lab in names) / number,
            "server_cpu": used.get("server", 0), "server_mb": memory.get("server", 0), "passed": passed, "refused": sum(value for each in counters for name, value in each.items() if "refused" in name),
            "sent_again": sum(each.get("federation.pieces.sent_again", 0) for each in counters)}


def told(row):
    server = f"; server {row['server_cpu']:.1f} %, {row['server_mb']:.0f} MB" if row["server_mb"] else ""
    return (f"{row['labs']} labs by {row['kind']}: each gateway {row['gateway_cpu']:.2f} % of a core, {row['gateway_mb']:.1f} MB{server}; "
            f"p50 {row['p50_ms']:.2f} ms, p99 {row['p99_ms']:.2f} ms; {row['lost']} lost, {row['refused']} refused")


def federation_crowd(bench):
    """50 labs at one server on this machine, a state of 100 robots a second each: losses, latency, cost, beside the same labs joined by TCP each with each; writes
    the table of docs/federation.md (full form)."""
    sizes, seconds = ((6,), 3) if bench.short else ((10, 25, 50), 30)
    raise_open_files()
    rows = []
    for number, kind in [*((number, "nats") for number in sizes), (sizes[-1], "tcp")]:
        rows.append(crowd(bench, number, kind, seconds))
        print(f"  {told(rows[-1])}", flush=True)
    nats, tcp = rows[-2:]
    if not bench.short:
        write_between(PAGE, SIZING_PLACE, sizing_table(rows))
    value = (f"lost {nats['lost']} of {states(nats)}; server {nats['server_cpu']:.0f} %, a gateway {nats['gateway_cpu']:.1f} %; "
             f"p50 {nats['p50_ms']:.1f} (tcp {tcp['p50_ms']:.1f}), p99 {nats['p99_ms']:.1f} ({tcp['p99_ms']:.1f}) ms")
    return nats["lost"] == 0 and nats["refused"] == 0, value, "lost 0, refused 0"


def states(row):
    return row["labs"] * (row["labs"] - 1) * row["sent"]


def sizing_table(rows):
    lines = [f"| {' | '.join(SIZING_HEADER)} |", "|---" * len(SIZING_HEADER) + "|"]
    for row in rows:
        of_server = [f"{row['server_cpu']:.0f}", f"{row['server_mb']:.0f}", ", ".join(f"{each:.2f}" for each in row["passed"])] if row["kind"] == "nats" else ["-"] * 3
        cells = [row["labs"], {"nats": "at a server", "tcp": "by TCP, each with each"}[row["kind"]], f"{row['gateway_cpu']:.1f}", f"{row['gateway_mb']:.0f}", *of_server,
                 f"{row['p50_ms']:.1f}, {row['p99_ms']:.1f}", f"{states(row)}, {row['lost']}"]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return f"Commit {commit('gateway', 'scripts/measure_federation.py')}, {machine()}, one run of {time.strftime('%Y-%m-%d')}:\n\n" + "\n".join(lines) + "\n"


def federation_fan_out(bench):
    """Processor time of a lab that says a state of 100 robots 20 times a second to 1, 10 and 49 peers that say nothing; and of the same by TCP."""
    sizes, seconds = ((2, 4), 2) if bench.short else ((2, 11, 50), 15)
    raise_open_files()
    rows = {kind: [crowd(bench, number, kind, seconds, 1, 20) for number in sizes] for kind in ("nats", "tcp")}
    for kind, all_ in rows.items():
        for row in all_:
            print(f"  {row['labs'] - 1:>2} peers by {kind}: the sender {row['sender_cpu']:.2f} % of a core ({row['sender_idle_cpu']:.2f} when it is silent), a receiver {row['gateway_cpu']:.2f} %; lost {row['lost']}")
    ratio = {kind: all_[-1]["sender_cpu"] / all_[0]["sender_cpu"] if all_[0]["sender_cpu"] else float("nan") for kind, all_ in rows.items()}
    lost = sum(row["lost"] for all_ in rows.values() for row in all_)
    each = ", ".join(f"{row['sender_cpu']:.1f} ({row['sender_idle_cpu']:.1f} silent)" for row in rows["nats"])
    value = f"{each} % of a core; {ratio['nats']:.1f} x for {sizes[-1] - 1} peers (tcp {ratio['tcp']:.1f} x), lost {lost}"
    return lost == 0 and (bench.short or ratio["nats"] <= 1.5), value, "lost 0" + ("" if bench.short else ", at most 1.5 x")


def federation_latency(bench):
    """How long a state of 100 robots takes from bus to bus over a server on this machine, two labs, beside direct TCP, by turns."""
    seconds = 2 if bench.short else 15
    rows = {kind: [crowd.__wrapped__(bench, 2, kind, seconds, None, 20) for _ in range(1 if bench.short else 3)] for kind in ("nats", "tcp")}
    best = {kind: min(all_, key=lambda row: row["p50_ms"]) for kind, all_ in rows.items()}
    for row in best.values():
        print(f"  {told(row)}")
    ratio = best["nats"]["p50_ms"] / best["tcp"]["p50_ms"]
    return ratio <= 3, f"{best['nats']['p50_ms']:.2f} ms, direct {best['tcp']['p50_ms']:.2f} ms: {ratio:.1f} x", "at most 3 x"


@functools.cache
def seals(bench):
    """{name: microseconds} of the benchmark's lines."""
    text = subprocess.run([bench.built("bench_seals"), str(len(pose_frame(ROBOTS)))], capture_output=True, text=True, check=True).stdout
    return {name: float(us) for name, us in re.findall(r"^(\w+) +([\d.]+)", text, re.M)}


def federation_seals(bench):
    """What it costs to sign, verify, seal and unseal a state of 100 robots, and packets a second that one core verifies."""
    us = seals(bench)
    value = ", ".join(f"{name} {each:.0f} us" for name, each in us.items()) + f"; {1e6 / us['verify']:.0f} verified a second"
    return us["sign"] <= 200 and us["verify"] <= 400, value, "sign 200 us, verify 400 us"


def dhtf_files(folder, number, seconds, others=()):
    """Files of labs of DHTF that meet at the server; keys also of `others`, who are trusted."""
    names = ["shark", *(f"lab{index:02}" for index in range(1, number))]
    quick_keys([*names, *others], folder / "keys")
    files = []
    for index, lab in enumerate(names):
        lines = [f'include = ["{ROOT}/experiments/dhtf/{"shark" if lab == "shark" else "roark"}.toml"]', "[lab]", f'name = "{lab}"', "[bus]",
                 f'url = "udpm://239.255.76.67:{FIRST_BUS + index}?ttl=0&recv_buf_size=4194304"', "[shared]", f"labs = {names}".replace("'", '"'), "[run]", f"duration_s = {seconds}",
                 *(f"[shared.projection.{other}]\nscale = 2.0" for other in names[1:]), "[scenario.dhtf.requirements]", *(f"{other} = [1, 2]" for other in names[1:]),
                 "[view]", "use = false", "[gateway]", 'listen = ""', "peers = []", f'connect = "nats://127.0.0.1:{NATS_PORT}"', f'keys = "{folder / "keys" / lab}"']
        files.append(folder / f"{lab}.toml")
        files[-1].write_text("\n".join(lines) + "\n")
    return files


def dhtf_sixteen(bench, number, seconds):
    """Labs of DHTF, each a lab and a gateway process, at one server: the joint result; fails when their hashes differ."""
    folder = bench.folder()
    folder.mkdir(parents=True)
    files = dhtf_files(folder, number, seconds)
    with nats_server(folder), LabProcesses(files, folder / "out") as running:
        running.wait(patience_s=900)
    together = join_results(running.results())
    out = folder / "one"
    done = subprocess.run([PROGRAM, "run", *files, "--out", out], capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"arkmesh run of {number} labs failed: {(done.stderr.strip().splitlines() or ['it said nothing'])[-1]}")
    return together, json.loads((out / "result.json").read_text())


def federation_sixteen(bench):
    """16 labs of DHTF at one server, 32 processes: their final hash and that of one process."""
    number, seconds = (4, 40) if bench.short else (16, 600)
    together, alone = dhtf_sixteen(bench, number, seconds)
    return (together["final_hash"] == alone["final_hash"], f"{together['final_hash']} and {alone['final_hash']}, {together['wall']['speed']:.0f} simulated s per wall s", "equal")


class Watchers:
    """Clients of the server that hear what labs of DHTF let be watched, on a thread of its own."""

    def __init__(self, number):
        self.heard, self.ended, self.selector = {}, False, selectors.DefaultSelector()
        for _ in range(number):
            client = socket.create_connection(("127.0.0.1", NATS_PORT), timeout=10)
            client.sendall(b'CONNECT {"verbose":false}\r\nSUB arkmesh.dhtf.*.WATCH 1\r\n')
            client.setblocking(False)
            self.heard[client] = 0
            self.selector.register(client, selectors.EVENT_READ)
        self.thread = threading.Thread(target=self.hear)
        self.thread.start()

    def hear(self):
        while not self.ended:
            for key, _ in self.selector.select(0.2):
                data = key.fileobj.recv(1 << 18)
                self.heard[key.fileobj] += len(data)
                if data.endswith(b"PING\r\n"):
                    key.fileobj.sendall(b"PONG\r\n")
                if not data:
                    self.selector.unregister(key.fileobj)

    def end(self):
        self.ended = True
        self.thread.join()
        for client in self.heard:
            client.close()


def cpu_of_ended():
    """Of this process's children that have ended; those that run do not count yet."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def watched_pair(bench, watchers, seconds):
    """Two labs of DHTF, a page and so many watchers: the labs' and gateways' processor time per simulated second, and the server's in % of a core."""
    folder = bench.folder()
    folder.mkdir(parents=True)
    files = dhtf_files(folder, 2, seconds, ["watcher"])
    page = [PROGRAM, "view", "--federation", f"nats://127.0.0.1:{NATS_PORT}", "--experiment", "dhtf", "--keys", folder / "keys/watcher", "--port", str(VIEW_PORT)]
    with contextlib.ExitStack() as ending:
        server, said = ending.enter_context(nats_server(folder)), ending.enter_context(open(folder / "view.txt", "wb"))
        view = subprocess.Popen(page, stdin=subprocess.DEVNULL, stdout=said, stderr=said, preexec_fn=end_with_parent)
        ending.callback(view.wait)
        ending.callback(view.kill)
        clients = Watchers(watchers)
        ending.callback(clients.end)
        used, begin = (cpu_of_ended(), cpu_s(server)), time.monotonic()
        with LabProcesses(files, folder / "out") as running:
            running.wait(patience_s=900)
            took, of_server = time.monotonic() - begin, cpu_s(server) - used[1]
        of_labs, result = cpu_of_ended() - used[0], join_results(running.results())
        if view.poll() is not None:
            raise Failed(f"the page has ended: {(folder / 'view.txt').read_text().strip()[-200:]}")
        heard = sorted(clients.heard.values())
    return {"ms": 1000 * of_labs / seconds, "server": 100 * of_server / took, "hash": result["final_hash"], "speed": seconds / took, "heard": heard}


def federation_watchers(bench):
    """A hundred watchers, and none, by turns, of two labs of DHTF at one server: the labs' and gateways' processor time, and their hashes; writes the sentence of
    docs/federation.md (full form)."""
    number, pairs, seconds = (10, 1, 600) if bench.short else (100, 12, 6000)
    raise_open_files()
    rows = {0: [], number: []}
    for pair in range(pairs):
        for watchers in sorted(rows, reverse=pair % 2 == 1):
            row = watched_pair(bench, watchers, seconds)
            rows[watchers].append(row)
            heard = f", each heard {row['heard'][0] / 1e6:.2f} to {row['heard'][-1] / 1e6:.2f} MB" if watchers else ""
            print(f"  {watchers} watchers: {row['ms']:.3f} ms of processor time per simulated s, server {row['server']:.1f} %; "
                  f"{row['speed']:.0f} simulated s per wall s{heard}", flush=True)
    ms, server = ({watchers: statistics.fmean(row[what] for row in all_) for watchers, all_ in rows.items()} for what in ("ms", "server"))
    ratios = [row["ms"] / without["ms"] for row, without in zip(rows[number], rows[0])]
    ratio, half = statistics.fmean(ratios), (intervals.mean(ratios).high - intervals.mean(ratios).low) / 2
    hashes = {row["hash"] for all_ in rows.values() for row in all_}
    all_heard = all(row["heard"][0] > 0.9 * row["heard"][-1] > 0 for row in rows[number])
    met = len(hashes) == 1 and all_heard and (bench.short or ratio <= 1.05)
    if met and not bench.short:
        write_between(PAGE, WATCHERS_PLACE, (
            f"{number} watchers change no result. With them, all on one machine, two labs of DHTF and their gateways need {ratio:.2f} times (95 % interval {ratio - half:.2f} to\n"
            f"{ratio + half:.2f}, {pairs} pairs of runs) the {ms[0]:.2f} ms of processor time that a simulated second takes without, and the server {server[number]:.0f} % of a core instead of\n"
            f"{server[0]:.0f} %. Commit {commit('gateway', 'scripts/measure_federation.py')}, {machine()}, {time.strftime('%Y-%m-%d')}.\n"))
    value = (f"{ratio:.3f} x{'' if bench.short else f' +- {half:.3f}'}; server {server[0]:.1f} and {server[number]:.1f} %; {len(hashes)} hash of {2 * pairs} runs"
             f"{'' if all_heard else '; some did not hear all'}")
    return met, value, "equal hashes" + ("" if bench.short else ", at most 1.05 x")


def raise_open_files():
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 65536), hard))


FEDERATION = [federation_crowd, federation_fan_out, federation_latency, federation_seals, federation_sixteen, federation_watchers]
NOT_JUDGED_SHORT = {federation_latency, federation_seals}
