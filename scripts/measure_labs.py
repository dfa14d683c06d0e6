"""What it costs to have many labs in one process."""
import json
import os
import shutil
import subprocess

from lab_processes import PROGRAM, ROOT, Failed

ROUNDS = 3
LAB = """
[lab]
name = "{name}"
[run]
scenario = "light_up"
duration_s = {seconds}
[gate]
period_s = 1
[shared]
labs = [{labs}]
[arena]
robots = 12
width_m = 0.5
height_m = 0.5
[arena.ode]
controller = "{program}"
solver = "{solver}"
"""


def run_labs(bench, number, solver="ode"):
    """light_up of so many labs of 12 robots, a period of 1 s, in one process: (simulated seconds in one of the wall, CPU seconds, peak MB)."""
    seconds = (240 if bench.short else 4800) // number
    folder = bench.folder()
    folder.mkdir()
    names = [f"l{i:02}" for i in range(number)]
    files = [folder / f"{name}.toml" for name in names]
    for name, file in zip(names, files):
        file.write_text(LAB.format(name=name, seconds=seconds, labs=", ".join(f'"{n}"' for n in names), solver=solver,
                                   program=ROOT / "experiments/light_up/light_up.c"))
    with open(bench.scratch / "said.txt", "w+") as said:
        process = subprocess.Popen([PROGRAM, "run", *files, "--out", folder / "run", "--set", "view.use=false"], stdout=said, stderr=said)
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            said.seek(0)
            raise Failed(f"a run of {number} labs failed: {(said.read().strip().splitlines() or ['it said nothing'])[-1]}")
    speed = json.loads((folder / "run/result.json").read_text())["wall"]["speed"]
    shutil.rmtree(folder)
    return speed, (usage.ru_utime + usage.ru_stime) / seconds, usage.ru_maxrss / 1024


def fastest(bench, numbers, solver="ode"):
    """{number: (speed, CPU seconds of a simulated one, peak MB)}: the fastest of some runs of each, by turns."""
    all_ = {number: [] for number in numbers}
    for _ in range(1 if bench.short else ROUNDS):
        for number in numbers:
            all_[number].append(run_labs(bench, number, solver))
    return {number: max(rows) for number, rows in all_.items()}


def labs_sixteen(bench):
    """16 labs of 12 robots in one process: simulated seconds in one of the wall, with each solver."""
    ode, fast = (fastest(bench, [16], solver)[16][0] for solver in ("ode", "fast"))
    return ode >= 400, f"{ode:.0f}, with the fast solver {fast:.0f}", "400"


def labs_growth(bench):
    """What a lab of 16 costs beside a lab of 4, in CPU time and in memory."""
    of = fastest(bench, [4, 8, 16])
    for number, (speed, cpu_s, peak_mb) in of.items():
        print(f"  {number} labs: {speed:.0f} simulated s per wall s, {1e6 * cpu_s / number:.0f} us of CPU per lab and simulated s, {peak_mb / number:.1f} MB per lab")
    cpu, memory = (of[16][i] / 16 / (of[4][i] / 4) for i in (1, 2))
    return max(cpu, memory) <= 1.5, f"CPU {cpu:.2f}, memory {memory:.2f} of a lab of 4", "1.5"


LABS = [labs_sixteen, labs_growth]
NOT_JUDGED_SHORT = set(LABS)
