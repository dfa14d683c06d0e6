"""Places in documents that scripts write, and how they tell what they were made of."""
import os
import pathlib
import re
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def write_between(page, name, text):
    """Replaces what stands in a document between <!-- NAME --> and <!-- NAME: end -->; a sentence as SystemExit where these are not there once each."""
    begin, end = f"<!-- {name} -->\n", f"<!-- {name}: end -->"
    told = page.read_text()
    if told.count(begin) != 1 or told.count(end) != 1:
        raise SystemExit(f"{page} lacks the lines {begin.strip()} and {end}, between which this is written; put them back")
    before, rest = told.split(begin)
    page.write_text(f"{before}{begin}{text}{end}{rest.split(end)[1]}")


def table(heads, rows):
    """In Markdown, with a line's end."""
    head, *lines = (f"| {' | '.join(map(str, row))} |\n" for row in [heads, *rows])
    return f"{head}|{'---|' * len(heads)}\n{''.join(lines)}"


def commit(*sources):
    """The commit that was measured, with a word when sources (by default the simulator's) were changed since."""
    def git(*words):
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True).stdout.strip()

    return (git("rev-parse", "--short=12", "HEAD") or "unknown") + (", changed" if git("status", "--porcelain", "--", *(sources or ("hal", "sim_ode", "tests/bench"))) else "")


def measured(*sources, runs="one run of "):
    """Of which commit figures are, on which machine and when."""
    models = re.findall(r"^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(), re.M)
    return f"Commit {commit(*sources)}, {models[0] if models else 'an unknown processor'}, {os.cpu_count()} of them, {runs}{time.strftime('%Y-%m-%d')}"
