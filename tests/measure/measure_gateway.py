"""Figures of gateways, from bus to bus, each beside its parts in the same run: a hop of LCM and a hop of loopback TCP."""
import functools

from lab_processes import PROGRAM

SIZES = ("100", "1000", "10000", "100000")


@functools.cache
def rows(bench):
    """{(kind, bytes, rate): {name: value}} of the benchmark's lines, which are printed, too."""
    text = bench.say(bench.built("bench_gateway"), 2, PROGRAM)
    print("\n".join("  " + line for line in text.splitlines()))
    found = {}
    for line in text.splitlines():
        words = line.split()
        values = dict(zip(words[1::2], words[2::2])) if words[0] != "sustained" else {"bytes": words[2], "tcp": words[4], "tcp_goal": words[6], "tls": words[8], "tls_goal": words[10]}
        found[words[0], values["bytes"], values.get("rate", "")] = {name: float(value) for name, value in values.items()}
    return found


def gateway_latency(bench):
    """Median time from bus to bus through two gateways, 100 B and 1 kB at 500 a second, beside two hops of LCM and one of TCP."""
    of_parts = max(rows(bench)["latency", size, "500"]["of_parts"] for size in SIZES[:2])
    return of_parts <= 1.15, f"{of_parts:.2f} x its parts", "1.15 x"


def gateway_latency_rare(bench):
    """The same with 20 messages a second both ways."""
    of_parts = rows(bench)["latency", "100", "20"]["of_parts"]
    return of_parts <= 1.38, f"{of_parts:.2f} x its parts", "1.2 x 1.15 x"


def gateway_latency_tls(bench):
    """What TLS adds to it, 100 B and 1 kB."""
    more = max(rows(bench)["latency", size, "500"]["tls_more_us"] for size in SIZES[:2])
    return more <= 25, f"{more:.0f} us", "25 us"


def gateway_cpu(bench):
    """Processor time of both gateways for a message of 100 B and 1 kB at 10,000 a second, with acknowledgements."""
    cost = [rows(bench)["cpu", size, "10000"] for size in SIZES[:2]]
    return max(row["tcp_us"] for row in cost) <= 12, ", ".join(f"{row['tcp_us']:.1f} us (TLS {row['tls_us']:.1f})" for row in cost), "12 us"


def gateway_cpu_large(bench):
    """The same for 100 kB at 500 a second."""
    row = rows(bench)["cpu", "100000", "500"]
    return row["tcp_us"] <= 120, f"{row['tcp_us']:.0f} us (TLS {row['tls_us']:.0f})", "120 us"


def gateway_sustained(bench):
    """Messages a second that pass without loss, the least part of its goal of 100 B, 1 kB, 10 kB, 100 kB."""
    found = [rows(bench)["sustained", size, ""] for size in SIZES]
    parts = {kind: min(row[kind] / row[f"{kind}_goal"] for row in found) for kind in ("tcp", "tls")}
    values = {kind: " / ".join(f"{row[kind] / 1000:g}" for row in found) for kind in ("tcp", "tls")}
    return min(parts.values()) >= 1, f"{values['tcp']} k/s; TLS {values['tls']} k/s", "80 / 80 / 35 / 6.5; 60 / 60 / 25 / 4 k/s"


MEASURES = [gateway_latency, gateway_latency_rare, gateway_latency_tls, gateway_cpu, gateway_cpu_large, gateway_sustained]
NOT_JUDGED_SHORT = set(MEASURES)
