"""The demo after everything is built: runs the labs, checks that they agree, and shows what came out. See scripts/demo."""
import argparse
import contextlib
import datetime
import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

from joined_networks import HALL, join_at_server, join_by_tls, joined_networks, nats_server, networks_behind_routers, server_text
from lab_processes import PROGRAM, ROOT, Failed, LabProcesses, begin, end_all, end_with_parent, join_hashes, join_results, link_losses, ready

LABS = [ROOT / "experiments/dhtf/shark.toml", ROOT / "experiments/dhtf/roark.toml"]
# With --emulated roark is a testbed of Kilobots: the lab's cameras and overhead controller are those of an emulated testbed, a process of its own.
EMULATOR = ROOT / "experiments/emulator/roark.toml"
EMULATED_OVERRIDES = {"roark": ["arena.use=kilobot", "arena.kilobot.video=true", "view.emulator=127.0.0.1:8092"]}
# With --hybrid one swarm is simulated and the other stands on an emulated testbed, in one process and as fast as it can be computed.
HYBRIDS = {"dhtf": ["experiments/dhtf/shark.toml", "experiments/dhtf/roark_emulated.toml"],
           "cre": ["experiments/cre/meadow.toml", "experiments/cre/sky_emulated.toml"]}


class Progress:
    """How far every lab is: in place on a terminal, else a line every five seconds."""

    def __init__(self, labs):
        self.labs, self.terminal, self.due = labs, sys.stderr.isatty(), 0

    def show(self):
        if time.monotonic() < self.due:
            return
        self.due = time.monotonic() + (0.3 if self.terminal else 5)
        parts = [re.sub(r"\s+", " ", line) for _, _, line in self.labs.progress().values()]
        line = " | ".join(parts) or "the labs are getting ready"
        if self.terminal:
            line = "\r\033[K" + line[: shutil.get_terminal_size().columns - 1]
        print(line, end="" if self.terminal else "\n", file=sys.stderr, flush=True)

    def done(self):
        if self.terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


class Pages:
    """Where the labs are to be seen, once each has said so; nothing of a run that is over within seconds, with its pages."""

    def __init__(self, labs):
        self.labs, self.left, self.due = labs, set(labs.files), time.monotonic() + 3

    def show(self):
        if time.monotonic() < self.due:
            return
        for lab in sorted(self.left):
            if found := re.search(r"see it at (\S+)\n", self.labs.said("lab", lab).read_text(errors="replace")):
                print(f"demo: see {lab} at {found[1]}", flush=True)
                self.left.discard(lab)


def number(n):
    return f"{n:,}".replace(",", " ")


def count_words(name, n):
    """A count's name and value for people, with the unit that its name ends with: as app/count_words.cpp."""
    units = {"ppm": ("%", 1e4), "us": ("s", 1e6), "ms": ("s", 1e3), "s": ("s", 1), "bytes": ("kB", 1e3)}
    *words, last = re.split(r"[._]", name)
    if words and last in units:
        unit, per = units[last]
        return " ".join(words), f"{n / per:.1f} {unit}"
    return " ".join([*words, last]), str(n)


def summary(joint, out):
    """The one-screen result."""
    walls = {lab: own["wall"] for lab, own in joint["by_lab"].items()}
    lines = [f"{joint['scenario'].upper()}, seed {joint['seed']}: {joint['duration_s']:g} simulated seconds, {joint['periods']} periods, gate {joint['gate']}", ""]
    if joint["scenario"] == "dhtf":
        lines += [f"completed tasks      {joint['counts'].get('completed', 0)}"]
    else:
        lines += [f"{words:<20} {n}" for words, n in (count_words(*count) for count in joint["counts"].items())]
    lines += [f"speed                {joint['wall']['speed']:.0f} simulated seconds per wall second"]
    for lab, wall in walls.items():
        per = wall["per_period_ms"]
        lines += [f"  {lab:<18} {wall['total_s']:.1f} s in all; per period {per['computing']:.2f} ms computing, {per['waiting']:.2f} ms waiting"]
    lines += ["between the labs"]
    for lab, own in joint["by_lab"].items():
        for peer, traffic in own["between_labs"].items():
            lines += [f"  {peer + ' to ' + lab:<18} {number(traffic['received_messages'])} messages, {number(traffic['received_bytes'])} bytes"]
    drops = joint["drops"] | {f"{lab}.link.{name}": n for lab, own in joint["by_lab"].items() for name, n in link_losses(own["between_labs"]).items()}
    lines += ["dropped, replaced, late or refused" + ("" if drops else ": nothing")]
    lines += [f"  {name:<42} {number(n)}" for name, n in sorted(drops.items(), key=lambda item: -item[1])[:12]]
    if len(drops) > 12:
        lines += [f"  ... {len(drops) - 12} more in result.json"]
    lines += [f"final hash           {joint['final_hash']}" + (" (the same in all labs)" if joint["gate"] == "strict" else ""), f"run folder           {out}",
              f"see it again with    arkmesh view {out}",
              f"picture              {out / 'picture.png'}"]
    return "\n".join(lines)


def emulated_testbed(out, program=PROGRAM, file=EMULATOR, more=()):
    """The emulator as a context, ready: its cameras and its overhead controller can be reached."""
    said = out / "emulator.txt"
    said.unlink(missing_ok=True)  # of another one there
    return ready(begin([program, "emulator", file, "--truth", out / "truth.csv", *more], said), said, "commands:", "The emulated testbed")


def show(joint, out):
    """Draws the run, and prints what it gave."""
    drawn = subprocess.run([ROOT / "drawing/plot", out], capture_output=True, text=True)
    if drawn.returncode != 0:
        raise Failed(f"The picture could not be drawn: {drawn.stderr.strip().splitlines()[-1]}")
    print("\n" + summary(joint, out))
    for video in sorted(out.glob("*/arena-*.mp4")):
        print(f"annotated video      {video}")
    if not PROGRAM.with_name("arkmesh-recording").exists() or not PROGRAM.with_name("arkmesh-testbed").exists():
        print("the other commands   scripts/build builds arkmesh plot, export, and those for cameras, such as track")


def run_hybrid(arguments, program=PROGRAM):
    """A simulated lab and one on an emulated testbed, in one process."""
    out = free_folder(arguments.out)
    files = [ROOT / file for file in HYBRIDS[arguments.hybrid]]
    simulated, emulated = (file.stem.removesuffix("_emulated") for file in files)
    print(f"demo: {simulated} is simulated; the robots of {emulated} stand on an emulated testbed, with camera and overhead controller; "
          f"recording to {out}", flush=True)
    command = [program, "run", *files, "--seed", arguments.seed, "--out", out, "--set", f"run.duration_s={arguments.seconds}",
               "--set", "arena.kilobot.video=true", *(["--open"] if getattr(arguments, "open", False) else [])]
    process = subprocess.Popen([str(word) for word in command], stdin=subprocess.DEVNULL, preexec_fn=end_with_parent)
    try:
        code = process.wait()
    finally:
        end_all([process])
    if code != 0:
        raise Failed(f"The labs have not finished (exit code {code}); see above.")
    show(json.loads((out / "result.json").read_text()), out)


def free_folder(asked):
    """Where the run goes: what was asked for, or a folder of its own; empty or not there yet."""
    out = asked or pathlib.Path("runs") / datetime.datetime.now().strftime("%Y-%m-%d-%H%M%S")
    if out.exists() and any(out.iterdir()):
        raise Failed(f"{out} is not empty; give another folder with --out.")
    return out


def run(arguments, files=LABS, program=PROGRAM):
    out = free_folder(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    overrides = [f"run.duration_s={arguments.seconds}", f"run.seed={arguments.seed}"]
    with contextlib.ExitStack() as ending:
        if arguments.emulated:
            ending.enter_context(emulated_testbed(out, program))
        own, enter = EMULATED_OVERRIDES if arguments.emulated else None, None
        if arguments.remote:
            names = [file.stem for file in files]
            own, enter = join_by_tls(names, out / "keys", program), ending.enter_context(joined_networks(names))
        elif arguments.federation:
            names = [file.stem for file in files]
            enter, hall = ending.enter_context(networks_behind_routers(names))
            own = join_at_server(names, out / "keys", f"nats://{HALL}", program)
            ending.enter_context(nats_server(out, server_text(), hall))
        labs = ending.enter_context(LabProcesses(files, out, overrides, own, program=program, enter=enter, lab_words=["--open"] if getattr(arguments, "open", False) else []))
        print(f"demo: {len(files)} labs and {len(files)} gateways run, each a process of its own; recording to {out}", flush=True)
        if arguments.federation:
            print("demo: each lab has its own network behind a router without open ports; they meet at a NATS server outside, which cannot read their messages", flush=True)
        elif enter:
            print("demo: each lab has its own network; a cable joins them, and their gateways use TLS", flush=True)
        if arguments.emulated:
            print("demo: roark's robots are on an emulated testbed; they are identified first, and then play in real time", flush=True)
        progress, pages = Progress(labs), Pages(labs)
        try:
            labs.wait(patience_s=max(600, 2 * arguments.seconds), each=lambda: (pages.show(), progress.show()))
        finally:
            progress.done()
    joint = join_results(labs.results())
    (out / "result.json").write_text(json.dumps(joint, indent=2) + "\n")
    join_hashes(out, sorted(labs.files))
    show(joint, out)


def main():
    parser = argparse.ArgumentParser(prog="scripts/demo")
    parser.add_argument("--seconds", type=float, help="simulated seconds: 1800, with --emulated or --hybrid 120")
    parser.add_argument("--emulated", action="store_true", help="roark is an emulated testbed, seen by a camera, in real time")
    parser.add_argument("--remote", action="store_true", help="each lab in a network of its own, joined over TLS; needs root")
    parser.add_argument("--federation", action="store_true", help="each lab behind a router, joined by a NATS server; needs root")
    parser.add_argument("--hybrid", nargs="?", const="dhtf", choices=list(HYBRIDS),
                        help="one swarm simulated, the other on an emulated testbed, as fast as it can be computed (default dhtf)")
    parser.add_argument("--open", action="store_true", help="open the labs' pages in a browser")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path)
    arguments = parser.parse_args()
    if sum(map(bool, (arguments.remote, arguments.federation, arguments.emulated, arguments.hybrid))) > 1:
        parser.error("--remote, --federation, --emulated and --hybrid are different demos")
    arguments.seconds = arguments.seconds or (120 if arguments.emulated or arguments.hybrid else 1800)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("demo: ended by signal"))
    try:
        run_hybrid(arguments) if arguments.hybrid else run(arguments)
    except Failed as failure:
        sys.exit(f"demo: {failure}")
    except KeyboardInterrupt:
        sys.exit("\ndemo: stopped; its processes are ended.")


if __name__ == "__main__":
    main()
