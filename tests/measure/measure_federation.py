"""Figures of labs that meet at a NATS server: fifty at once beside direct TCP, what a sender pays by the number of its peers, how long a message takes, what
signatures cost, sixteen labs of DHTF, and what watchers cost the labs. See scripts/measure."""
import contextlib
import re
import resource
import selectors
import socket
import statistics
import threading
import time

import intervals
from joined_networks import make_keys
from lab_bus import pose_frame
from lab_processes import PROGRAM, ROOT, Failed, LabProcesses, begin, end_all, join_results, last_line
from measure_links import FIRST_BUS, NATS_PORT, cpu_s, crowd, nats_server, raise_open_files, told
from pages import measured, table, write_between

SOURCES = ("gateway", "tests/measure/measure_federation.py")
PAGE, SIZING_PLACE = ROOT / "docs/federation.md", "sizing: written by scripts/measure federation_crowd"
SIZING_HEADER = ["labs", "joined", "a gateway: % of a core", "MB", "the server: % of a core", "MB", "MB/s in, out", "p50, p99 ms", "states, lost"]
WATCHERS_PLACE, VIEW_PORT = "watchers: written by scripts/measure federation_watchers", 7972


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
        write_between(PAGE, SIZING_PLACE, f"{measured(*SOURCES)}:\n\n{table(SIZING_HEADER, map(sizing_row, rows))}")
    value = (f"lost {nats['lost']} of {states(nats)}; server {nats['server_cpu']:.0f} %, a gateway {nats['gateway_cpu']:.1f} %; "
             f"p50 {nats['p50_ms']:.1f} (tcp {tcp['p50_ms']:.1f}), p99 {nats['p99_ms']:.1f} ({tcp['p99_ms']:.1f}) ms")
    return nats["lost"] == 0 and nats["refused"] == 0, value, "lost 0, refused 0"


def states(row):
    return row["labs"] * (row["labs"] - 1) * row["sent"]


def sizing_row(row):
    of_server = [f"{row['server_cpu']:.0f}", f"{row['server_mb']:.0f}", ", ".join(f"{each:.2f}" for each in row["passed"])] if row["kind"] == "nats" else ["-"] * 3
    return [row["labs"], {"nats": "at a server", "tcp": "by TCP, each with each"}[row["kind"]], f"{row['gateway_cpu']:.1f}", f"{row['gateway_mb']:.0f}", *of_server,
            f"{row['p50_ms']:.1f}, {row['p99_ms']:.1f}", f"{states(row)}, {row['lost']}"]


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
    rows = {kind: [crowd.__wrapped__(bench, 2, kind, 15, None, 20) for _ in range(3)] for kind in ("nats", "tcp")}
    best = {kind: min(all_, key=lambda row: row["p50_ms"]) for kind, all_ in rows.items()}
    for row in best.values():
        print(f"  {told(row)}")
    ratio = best["nats"]["p50_ms"] / best["tcp"]["p50_ms"]
    return ratio <= 3, f"{best['nats']['p50_ms']:.2f} ms, direct {best['tcp']['p50_ms']:.2f} ms: {ratio:.1f} x", "at most 3 x"


def federation_seals(bench):
    """What it costs to sign, verify, seal and unseal a state of 100 robots, and packets a second that one core verifies."""
    us = {name: float(us) for name, us in re.findall(r"^(\w+) +([\d.]+)", bench.say(bench.built("bench_seals"), len(pose_frame(100))), re.M)}
    value = ", ".join(f"{name} {each:.0f} us" for name, each in us.items()) + f"; {1e6 / us['verify']:.0f} verified a second"
    return us["sign"] <= 200 and us["verify"] <= 400, value, "sign 200 us, verify 400 us"


def dhtf_files(folder, number, seconds, others=()):
    """Files of labs of DHTF that meet at the server; keys also of `others`, who are trusted."""
    names = ["shark", *(f"lab{index:02}" for index in range(1, number))]
    make_keys([*names, *others], folder / "keys")
    files = []
    for index, lab in enumerate(names):
        lines = [f'include = ["{ROOT}/experiments/dhtf/{"shark" if lab == "shark" else "roark"}.toml"]', "[lab]", f'name = "{lab}"', "[bus]",
                 f'url = "udpm://239.255.76.67:{FIRST_BUS + index}?ttl=0&recv_buf_size=4194304"', "[shared]", f"labs = {names}".replace("'", '"'), "[run]", f"duration_s = {seconds}",
                 *(f"[shared.projection.{other}]\nscale = 2.0" for other in names[1:]), "[scenario.dhtf.requirements]", *(f"{other} = [1, 2]" for other in names[1:]),
                 "[view]", "use = false", "[gateway]", 'listen = ""', "peers = []", f'connect = "nats://127.0.0.1:{NATS_PORT}"', f'keys = "{folder / "keys" / lab}"']
        files.append(folder / f"{lab}.toml")
        files[-1].write_text("\n".join(lines) + "\n")
    return files


def federation_sixteen(bench):
    """16 labs of DHTF at one server, 32 processes: their final hash and that of one process."""
    folder = bench.folder()
    files = dhtf_files(folder, *((4, 40) if bench.short else (16, 600)))
    with nats_server(folder), LabProcesses(files, folder / "out") as running:
        running.wait(patience_s=900)
    together, alone = join_results(running.results()), bench.run(*files)
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
    files = dhtf_files(folder, 2, seconds, ["watcher"])
    page = [PROGRAM, "view", "--federation", f"nats://127.0.0.1:{NATS_PORT}", "--experiment", "dhtf", "--keys", folder / "keys/watcher", "--port", str(VIEW_PORT)]
    with contextlib.ExitStack() as ending:
        server = ending.enter_context(nats_server(folder))
        view = begin(page, folder / "view.txt")
        ending.callback(end_all, [view])
        clients = Watchers(watchers)
        ending.callback(clients.end)
        used, began = (cpu_of_ended(), cpu_s(server)), time.monotonic()
        with LabProcesses(files, folder / "out") as running:
            running.wait(patience_s=900)
            took, of_server = time.monotonic() - began, cpu_s(server) - used[1]
        of_labs, result = cpu_of_ended() - used[0], join_results(running.results())
        if view.poll() is not None:
            raise Failed(f"the page has ended: {last_line((folder / 'view.txt').read_text())}")
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
            f"{server[0]:.0f} %. {measured(*SOURCES, runs='')}.\n"))
    value = (f"{ratio:.3f} x{'' if bench.short else f' +- {half:.3f}'}; server {server[0]:.1f} and {server[number]:.1f} %; {len(hashes)} hash of {2 * pairs} runs"
             f"{'' if all_heard else '; some did not hear all'}")
    return met, value, "equal hashes" + ("" if bench.short else ", at most 1.05 x")


MEASURES = [federation_crowd, federation_fan_out, federation_latency, federation_seals, federation_sixteen, federation_watchers]
NOT_JUDGED_SHORT = {federation_latency, federation_seals}
