"""Figures of gateways as real processes: what labs cost that are joined each with each or at a NATS server, what poses take on the wire, what an idle gateway
holds. See scripts/measure."""
import contextlib
import functools
import json
import os
import pathlib
import re
import resource
import threading
import time
import urllib.request

import joined_networks
from joined_networks import call, join_by_tls, make_keys
from lab_bus import BusEar, Talkers, gateway_file
from lab_processes import Failed, LabProcesses, until

FIRST_BUS, FIRST_PORT, NATS_PORT, MONITOR_PORT = 7720, 7840, 7970, 7971
CARRIES_POSES = ["exports = []", 'ordered = ["poses"]', 'imports = ["poses"]']


def cpu_s(process):
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def shares(processes, during):
    """({name: % of a core}, seconds, the result) of processes while something is done."""
    before, begin = {name: cpu_s(process) for name, process in processes.items()}, time.monotonic()
    result = during()
    took = time.monotonic() - begin
    return {name: 100 * (cpu_s(process) - before[name]) / took for name, process in processes.items()}, took, result


def memory_mb(process):
    """Resident, and private of it."""
    text = pathlib.Path(f"/proc/{process.pid}/smaps_rollup").read_text()
    return tuple(sum(map(int, re.findall(rf"^{name}:\s+(\d+)", text, re.M))) / 1024 for name in ("Rss", "Private_(?:Clean|Dirty)"))


@contextlib.contextmanager
def gateways(files, folder, enter=None, sets=None):
    """{lab: process}"""
    labs = LabProcesses(files.values(), folder, own_overrides=sets, enter=enter)
    try:
        for lab in files:
            labs.start("gateway", lab)
        yield {lab: labs.processes["gateway", lab] for lab in files}
        labs.running()  # none has ended
    finally:
        labs.stop()


def nats_server(folder):
    """A server on this machine, ready: its process."""
    return joined_networks.nats_server(folder, f'listen: "127.0.0.1:{NATS_PORT}"\nhttp: "127.0.0.1:{MONITOR_PORT}"\nmax_pending: 64MB\n')


def server_bytes():
    """What the server has taken and given, by itself."""
    with urllib.request.urlopen(f"http://127.0.0.1:{MONITOR_PORT}/varz", timeout=10) as told:
        of = json.load(told)
    return of["in_bytes"], of["out_bytes"]


def part(values, of):
    return values[min(len(values) - 1, int(of * len(values)))] if values else float("nan")


def gateway_counters(bus):
    """{counter: value} of what a gateway says of itself on its lab's bus, peers' own added up."""
    ear = BusEar(bus, ["peers"])
    until(5, lambda: "peers" in ear.newest, "a gateway says nothing of itself")
    ear.ended = True
    return ear.counters()


def raise_open_files():
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 65536), hard))


def write_files(folder, names, kind):
    """Labs that meet at the server, or are joined by TCP or TLS each with each: {lab: file}."""
    files, scheme = {}, "tls://" if kind == "tls" else ""
    if kind != "tcp":
        make_keys(names, folder / "keys")
    for index, lab in enumerate(names):
        lines = [*CARRIES_POSES, f'keys = "{folder / "keys" / lab}"']
        if kind == "nats":
            lines.append(f'connect = "nats://127.0.0.1:{NATS_PORT}"')
        else:
            lines.append(f'listen = "{scheme}127.0.0.1:{FIRST_PORT + index}"')
            for earlier, other in enumerate(names):
                if other != lab:
                    lines += ["[[gateway.peers]]", f'lab = "{other}"', *([f'connect = "{scheme}127.0.0.1:{FIRST_PORT + earlier}"'] if earlier < index else [])]
        files[lab] = gateway_file(folder, lab, FIRST_BUS + index, names, lines)
    return files


@functools.cache
def crowd(bench, number, kind, seconds, speakers=None, rate_hz=1, at_once=False):
    """So many labs, all or some of which say a state of 100 robots: what that costs, and how long states take."""
    folder, names = bench.folder(), [f"lab{index:02}" for index in range(number)]
    files = write_files(folder, names, kind)
    labs = {lab: FIRST_BUS + index for index, lab in enumerate(names)}
    with contextlib.ExitStack() as ending:
        server = ending.enter_context(nats_server(folder)) if kind == "nats" else None
        running = ending.enter_context(gateways(files, folder))
        talkers = Talkers(labs, 100, rate_hz, names[:speakers], at_once)
        ending.callback(talkers.end)
        talkers.until_joined()
        talkers.talk(2)
        watched = running | ({"server": server} if server else {})
        idle = shares(watched, lambda: talkers.hear(5 if speakers == 1 else 0))[0][names[0]]
        bytes_before = server_bytes() if server else (0, 0)
        used, took, numbers = shares(watched, lambda: talkers.talk(seconds))
        passed = [(after - was) / took / 1e6 for was, after in zip(bytes_before, server_bytes() if server else (0, 0))]
        lost = talkers.lost(*numbers)
        latencies = talkers.latencies_ms(*numbers)
        memory = {name: memory_mb(process) for name, process in watched.items()}
        counters = [gateway_counters(labs[lab]) for lab in (names[0], names[-1])]
    others = names[1:] if speakers == 1 else names
    return {"labs": number, "kind": kind, "lost": lost, "sent": numbers[1] - numbers[0] + 1, "p50_ms": part(latencies, 0.5), "p99_ms": part(latencies, 0.99),
            "gateway_cpu": sum(used[lab] for lab in others) / len(others), "sender_cpu": used[names[0]], "sender_idle_cpu": idle,
            "gateway_mb": sum(memory[lab][0] for lab in names) / number, "private_mb": sum(memory[lab][1] for lab in names) / number,
            "server_cpu": used.get("server", 0), "server_mb": memory["server"][0] if server else 0, "passed": passed, "refused": sum(value for each in counters for name, value in each.items() if "refused" in name)}


def told(row):
    server = f"; server {row['server_cpu']:.1f} %, {row['server_mb']:.0f} MB" if row["server_mb"] else ""
    return (f"{row['labs']} labs by {row['kind']}: each gateway {row['gateway_cpu']:.2f} % of a core, {row['gateway_mb']:.1f} MB{server}; "
            f"p50 {row['p50_ms']:.2f} ms, p99 {row['p99_ms']:.2f} ms; {row['lost']} lost, {row['refused']} refused")


def mesh_figure(bench, kind):
    sizes, seconds = ((2, 4, 8), 3) if bench.short else ((4, 8, 16), 30)
    rows = [crowd(bench, number, kind, seconds, None, 10, True) for number in sizes]
    for row in rows:
        print(f"  {told(row)}; {row['gateway_cpu'] / (row['labs'] - 1):.3f} % a peer, {row['private_mb']:.2f} MB private")
    lost, first, last = sum(row["lost"] for row in rows), rows[0], rows[-1]
    ratio = (last["gateway_cpu"] / (last["labs"] - 1)) / (first["gateway_cpu"] / (first["labs"] - 1)) if first["gateway_cpu"] else float("nan")
    each_mb = (last["private_mb"] - first["private_mb"]) / (last["labs"] - first["labs"])
    value = f"lost {lost}; {last['gateway_cpu']:.1f} % of a core at {last['labs']} labs, {ratio:.2f}x a peer's cost at {first['labs']}, {each_mb:.2f} MB a peer"
    return lost == 0 and (bench.short or ratio <= 1.2), value, "lost 0" + ("" if bench.short else ", at most 1.2x a peer")


def links_mesh_tcp(bench):
    """4, 8 and 16 labs, each joined with all others over plain TCP, 100-robot poses at 10 Hz each: losses; processor time and memory of a gateway."""
    return mesh_figure(bench, "tcp")


def links_mesh_tls(bench):
    """The same over TLS."""
    return mesh_figure(bench, "tls")


@contextlib.contextmanager
def pair(bench):
    """Two labs in networks of their own, joined over TLS: (words to enter them, processes, talkers' buses)."""
    folder, labs = bench.folder(), {"shark": FIRST_BUS, "roark": FIRST_BUS + 1}
    files = {lab: gateway_file(folder, lab, bus, sorted(labs), CARRIES_POSES) for lab, bus in labs.items()}
    with joined_networks.joined_networks(list(labs)) as enter, gateways(files, folder, enter, join_by_tls(list(labs), folder / "keys")) as running:
        yield enter, running, labs


def sent_bytes(words):
    """What the cable has carried away from there, headers of Ethernet included."""
    return int(re.search(r"TX:.*\n\s*(\d+)", call(*words, "ip", "-s", "-s", "link", "show", "cable"))[1])


def links_poses(bench):
    """Poses of 1000 robots at 10 Hz to one peer over TLS: kB/s that leave the lab."""
    seconds = 3 if bench.short else 20
    with pair(bench) as (enter, _, labs):
        talkers = Talkers({"shark": labs["shark"]}, 1000, enter=enter)
        ears = Talkers({"roark": labs["roark"]}, 1, enter=enter)
        until(300, lambda: ears.came or (talkers.talk(0.2) and ears.hear(0.05)), "the two gateways do not meet", 0)
        begin, before = time.monotonic(), sent_bytes(enter["shark"])
        first, last = talkers.talk(seconds)
        rate = (sent_bytes(enter["shark"]) - before) / (time.monotonic() - begin) / 1000
        lost = ears.lost(first, last)
    return lost == 0, f"{rate:.0f} kB/s of {len(talkers.frame) * talkers.rate_hz / 1000:.0f} kB/s of messages, lost {lost}", "lost 0"


def links_idle(bench):
    """A gateway with one peer over TLS and nothing to do: memory and processor time; the larger of two."""
    seconds = 4 if bench.short else 60
    with pair(bench) as (enter, running, labs):
        # nsenter executes the program: the process is the gateway
        talkers = Talkers(labs, 1, enter=enter)
        talkers.until_joined()
        time.sleep(2)
        cpu = max(shares(running, lambda: time.sleep(seconds))[0].values())
        resident, private = (max(each) for each in zip(*(memory_mb(process) for process in running.values())))
    met = resident <= 18 and private <= 5 and (bench.short or cpu < 0.5)
    return met, f"{resident:.1f} MB resident, {private:.1f} MB private, {cpu:.2f} % of a core", "18 MB, 5 MB, 0.5 %"


def flap(words, ended):
    """Cuts the cable for 0.2 s of each 0.6 s, and for 5 s of each minute, which breaks the link; until it is told to end."""
    begin = time.monotonic()
    while not ended.is_set():
        long = (time.monotonic() - begin) % 60 < 5
        call(*words, "ip", "link", "set", "cable", "down")
        ended.wait(5 if long else 0.2)
        call(*words, "ip", "link", "set", "cable", "up")
        ended.wait(0.4)


def links_soak(bench):
    """Half an hour of cuts between two labs that say poses of 100 robots ten times a second: how gateways' resident memory changes after five minutes."""
    with pair(bench) as (enter, running, labs):
        talkers, ended, rows, begin = Talkers(labs, 100, enter=enter), threading.Event(), [], time.monotonic()
        talkers.until_joined()
        flapping = threading.Thread(target=flap, args=(enter["shark"], ended), daemon=True)
        flapping.start()
        try:
            for _ in range(30):
                talkers.talk(60)
                rows.append([memory_mb(process)[0] for process in running.values()])
                came = sum(map(len, talkers.came.values()))
                print(f"  minute {len(rows)}: {', '.join(f'{lab} {mb:.2f} MB' for lab, mb in zip(running, rows[-1]))}, {came} messages came", flush=True)
                if came == 0:
                    raise Failed("nothing has crossed for a minute")
                for way in talkers.came.values():
                    way.clear()
        finally:
            ended.set()
            flapping.join()
    changes = [100 * (last / first - 1) for first, last in zip(rows[4], rows[-1])]
    return max(map(abs, changes)) < 2, f"{', '.join(f'{change:+.2f} %' for change in changes)} in {(time.monotonic() - begin) / 60:.0f} min", "within 2 %"


MEASURES = [links_mesh_tcp, links_mesh_tls, links_poses, links_idle, links_soak]
NOT_JUDGED_SHORT = {links_soak}
