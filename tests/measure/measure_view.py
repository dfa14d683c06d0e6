"""What the page of labs costs them."""
import json
import subprocess

from lab_processes import PROGRAM, Failed
from page_viewers import watched

ROUNDS = 3


def hash_and_cost(bench, viewers, stopped=0, page=True):
    """Of the two DHTF labs in one process: the final hash, their CPU time in seconds, and the bytes that viewers read."""
    out = bench.folder()
    command = [PROGRAM, "run", *bench.pair_files, "--seed", "1", "--out", out, "--set", f"run.duration_s={bench.seconds}", "--set", f"view.use={str(page).lower()}"]
    try:
        cpu_s, read = watched(command, bench.scratch / "said.txt", viewers, stopped)
    except (OSError, subprocess.CalledProcessError) as failure:
        raise Failed(f"a run with a page failed: {failure}") from None
    return json.loads((out / "result.json").read_text())["final_hash"], cpu_s, read


def judged(bench, below, words, viewers, stopped=0):
    """Runs with viewers and runs without a page in turn: what the page costs in per cent of CPU time, and whether all hashes are one."""
    alone, seen = zip(*((hash_and_cost(bench, 0, page=False), hash_and_cost(bench, viewers, stopped)) for _ in range(ROUNDS)))
    least = min(run[1] for run in alone)
    cost, same, read = 100 * (min(run[1] for run in seen) - least) / least, len({run[0] for run in alone + seen}) == 1, sum(run[2] for run in seen)
    return cost < below and same and bool(read) == bool(viewers), f"{cost:+.1f} % CPU time, {read / 1e6:.0f} MB read, hashes {'equal' if same else 'DIFFER'}", words


def view_one(bench):
    """a viewer of the two DHTF labs in one process"""
    return judged(bench, 2, "at most 2 % of the labs' speed", 1)


def view_ten(bench):
    """ten viewers of the two DHTF labs in one process"""
    return judged(bench, 5, "below 5 % of the labs' speed", 10)


def view_stopped(bench):
    """a viewer that reads nothing"""
    return judged(bench, 1, "nothing: below 1 %", 0, 1)


def view_nobody(bench):
    """a page that nobody watches"""
    return judged(bench, 1, "nothing: below 1 %", 0)


MEASURES = [view_one, view_ten, view_stopped, view_nobody]
NOT_JUDGED_SHORT = set(MEASURES)
