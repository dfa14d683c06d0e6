"""What scripts/behaviour records: everything that is run, and the texts that are made of what came out.

A .txt holds a command with its exit code and what it said, a .keys a line `key = value` for each thing about the files that it wrote. Digests
stand for what is too long to keep, in parts, so that the first difference can be found.
"""
import collections
import concurrent.futures
import csv
import hashlib
import json
import os
import re
import shutil
import subprocess
import tempfile
import tomllib

from behaviour_commands import commands
from read_log import events

ABOUT = "about.txt"  # written last: a folder without it is no finished record
# What depends on the wall clock or on chance, and what takes its place. Whole lines that come when a second has passed are left out.
PASSING = [
    (re.compile(r"^\S.*  [a-z]+ \d+/\d+  [\d.]+ %  \d+x.*\n", re.M), ""),  # progress of a run
    (re.compile(r"^[a-z-]+: \d+(\.\d+)? s, .*\n", re.M), ""),  # status of a set-up procedure
    (re.compile(r"^\[\d{4}-\d\d-\d\d [\d:.]+\]", re.M), "[TIME]"),
    (re.compile(r"(simulated|built) in [\d.]+ s"), r"\1 in N s"),
    (re.compile(r"\(\d+x\)"), "(Nx)"),
    (re.compile(r"^see it at http\S+\n", re.M), ""),  # the page of a run, at whichever port and with a token
    (re.compile(r"^.*TCP port \d+ is taken; the page is at \d+\n", re.M), ""),
    (re.compile(r"http://127\.0\.0\.1:\d+"), "http://127.0.0.1:PORT"),
]


class Refused(Exception):
    """One sentence that says what is wrong with the command line."""


def digest(*parts):
    """Of texts, bytes or numbers one after another; numbers are set apart."""
    whole = hashlib.sha256()
    for part in parts:
        whole.update(part if isinstance(part, bytes) else f"{part} ".encode())
    return whole.hexdigest()[:16]


# Of results: what each run, machine and commit has of its own.
OWN_OF_A_RUN = {"wall", "started", "process", "hashes", "commit"}


def flat(value, path=""):
    """[(key, value)] of nested tables, without what the wall clock, the machine or the commit decided."""
    if isinstance(value, dict):
        return [pair for key, each in value.items() if key not in OWN_OF_A_RUN for pair in flat(each, f"{path}.{key}")]
    return [(path, json.dumps(value))]


def table_keys(name, file):
    """Rows, and digests of the whole and of each tenth of it, of a CSV file; the column `speed` is by the wall clock."""
    with open(file, newline="") as table:
        rows = list(csv.reader(table))
    kept = [i for i, column in enumerate(rows[0] if rows else []) if column != "speed"]
    rows = [",".join(row[i] for i in kept if i < len(row)) + "\n" for row in rows]
    body = rows[1:]
    parts = [body[len(body) * i // 10:len(body) * (i + 1) // 10] for i in range(10)]
    return [(name + " header", rows[0].strip() if rows else ""), (name + " rows", len(body)), (name + " digest", digest(*body)),
            *((f"{name} digest of part {i}", digest(*part)) for i, part in enumerate(parts))]


def log_keys(name, file):
    """What passed a lab's private bus, by channel: how much, and digests of sizes, of times since the beginning, and of contents. Contents
    are without the fingerprints of their types and without the random numbers of the run: `world` and `status` hold one behind their lab's name."""
    kept = list(events(file))
    nonces = set()
    for _, channel, data in kept:
        if channel.split("/")[-1] in ("world", "status"):
            end_of_name = 12 + int.from_bytes(data[8:12], "big")
            nonces.add(data[end_of_name:end_of_name + 8])
    channels, order = collections.defaultdict(lambda: collections.defaultdict(list)), []
    for seconds, channel, data in kept:
        parts = channels[channel]
        order.append(list(channels).index(channel))
        for nonce in nonces if channel.split("/")[-1] in ("world", "status") else ():
            data = data.replace(nonce, b"a nonce.")
        parts["sizes"].append(len(data))
        parts["times"].append(round((seconds - kept[0][0]) * 1e6))
        parts["contents"].append(data[8:])
    keys = [(name + " messages", len(kept)), (name + " bytes", sum(len(data) for _, _, data in kept)), (name + " order of channels", digest(*order))]
    for channel, parts in channels.items():
        keys += [(f"{name} {channel} messages", len(parts["sizes"])), (f"{name} {channel} bytes", sum(parts["sizes"])),
                 *((f"{name} {channel} {what}", digest(*values)) for what, values in parts.items())]
    return keys


def file_keys(name, file):
    """The lines about one file that the program wrote."""
    try:
        if name.endswith(".json"):
            return flat(json.loads(file.read_text()), name)
        if name.endswith(".toml"):
            return flat(tomllib.loads(file.read_text()), name)
    except ValueError:
        return [(name + " damaged, digest", digest(file.read_bytes()))]
    if name.endswith(".csv"):
        return table_keys(name, file)
    if name.endswith(".lcm"):
        return log_keys(name, file)
    return [(name + " digest", digest(file.read_bytes()))]


class Recorder:
    """Runs commands, each in a folder of its own below `scratch`, and writes texts into `out`."""

    def __init__(self, program, tree, out, scratch):
        self.program, self.tree, self.out, self.scratch = program, tree, out, scratch
        # The program names its own sources, which need not be those of `tree`.
        sources = {str(folder) for folder in program.parents[2:3] if (folder / "CMakeLists.txt").is_file()}
        self.trees = sorted(sources | {str(tree)}, key=len, reverse=True)

    def text(self, words, folder):
        """Without paths of this machine and without what depends on the wall clock."""
        words = words.replace(str(folder), "FOLDER")
        for tree in self.trees:
            words = re.sub(re.escape(tree) + r"(?![\w.-])", "TREE", words)
        for pattern, instead in PASSING:
            words = pattern.sub(instead, words)
        return words

    def run(self, arguments, folder, limit_s):
        """What the program said, and its exit code, as a text."""
        command = [str(self.program), *(word.replace("TREE", str(self.tree)).replace("FOLDER", str(folder)) for word in arguments)]
        environment = os.environ | {"LC_ALL": "C.UTF-8", "TMPDIR": str(folder / "tmp")}
        try:
            done = subprocess.run(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, timeout=limit_s)
            code, said, cried = done.returncode, done.stdout, done.stderr
        except subprocess.TimeoutExpired as late:
            code, said, cried = f"none within {limit_s} s", late.stdout or b"", late.stderr or b""
        said, cried = (self.text(words.decode(errors="backslashreplace"), folder) for words in (said, cried))
        return f"$ arkmesh {' '.join(arguments)}\nexit code {code}\n--- stdout\n{said}--- stderr\n{cried}"

    def do(self, command):
        """Writes NAME.txt, what was said, and NAME.keys, what was written, if anything was."""
        folder = self.scratch / command.name.replace("/", "-")
        (folder / "tmp").mkdir(parents=True)
        for name, text in command.files.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(text.replace("TREE", str(self.tree)))
        said = "".join(self.run(arguments, folder, command.limit_s) for arguments in command.lines)
        wrote = [(str(file.relative_to(folder)), file) for file in folder.rglob("*") if file.is_file()]
        keys = [pair for name, file in wrote if name not in command.files and not name.startswith("tmp/") for pair in file_keys(name, file)]
        shutil.rmtree(folder)
        text = self.out / command.name
        text.parent.mkdir(exist_ok=True)
        text.with_suffix(".txt").write_text(said)
        if keys:
            lines = sorted(f"{key} = {value}\n" for key, value in keys)
            text.with_suffix(".keys").write_text("".join(self.text(line, folder) for line in lines))


def record(out, program, tree, short):
    """Writes the record into `out`; the exit code."""
    if not os.access(program, os.X_OK) or program.is_dir():
        raise Refused(f"{program} is no program that can be started; build it with scripts/build, or give another with --program")
    if not (tree / "experiments/dhtf").is_dir():
        raise Refused(f"{tree} is no checkout: it has no experiments/dhtf")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise Refused(f"{out} is there and not empty; give a new folder")
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="arkmesh-behaviour-") as scratch:
        recorder = Recorder(program, tree, out, type(out)(scratch).resolve())
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            running = [pool.submit(recorder.do, command) for command in commands(short)]
            try:
                for each in concurrent.futures.as_completed(running):
                    each.result()
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
    (out / ABOUT).write_text(f"What arkmesh did, written by scripts/behaviour record.\nshort = {'yes' if short else 'no'}\n")
    print(f"behaviour: {sum(1 for file in out.rglob('*') if file.is_file()) - 1} texts in {out}")
    return 0
