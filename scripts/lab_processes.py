"""Runs labs as a user would: every lab and every gateway is a process of its own, all on this machine.

Used by the demo and the measurements. Nothing is left running: whatever ends the caller ends the processes too.
"""
import contextlib
import csv
import ctypes
import json
import os
import pathlib
import re
import signal
import subprocess
import time
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "build/release/arkmesh"
PROGRESS = re.compile(r"period (\d+)/(\d+) ")


class Failed(Exception):
    """One sentence that says what went wrong."""


def end_with_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG


def run_delay_s(process):
    """For how long the first thread of a process (by id) wanted a processor and had none; 0 when it has ended. Who judges its pace leaves that out."""
    with contextlib.suppress(OSError, IndexError):
        return int(pathlib.Path(f"/proc/{process}/schedstat").read_text().split()[1]) / 1e9
    return 0.0


def last_line(text):
    """Of what a program said."""
    return (text.strip().splitlines() or ["it said nothing"])[-1]


def until(seconds, condition, what, pause_s=0.05):
    """Waits for a condition; when it does not come, Failed with the sentence `what`."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise Failed(what)
        time.sleep(pause_s)


def begin(command, said, missing="run scripts/build first", preexec_fn=end_with_parent):
    """Starts a process that ends with this one, and adds what it says to a file."""
    with open(said, "ab") as file:
        try:
            return subprocess.Popen(list(map(str, command)), stdin=subprocess.DEVNULL, stdout=file, stderr=file, preexec_fn=preexec_fn)
        except OSError as error:
            raise Failed(f"{command[0]} cannot be started ({error.strerror}); {missing}.") from None


@contextlib.contextmanager
def ready(process, said, words, what):
    """The process, from when it has said these words in its file; the end of the block ends it. Failed when it has ended by itself."""
    def text():
        return said.read_text(errors="replace")
    try:
        until(300, lambda: words in text() or process.poll() is not None, f"{what} did not start within 300 s.")
        if process.poll() is None:
            yield process
        if process.poll() is not None:
            raise Failed(f"{what} has ended: {last_line(text())}")
    finally:
        end_all([process])


def end_all(processes):
    """Asks what still runs to end, and ends what does not listen."""
    for process in processes:
        process.terminate()
    end = time.monotonic() + 5
    for process in processes:
        try:
            process.wait(max(0.1, end - time.monotonic()))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


class LabProcesses:
    """`with LabProcesses(files, out) as labs:` starts everything; leaving the block ends what still runs."""

    def __init__(self, files, out, overrides=(), own_overrides=None, program=PROGRAM, enter=None, lab_words=()):
        self.files = {tomllib.loads(pathlib.Path(f).read_text())["lab"]["name"]: pathlib.Path(f) for f in files}
        self.out = pathlib.Path(out)
        # `overrides` ("key=value") go to every lab, own_overrides[lab] to that lab only.
        self.overrides = {lab: [part for override in [*overrides, *(own_overrides or {}).get(lab, [])] for part in ("--set", override)]
                          for lab in self.files}
        self.program = program
        self.enter = enter or {}  # words before a lab's commands, by lab
        self.lab_words = list(lab_words)  # more options of `arkmesh lab`
        self.processes = {}  # (what, lab) -> Popen

    def __enter__(self):
        self.out.mkdir(parents=True, exist_ok=True)
        try:
            for lab in self.files:
                self.start("gateway", lab)
            for lab in self.files:
                self.start("lab", lab)
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def said(self, what, lab):
        """The file that holds what a process said."""
        return self.out / f"{lab}-{what}.txt"

    def start(self, what, lab, out=None, more=()):
        """Starts a process, with `more` words of the command line; a lab records into `out`, by default a folder of its name."""
        command = [*self.enter.get(lab, []), self.program, what, self.files[lab], *self.overrides[lab], *more]
        if what == "lab":
            command += ["--out", out or self.out / lab, *self.lab_words]
        self.processes[what, lab] = begin(command, self.said(what, lab))

    def last_words(self, what, lab):
        """The last line that a process said, progress aside."""
        return last_line("\n".join(line for line in self.said(what, lab).read_text(errors="replace").splitlines() if not PROGRESS.search(line))).strip()

    def progress(self):
        """{lab: (period, periods, line)} of the labs that have said how far they are."""
        out = {}
        for lab in self.files:
            with open(self.said("lab", lab), "rb") as said:
                said.seek(max(0, said.seek(0, os.SEEK_END) - 2000))
                lines = said.read().decode(errors="replace").splitlines()
            for line in reversed(lines):
                if found := PROGRESS.search(line):
                    out[lab] = int(found[1]), int(found[2]), line
                    break
        return out

    def running(self):
        """Whether a lab is still at it; raises Failed when a process has ended as it should not."""
        for (what, lab), process in self.processes.items():
            code = process.poll()
            if code is not None and (code != 0 or what == "gateway"):
                ended = f"was ended by signal {-code}" if code < 0 else f"ended with code {code}"
                raise Failed(f"The {what} process of {lab} {ended}: {self.last_words(what, lab)}")
        return any(process.poll() is None for (what, _), process in self.processes.items() if what == "lab")

    def wait(self, patience_s, each=lambda: None):
        """Until all labs have finished; calls `each` ten times a second."""
        end = time.monotonic() + patience_s
        while self.running():
            each()
            if time.monotonic() > end:
                raise Failed(f"The labs have not finished within {patience_s:.0f} s: {self.progress()}")
            time.sleep(0.1)

    def stop(self):
        end_all(self.processes.values())

    def results(self):
        """{lab: result.json}"""
        return {lab: json.loads((self.out / lab / "result.json").read_text()) for lab in self.files}


def join_results(results):
    """One result of labs that ran together, as `arkmesh run` writes it: what is common once, the rest by lab."""
    hashes = {lab: result["final_hash"] for lab, result in results.items()}
    strict = all(result["gate"] == "strict" for result in results.values())  # a free gate promises no equal view
    if strict and len(set(hashes.values())) != 1:
        raise Failed(f"The labs do not agree on the final hash: {hashes}; hash.csv of each shows the first period that differs.")
    first = next(iter(results.values()))
    common = ("arkmesh", "versions", "labs", "scenario", "seed", "gate", "state", "ended", "periods", "duration_s", "final_hash", "hash_by_lab")
    joint = {key: first[key] for key in common if key in first}
    joint["counts"] = {}
    for lab, result in results.items():
        for name, n in result["counts"].items():
            if name in result.get("shared_counts", ()):  # told alike by all
                joint["counts"].setdefault(name, n)
            else:
                joint["counts"].update({name: joint["counts"].get(name, 0) + n, f"{name}@{lab}": n})
    joint["drops"] = {f"{lab}.{name}": n for lab, result in results.items() for name, n in result["drops"].items()}
    joint["by_lab"] = {lab: {key: result[key] for key in ("counts", "pauses", "not_standing", "counters", "exchange", "wall", "peers", "between_labs") if key in result}
                       for lab, result in results.items()}
    walls = [result["wall"] for result in results.values()]
    joint["wall"] = {"total_s": max(wall["total_s"] for wall in walls), "speed": min(wall["speed"] for wall in walls)}
    return joint


def link_losses(between_labs):
    """{peer.counter: n} of the links' counters that tell of something lost, replaced or refused."""
    fine = re.compile(r"(sent|received)[._](messages|bytes)|outbox\.(waiting|accepted|acknowledged|in_flight|queued)\..*|received\.repeated\..*|session\.opened|certificate\.days_left")
    return {f"{peer}.{name}": n for peer, traffic in between_labs.items() for name, n in traffic.items() if n and not fine.fullmatch(name)}


def join_hashes(out, labs):
    """out/hash.csv: a row per period with every lab's hash, from out/<lab>/hash.csv."""
    tables = []
    for lab in labs:
        with open(out / lab / "hash.csv", newline="") as table:
            tables.append(list(csv.reader(table)))
    with open(out / "hash.csv", "w", newline="") as joint:
        writer = csv.writer(joint, lineterminator="\n")
        writer.writerow(["period", *labs])
        for rows in zip(*(table[1:] for table in tables)):
            writer.writerow([rows[0][0], *(row[1] for row in rows)])
