"""What scripts/behaviour runs: whole labs, robots' programs by themselves, and commands with right and wrong arguments. None needs a network,
a real testbed or a screen."""
import dataclasses


@dataclasses.dataclass
class Command:
    """Command lines run one after another in one folder. TREE stands for the checkout, FOLDER for that folder, which has `files` in it."""
    name: str
    lines: list
    files: dict = dataclasses.field(default_factory=dict)
    short: bool = True  # in the short form too
    limit_s: float = 60


SHARK, ROARK, LYNX, ROARK_EMULATED = (f"TREE/experiments/dhtf/{name}.toml" for name in ("shark", "roark", "lynx", "roark_emulated"))
EMULATOR = "TREE/experiments/emulator/roark.toml"
PICTURES = "TREE/tests/data/kilobot-images/"
HELP = ["", "run", "lab", "gateway", "doctor", "controller", "controller run", "controller check", "emulator", "ohc", "ohc upload", "track",
        "calibrate", "identify", "assign-ids", "calibrate-motors", "testbed", "testbed record", "testbed replay"]
OHC_COMMANDS = ["run", "pause", "reset", "sleep", "wake", "voltage", "charge", "stop", "lamp", "message", "set-uid", "left", "right", "straight",
               "save"]
# Settings that `arkmesh run` of lab shark refuses, by the name of the text.
REFUSED_SETTINGS = {
    "unknown-key": "arena.nonsense=1", "misspelt-key": "arena.widht_m=1.0", "other-unit": "arena.width_cm=100.0",
    "wrong-type": 'arena.width_m="wide"', "negative": "arena.width_m=-1.0", "no-integer": "arena.robots=3.5",
    "too-many-robots": "arena.robots=5000", "no-whole-periods": "run.duration_s=3.0", "unknown-scenario": 'run.scenario="chess"',
    "unknown-arena": 'arena.use="moon"', "large-slack": "gate.slack=9", "unknown-owner": 'shared.owner="nobody"',
    "bad-lab-name": 'lab.name="Not A Name"', "unknown-cells": 'scenario.dhtf.cells="some"', "unknown-preset": 'preset="imagined"',
    "no-value": "run.duration_s", "missing-controller": 'arena.ode.controller="/nowhere/at/all.c"',
    "broken-controller": 'arena.ode.controller="TREE/tests/programs/refused_syntax.c"',
    "crashing-controller": 'arena.ode.controller="TREE/tests/programs/crash_null.c"', "missing-log": 'arena.replay.log="/nowhere/log.lcm"',
    "bad-gateway": 'gateway.listen="nowhere"', "bad-export": 'gateway.exports=["moon"]', "lab-without-projection": 'shared.labs=["shark","nobody"]',
}
# Programs for a hundred robots, with what is special about the run of each; the first three are in the short form too.
PROGRAMS = {
    "gradient_hops": ["--spacing", "0.06"], "labs_random_walk": ["--seed", "2"], "style_text": ["--text", "3"],
    "naming_game": ["--spacing", "0.05"], "orbit_planet": ["--arena", "2x0.5"], "sync_firefly": ["--spacing", "0.07"],
    "disperse_simple": ["--spacing", "0.04"], "phototaxis_zigzag": ["--light", "0.3,-0.2"], "art_dance": [], "labs_drive_all": [],
    "style_random": [], "ark_blocks": [],
}
# Programs that do not run to the end, or not at all; the first three are in the short form too.
FAILING_PROGRAMS = ["crash_null", "hang_loop", "refused_syntax", "crash_assert", "crash_divide", "crash_recursion", "crash_exit", "hang_setup",
                    "refused_unknown", "refused_no_start", "refused_registers"]


def whole_labs():
    """`arkmesh run` of labs that play, those that take long first."""
    def labs(name, files, *settings, short=False):
        sets = [part for setting in settings for part in ("--set", setting)]
        return Command(f"labs/{name}", [["run", *files, "--out", "FOLDER/out", *sets]], short=short, limit_s=300)

    pair, emulated = (SHARK, ROARK), (SHARK, ROARK_EMULATED)
    yield labs("emulator-120-s", emulated, "run.duration_s=120", "run.seed=2")
    yield labs("emulator-20-s", emulated, "run.duration_s=20", short=True)
    for preset in ("paper", "original"):
        for seed in range(1, 6):
            yield labs(f"{preset}-seed-{seed}", pair, f'preset="{preset}"', f"run.seed={seed}", short=seed <= 2)
    yield labs("three-labs", (SHARK, ROARK, LYNX), "run.duration_s=600", short=True)
    yield labs("three-labs-easy", (SHARK, ROARK, LYNX), 'scenario.dhtf.types="easy"', "run.seed=2")
    yield labs("slack-2", pair, "gate.slack=2")
    yield labs("no-robots-shown", pair, "arena.use=null", "run.duration_s=120")
    yield labs("lossy-air", pair, "arena.ode.overhead_loss=0.2", "arena.ode.ir_loss=0.1", "run.duration_s=600")
    alone = ["run", SHARK, "--set", "run.duration_s=120"]
    yield Command("labs/replay", [[*alone, "--out", "FOLDER/recorded"],
                                  [*alone, "--out", "FOLDER/played", "--set", "arena.use=replay", "--set",
                                   'arena.replay.log="FOLDER/recorded/shark/log.lcm"']])
    yield Command("labs/seeds", [["batch", *pair, "--seeds", "6..8", "--out", "FOLDER/out", "--set", "run.duration_s=120"]], short=False)


def robots():
    for i, (name, options) in enumerate(PROGRAMS.items()):
        yield Command(f"programs/{name}", [["controller", "run", f"TREE/tests/programs/{name}.c", "--robots", "100", "--seconds", "60", "--csv",
                                            "FOLDER/poses.csv", *options]], short=i < 3)


def run_commands():
    yield Command("run-no-file", [["run"]])
    yield Command("run-missing-file", [["run", "/nowhere.toml"]])
    yield Command("run-unknown-option", [["run", SHARK, "--nonsense"]])
    yield Command("run-same-lab-twice", [["run", SHARK, SHARK, "--out", "out"]])
    for name, seeds in {"reversed": "5..1", "text": "many", "one-number": "7"}.items():
        yield Command(f"batch-seeds-{name}", [["batch", SHARK, "--seeds", seeds, "--out", "out"]])
    yield Command("run-negative-seed", [["run", SHARK, "--seed", "-1"]])
    yield Command("run-seeds", [["run", SHARK, "--seeds", "1..2"]])
    yield Command("batch-no-seeds", [["batch", SHARK, "--out", "out"]])
    yield Command("batch-no-jobs", [["batch", SHARK, "--seeds", "1..2", "--jobs", "0"]])
    for name, setting in REFUSED_SETTINGS.items():
        more = ["--set", "arena.use=replay"] if name == "missing-log" else []
        yield Command(f"run-{name}", [["run", SHARK, "--out", "FOLDER/out", "--set", "run.duration_s=20", *more, "--set", setting]])
    yield Command("run-no-toml", [["run", "FOLDER/lab.toml", "--out", "out"]], {"lab.toml": "[lab\nname = 3\n"})
    yield Command("run-unknown-key-in-file", [["run", "FOLDER/lab.toml", "--out", "out", "--set", "arena.use=null"]],
                  {"lab.toml": '[lab]\nname = "shark"\n[run]\nscenario = "dhtf"\n[arena]\nrobotz = 3\n'
                               '[scenario.dhtf.requirements]\nshark = [1, 2]\n'})
    yield Command("run-labs-disagree", [["run", SHARK, "FOLDER/lab.toml", "--out", "out", "--set", "run.duration_s=20"]],
                  {"lab.toml": f'include = ["{ROARK}"]\n[gate]\nslack = 1\n',
                   "presets/paper.toml": 'include = ["TREE/experiments/dhtf/presets/paper.toml"]\n'})
    yield Command("run-log-of-another-kind", [["run", SHARK, "--out", "out", "--set", "arena.use=replay", "--set", f'arena.replay.log="{SHARK}"']])


def lab_commands():
    for name in ("lab", "gateway", "identify", "assign-ids", "calibrate-motors"):
        yield Command(f"{name}-no-file", [[name]])
        yield Command(f"{name}-missing-file", [[name, "/nowhere.toml"]])
        yield Command(f"{name}-unknown-option", [[name, SHARK, "--nonsense"]])
    yield Command("lab-unknown-key", [["lab", SHARK, "--out", "out", "--set", "arena.nonsense=1"]])
    yield Command("gateway-unknown-key", [["gateway", SHARK, "--set", "gateway.nonsense=1"]])
    yield Command("lab-bad-bus", [["lab", SHARK, "--out", "out", "--set", 'bus.url="nonsense://"']])
    for name, where in {"no-address": "nowhere", "bad-port": "127.0.0.1:99999", "other-machine": "1.2.3.4:7801"}.items():
        yield Command(f"gateway-{name}", [["gateway", SHARK, "--set", f'gateway.listen="{where}"']])
    yield Command("doctor-unknown-option", [["doctor", "--nonsense"]])
    yield Command("identify", [["identify", ROARK]])
    yield Command("identify-as-ark", [["identify", ROARK, "--protocol", "ark"]], short=False)
    yield Command("identify-in-emulator", [["identify", ROARK_EMULATED]], short=False)
    yield Command("identify-unknown-protocol", [["identify", ROARK, "--protocol", "morse"]])
    yield Command("identify-bad-ids", [["identify", ROARK, "--ids", "7-3"]])
    yield Command("identify-no-testbed", [["identify", ROARK, "--set", "arena.use=null"]])
    yield Command("assign-ids-bad-ids", [["assign-ids", ROARK, "--ids", "some"]])
    yield Command("assign-ids-large-id", [["assign-ids", ROARK, "--ids", "0-5000"]])
    yield Command("calibrate-motors", [["calibrate-motors", ROARK]])
    yield Command("calibrate-motors-bad-duty", [["calibrate-motors", ROARK, "--duty", "300"]])
    yield Command("calibrate-motors-bad-ids", [["calibrate-motors", ROARK, "--ids", "0-5000"]])


def emulator_and_ohc_commands():
    yield Command("emulator-no-file", [["emulator"]])
    yield Command("emulator-missing-file", [["emulator", "/nowhere.toml"]])
    yield Command("emulator-file-of-a-lab", [["emulator", SHARK, "--offline", "--seconds", "1"]], short=False)
    yield Command("emulator-unknown-key", [["emulator", EMULATOR, "--set", "emulator.nonsense=1"]], short=False)
    yield Command("emulator-bad-value", [["emulator", EMULATOR, "--set", "emulator.frames_per_s=0"]])
    yield Command("emulator-offline-without-seconds", [["emulator", EMULATOR, "--offline"]], short=False)
    yield Command("emulator-offline", [["emulator", EMULATOR, "--offline", "--seconds", "2", "--truth", "truth.csv", "--calibration", "testbed.yaml",
                                    "--video", "emulator.avi"]])
    board = [f"FOLDER/board/camera0-0{i}.png" for i in range(4)]
    yield Command("emulator-chessboard-and-calibrate",
                  [["emulator", EMULATOR, "--chessboard", "4", "FOLDER/board"],
                   ["calibrate", *board, "--board", "9x6", "--corner", "250,80", "--corner", "1000,80", "--corner", "1000,880", "--corner",
                    "250,880", "--arena", "0.5x0.5", "--out", "testbed.yaml"]], short=False)
    yield Command("calibrate-nothing", [["calibrate"]])
    yield Command("calibrate-no-pictures", [["calibrate", "--out", "testbed.yaml"]])
    yield Command("calibrate-no-chessboard", [["calibrate", PICTURES + "table_6robots.png", "--out", "testbed.yaml"]])
    yield Command("calibrate-bad-arena", [["calibrate", PICTURES + "table_6robots.png", "--arena", "wide", "--out", "testbed.yaml"]])
    yield Command("calibrate-missing-ark", [["calibrate", "--import-ark", "/nowhere.xml", "--out", "testbed.yaml"]])
    yield Command("ohc-nothing", [["ohc"]])
    yield Command("ohc-no-command", [["ohc", "tcp://127.0.0.1:1"]])
    yield Command("ohc-unknown-command", [["ohc", "tcp://127.0.0.1:1", "dance"]])
    yield Command("ohc-bad-port", [["ohc", "tcp://127.0.0.1:99999", "run"]])
    yield Command("ohc-nobody-listens", [["ohc", "tcp://127.0.0.1:1", "run"]])
    yield Command("ohc-missing-device", [["ohc", "/nowhere/port", "run"]])
    yield Command("ohc-bad-message", [["ohc", "tcp://127.0.0.1:1", "message", "200", "1"]])
    yield Command("ohc-bad-duty", [["ohc", "tcp://127.0.0.1:1", "left", "300"]])
    yield Command("ohc-upload-missing-file", [["ohc", "tcp://127.0.0.1:1", "upload", "/nowhere.hex"]])
    yield Command("ohc-upload-no-hex", [["ohc", "tcp://127.0.0.1:1", "upload", "FOLDER/robot.hex"]], {"robot.hex": "no program\n"})


def track_and_controller_commands():
    yield Command("track-nothing", [["track"]])
    yield Command("track-missing-file", [["track", "nowhere.png"]])
    yield Command("track-damaged-picture", [["track", "FOLDER/table.png"]], {"table.png": "no picture\n"})
    yield Command("track-text", [["track", PICTURES + "table_6robots.png"]])
    yield Command("track-json", [["track", PICTURES + "table_6robots.png", "--json", "--png", "drawn.png"]])
    yield Command("track-json-many", [["track", PICTURES + "bodyguard_f060.png", "--json"]])
    yield Command("track-clip", [["track", PICTURES + "bodyguard_clip.mp4", "--csv", "tracks.csv"]], short=False)
    yield Command("track-bad-diameter", [["track", PICTURES + "table_6robots.png", "--diameter", "1"]])
    yield Command("testbed-record-simulated", [["testbed", "record", SHARK, "--out", "shark"]])
    yield Command("testbed-replay-nothing", [["testbed", "replay", "FOLDER"]])
    yield Command("track-camera-without-calibration", [["track", PICTURES + "table_6robots.png", "--camera", "north"]])
    yield Command("track-unwritable", [["track", PICTURES + "table_6robots.png", "--png", "/nowhere/drawn.png"]])
    for i, name in enumerate(("gradient_hops", "refused_syntax", "style_text", "crash_stack", "refused_unknown", "refused_registers")):
        yield Command(f"check-{name}", [["controller", "check", f"TREE/tests/programs/{name}.c"]], short=i < 2)
    for i, name in enumerate(FAILING_PROGRAMS):
        yield Command(f"robots-{name}", [["controller", "run", f"TREE/tests/programs/{name}.c", "--robots", "9", "--seconds", "20"]], short=i < 3)
    blink = ["controller", "run", "TREE/tests/programs/labs_blink.c"]
    yield Command("robots-no-command", [["controller"]])
    yield Command("robots-missing-program", [["controller", "run", "/nowhere.c"]])
    for name, options in {"bad-arena": ["--arena", "wide"], "bad-light": ["--light", "there"], "none": ["--robots", "0"],
                          "no-place": ["--robots", "100", "--arena", "0.1x0.1"], "unwritable": ["--csv", "/nowhere/poses.csv"]}.items():
        yield Command(f"robots-{name}", [blink + options])


def other_commands():
    yield Command("no-arguments", [[]])
    yield Command("version", [["--version"]])
    yield Command("unknown-command", [["dance"]])
    yield Command("unknown-option", [["--nonsense"]])
    for name in HELP:
        yield Command("-".join(["help", *name.split()]), [[*name.split(), "--help"]])
    yield Command("help-ohc-commands", [["ohc", name, "--help"] for name in OHC_COMMANDS], short=False)
    for group in (run_commands, lab_commands, emulator_and_ohc_commands, track_and_controller_commands):
        yield from group()


def commands(short):
    """Everything to be run; what has no folder in its name is of the folder `commands`."""
    everything = [*whole_labs(), *robots(), *other_commands()]
    for command in everything:
        command.name = command.name if "/" in command.name else "commands/" + command.name
    return [command for command in everything if command.short or not short]
