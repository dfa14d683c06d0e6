"""Figures of the physical side, taken in the virtual room: how well and how fast robots are tracked, and whether an experiment notices the difference."""
import json
import re
import statistics
import subprocess

from lab_processes import PROGRAM, ROOT, Failed

DHTF = ROOT / "experiments/dhtf"


def lines_of(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"{command[0]} ended with {done.returncode}: {(done.stderr.strip() or 'it said nothing')[-200:]}")
    return done.stdout


def table_accuracy(bench):
    """100 robots walking in 1 m2 before one camera of 1920 x 1080, ten minutes: tracked, against the truth."""
    text = lines_of([bench.built("track_in_room"), ROOT / "experiments/room/hundred.toml", str(20 if bench.short else 600)])
    print("\n".join("  " + line.strip() for line in text.splitlines()))

    def value(name):
        return float(re.search(rf"{name}\s+([\d.]+)", text)[1])
    tracked, wrong, centre, heading = value("tracked"), value("wrong ids"), value("centre RMS"), value("heading RMS, LED on")
    met = tracked >= 99.9 and wrong == 0 and centre < 1 and heading < 5
    return met, f"{tracked:.2f} % tracked, {wrong:.0f} wrong ids, centre {centre:.2f} mm, heading {heading:.1f} deg RMS", "99.9 %, 0, 1 mm, 5 deg"


def table_speed(bench):
    """From a decoded picture of 2048 x 1536 with 100 robots to poses, one core, beside OpenCV's HoughCircles on the same picture."""
    command = [bench.built("bench_tracker"), "--benchmark_format=json", f"--benchmark_min_time={0.2 if bench.short else 2}"]
    cpu_ms = {row["name"].removesuffix("/iterations:200"): row["cpu_time"] for row in json.loads(lines_of(command))["benchmarks"]}
    ours, hough = cpu_ms["whole_way/100"], cpu_ms["hough_circles/100"]
    print(f"  reading the JPEG {cpu_ms['read_jpeg/100']:.1f} ms, whole search {cpu_ms['search/100']:.1f} ms, following {cpu_ms['follow/100']:.1f} ms, "
          f"both by turns {cpu_ms['ten_frames/100']:.1f} ms, HoughCircles {hough:.1f} ms; 250 robots, to poses {cpu_ms['whole_way/250']:.1f} ms")
    return ours < 12 and hough >= 8 * ours, f"{ours:.1f} ms a picture, {hough / ours:.1f}x HoughCircles", "12 ms, 8x"


def table_dhtf(bench):
    """DHTF, all easy, with roark on a table in the virtual room and with roark in ODE: completed tasks."""
    seconds, seeds = (30, [1]) if bench.short else (600, [1, 2, 3])
    completed = {}
    for kind, file in (("room", "roark_room.toml"), ("ode", "roark.toml")):
        for seed in seeds:
            out = bench.folder()
            lines_of([PROGRAM, "run", DHTF / "shark.toml", DHTF / file, "--set", f"run.duration_s={seconds}", "--set", "scenario.dhtf.types=easy",
                      "--set", "arena.kilobot.window=false", "--seed", str(seed), "--out", out])
            completed.setdefault(kind, []).append(json.loads((out / "result.json").read_text())["counts"]["completed"])
    room, ode = (statistics.mean(completed[kind]) for kind in ("room", "ode"))
    off = 100 * (room / ode - 1) if ode else float("nan")
    spread = {kind: f" sd {statistics.stdev(values):.1f}" if len(values) > 1 else "" for kind, values in completed.items()}
    value = f"room {room:.1f}{spread['room']}, ODE {ode:.1f}{spread['ode']}: {off:+.0f} %"
    return (room > 0 if bench.short else abs(off) <= 25), value, "tasks" if bench.short else "within 25 %"


TABLE = [table_accuracy, table_speed, table_dhtf]
NOT_JUDGED_SHORT = {table_speed}
