"""What the page of labs costs them."""
import json
import subprocess

from lab_processes import Failed
from page_viewers import watched

ROUNDS = 3


def hash_and_cost(bench, files, viewers, stopped=0, page=True):
    """The final hash, the least CPU time of the labs in seconds, and the bytes that viewers read in all runs."""
    out = bench.folder()
    command = [bench.program, "run", *files, "--seed", "1", "--out", out, "--set", f"run.duration_s={bench.seconds}"]
    try:
        cpu_s, read = watched([*command, *([] if page else ["--set", "view.use=false"])], bench.scratch / "said.txt", viewers, stopped)
    except (OSError, subprocess.CalledProcessError) as failure:
        raise Failed(f"a run with a page failed: {failure}") from None
    return json.loads((out / "result.json").read_text())["final_hash"], cpu_s, read


def compared(bench, files, viewers, stopped=0):
    """Runs with viewers and runs without a page in turn: (cost in per cent of CPU time, whether all hashes are one, bytes read)."""
    alone, seen = [], []
    for _ in range(ROUNDS):
        alone.append(hash_and_cost(bench, files, 0, page=False))
        seen.append(hash_and_cost(bench, files, viewers, stopped))
    least = min(run[1] for run in alone)
    return 100 * (min(run[1] for run in seen) - least) / least, len({run[0] for run in alone + seen}) == 1, sum(run[2] for run in seen)


def result(bench, met, cost, same, read, target):
    return met and same, f"{cost:+.1f} % CPU time, {read / 1e6:.0f} MB read, hashes {'equal' if same else 'DIFFER'}", target


def view_ten(bench):
    """ten viewers of the two DHTF labs in one process"""
    cost, same, read = compared(bench, bench.pair_files, 10)
    return result(bench, cost < 5 and read > 0, cost, same, read, "below 5 % of the labs' speed")


def view_one(bench):
    """a viewer of the two DHTF labs in one process"""
    cost, same, read = compared(bench, bench.pair_files, 1)
    return result(bench, cost < 2 and read > 0, cost, same, read, "at most 2 % of the labs' speed")


def view_stopped(bench):
    """a viewer that reads nothing"""
    cost, same, read = compared(bench, bench.pair_files, 0, 1)
    return result(bench, cost < 1, cost, same, read, "nothing: below 1 %")


def view_nobody(bench):
    """a page that nobody watches"""
    cost, same, read = compared(bench, bench.pair_files, 0)
    return result(bench, cost < 1, cost, same, read, "nothing: below 1 %")


MEASURES = [view_one, view_ten, view_stopped, view_nobody]
NOT_JUDGED_SHORT = set(MEASURES)
