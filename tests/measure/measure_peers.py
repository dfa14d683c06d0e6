"""Figures beside other people's programs, which the user has built; without them a row is left out.

ARKMESH_KILOMBO: a folder with Kilombo's programs walk_SIDE, as docs/simulator-speed.md builds them.
ARKMESH_TUNNEL: libbot2's program bot-lcm-tunnel, built with -O2.
"""
import json
import os
import pathlib
import statistics

from lab_processes import PROGRAM, ROOT, Failed
from pages import measured, table, write_between

KILOMBO = os.environ.get("ARKMESH_KILOMBO", "")
TUNNEL = os.environ.get("ARKMESH_TUNNEL", "")
# robots, per m2, seconds that Kilombo simulates, and what "ode" and "fast" must reach of it
SIZES = [(100, 48, 4000, 0.55, 1.10), (1000, 48, 400, 1.0, 1.50), (10000, 48, 20, 1.9, 3.0),
         (100, 400, 2000, 0.24, 0.75), (1000, 400, 200, 0.46, 1.50), (10000, 400, 10, 0.60, 2.6)]
ROUNDS = 3
KILOMBO_PLACE = "beside Kilombo: written by scripts/measure peers_kilombo"


def kilombo_rate(bench, folder, robots, per_m2, seconds):
    """Robot-seconds per second of processor time."""
    side_mm = round((robots / per_m2) ** 0.5 * 1000)
    program = pathlib.Path(KILOMBO).resolve() / f"walk_{side_mm}"
    if not program.exists():
        raise Failed(f"{program} is not there; docs/simulator-speed.md says how it is built")
    settings = {"nBots": robots, "randSeed": 1, "timeStep": 1 / 31, "simulationTime": seconds, "commsRadius": 100, "msgSuccessRate": 0.8, "distanceNoise": 2,
                "useGrid": 1, "GUI": 0, "storeHistory": 0, "stateFileSteps": 0, "displayWidth": side_mm, "displayHeight": side_mm, "distributePercent": 0.95}
    (folder / "kilombo.json").write_text(json.dumps(settings))
    return robots * seconds / bench.child(program, "-p", "kilombo.json", cwd=folder)[1]["cpu_s"]


def our_rates(bench, robots, per_m2):
    """The same of both solvers, as {solver: rate}, and the share of ODE's own step in "ode"."""
    rows = {row["name"].split("/")[0]: row for row in bench.rows("bench_simulator", f"^(ode|fast)/{robots}_at_{per_m2}$", "--benchmark_repetitions=1",
                                                                 "--benchmark_report_aggregates_only=false")}
    return {solver: row["robot_s_per_cpu_s"] for solver, row in rows.items()} | {"step": rows["ode"]["step_share"]}


def peers_kilombo(bench):
    """Both solvers beside Kilombo by turns, at 48 and 400 robots a square metre; medians."""
    if not KILOMBO:
        return None
    folder, told, met, rows = bench.folder(), [], True, []
    heads = ["robots", "Kilombo, robot-s per CPU s", '`"ode"` of it (must)', 'ODE\'s step, share of `"ode"`', "the step alone, of Kilombo", '`"fast"` of it (must)']
    for robots, per_m2, seconds, *goals in SIZES:
        turns = [(kilombo_rate(bench, folder, robots, per_m2, seconds), our_rates(bench, robots, per_m2)) for _ in range(ROUNDS)]
        peer = statistics.median(rate for rate, _ in turns)
        shares = [statistics.median(ours[solver] / rate for rate, ours in turns) for solver in ("ode", "fast")]
        met = met and all(share >= goal for share, goal in zip(shares, goals))
        step = statistics.median(ours["step"] for _, ours in turns)
        told.append("/".join(f"{share:.2f}" for share in shares))
        print(f"  {robots} robots at {per_m2}/m2: Kilombo {peer / 1e3:.0f} k, ode {shares[0]:.2f} ({goals[0]}), ODE's step {step:.0%} of that, fast {shares[1]:.2f} ({goals[1]}) of it", flush=True)
        rows.append([f"{robots} at {per_m2}/m2", f"{peer / 1e3:.0f} k", f"{shares[0]:.2f} ({goals[0]})", f"{step:.0%}", f"{shares[0] / step:.2f}", f"{shares[1]:.2f} ({goals[1]})"])
    write_between(ROOT / "docs/simulator-speed.md", KILOMBO_PLACE, f"{measured(runs=f'medians of {ROUNDS} turns on ')}:\n\n{table(heads, rows)}")
    return met, f"ode/fast of Kilombo: {' '.join(told)}", " ".join(f"{ode}/{fast}" for *_, ode, fast in SIZES)


def peers_tunnel(bench):
    """100 kB messages of two gateways and of bot-lcm-tunnel by turns: most without loss, processor time of both ends, p99."""
    if not TUNNEL:
        return None
    words = bench.say(bench.built("bench_gateway"), 2, PROGRAM, TUNNEL).split()
    values = dict(zip(words[1::2], map(float, words[2::2])))
    most = values["gateways_most"] / values["tunnel_most"]
    return (most >= 1.1 and values["gateways_cpu_us"] <= 230,
            f"{most:.2f} of its rate ({values['tunnel_most']:.0f}/s); {values['gateways_cpu_us']:.0f} us beside {values['tunnel_cpu_us']:.0f} us; "
            f"p99 {values['gateways_p99_us']:.0f} us beside {values['tunnel_p99_us']:.0f} us", "1.1; 230 us")


MEASURES = [peers_kilombo, peers_tunnel]
NOT_JUDGED_SHORT = set(MEASURES)
