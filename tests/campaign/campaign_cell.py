"""One cell of the campaign: brings two small labs into a phase, does the fault, and judges what came of it. Runs in a network and mount namespace
of its own. See tests/campaign/campaign."""
import contextlib
import csv
import dataclasses
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import time

import campaign_files
import campaign_promises
import read_log
from campaign_files import LISTENS, PORTS, THROUGH
from campaign_network import Impostor, Link
from demo_run import emulated_testbed
from lab_bus import BusEar
from lab_processes import Failed, LabProcesses, run_delay_s, until

CONTROL = 8092                          # of the emulator
PATIENCE_S = 8                          # gate.patience_s
LONG_PATIENCE_S = 40                    # where a lab stands still for 20 s, or its link is mended again
NOTICES_S = 8                           # what noticing, lingering and the end of an arena may take beyond that
STANDS_STILL_S = 20
LINE_AWAY_S = 8
SEEN_TO_STAND_S = 10                    # for so long an arena tells its robots to stand at the end
HUNG_S = 3                              # safety.hung_s
STAND_WITHIN_S = 3.5                    # of the lab's end, or of when its controller can be reached: settle_s + 1


@dataclasses.dataclass
class Pace:
    """Times of a run: lab seconds, and how many periods before the fault."""
    period_s: float
    duration_s: float
    fault_at: int


def pace_of(arena, phase, fault):
    if arena == "simulated":
        return Pace(2.0, 4000.0, 600)
    if phase == "ending" or phase == "waiting at 0":
        return Pace(0.5, 8.0, 6)
    return Pace(0.5, 44.0 if fault.endswith("0 s") or fault.startswith("stalls") else 24.0, 6)


def failing_program(program):
    """The program whose scenario fails when it is told to; built with the tests."""
    return program.parent / "arkmesh_failing"


def small_disk(folder):
    """Mounts one of 48 MiB."""
    folder.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=48m", "campaign", folder], check=True)


def fill(folder):
    """Until nothing more fits on its disk."""
    with contextlib.suppress(OSError), open(folder / "filler", "wb", buffering=0) as filler:
        while True:
            filler.write(bytes(4096))


class Cell:
    robots = 3

    def __init__(self, arena, phase, fault, out, program, hash_text, _divide=1):
        self.arena, self.phase, self.fault, self.out, self.hash = arena, phase, fault, out, hash_text
        self.promise = campaign_promises.promise(arena, phase, fault)
        self.program = failing_program(program) if fault == "scenario exception" else program
        self.pace = pace_of(arena, phase, fault)
        goes_on = isinstance(self.promise, campaign_promises.Promise) and self.promise.end == "finished"
        self.patience_s = LONG_PATIENCE_S if fault.startswith(("SIGSTOP", "hangs")) or (phase == "waiting in mid-run" and goes_on) else PATIENCE_S
        self.problems, self.ears, self.ended, self.impostor = [], {}, {}, None
        self.figures, self.waits = {}, ""  # what was measured, for the record; what it said while it waited
        self.port = str(out / "ohc") if fault.endswith("terminal away") else "tcp://127.0.0.1:8091"
        self.line_back_s = 0.0  # of the emulator's time
        self.folders = {"roark": out / ("disk" if fault == "disk full" else "") / "roark", "shark": out / "shark"}

    # ------------------------------------------------------------ preparation

    def write_files(self):
        hardware, crash = self.arena == "hardware", self.out / "crash.c"
        crash.write_text(campaign_files.crashing_program(int(31 * self.pace.period_s * self.pace.fault_at)))
        (self.out / "emulator.toml").write_text(campaign_files.emulator(self.robots, f'emulator.ohc_link = "{self.out}/ohc"\n'))
        files = {lab: self.out / f"{lab}.toml" for lab in PORTS}
        for lab, file in files.items():
            own = lab == "roark"
            crashes = own and self.fault == "program crash" and not hardware
            file.write_text(campaign_files.lab(
                lab, self.port, duration_s=self.pace.duration_s, period_s=self.pace.period_s, robots=self.robots, out=self.out, patience_s=self.patience_s,
                use="kilobot" if own and hardware else "ode", pace=0.0 if self.arena == "simulated" else 1.0, side_m=0.5 if own else 1.0,
                controller=crash if crashes else campaign_files.DHTF))
        return list(files.values())

    def said(self, lab="roark"):
        file = self.labs.said("lab", lab)
        return file.read_text(errors="replace") if file.exists() else ""

    def until(self, seconds, condition, what):
        """Waits for something that the cell needs before it can judge."""
        try:
            until(seconds, condition, f"{what} has not happened within {seconds} s", 0.01)
        except Failed as failure:
            raise Failed(f"{failure}; roark: {self.said()[-300:].strip()} shark: {self.said('shark')[-300:].strip()}") from None

    def wrong_if(self, broken, sentence):
        if broken:
            self.problems.append(sentence)

    def process(self, lab="roark"):
        return self.labs.processes["lab", lab]

    def lives(self, lab="roark"):
        process = self.labs.processes.get(("lab", lab))
        return process is not None and process.poll() is None

    def state(self):
        return self.ears["roark"].state()

    def start_lab(self, lab, again=False):
        self.folders[lab] = self.folders[lab].with_name(f"{lab}-again") if again else self.folders[lab]
        self.labs.start("lab", lab, self.folders[lab])

    def enter_phase(self):
        """Until the lab is where the fault shall meet it."""
        if self.phase == "waiting at 0" and self.fault == "peer's states refused":
            # the peer spoke to nobody yet: what it would have said is what the impostor alters
            self.start_lab("shark")
            self.until(300, lambda: self.ears["shark"].period() == 0 and self.ears["shark"].message("status"), "the peer's start")
            self.process("shark").send_signal(signal.SIGSTOP)
        self.labs.start("gateway", "shark")
        self.labs.start("gateway", "roark")
        self.start_lab("roark")
        self.until(300, lambda: self.state().startswith("waiting for shark") or not self.lives(), "the lab's wait for its peer")
        if self.phase == "waiting at 0":
            self.judge_wait()
            return
        self.start_lab("shark")
        if self.phase == "ending":
            self.until(300, lambda: self.state() == "finished" or not self.lives(), "the end of the run")
            return
        self.until(300, lambda: self.ears["roark"].period() >= self.pace.fault_at or not self.lives(), "the run's beginning")
        if self.phase == "waiting in mid-run":
            self.link.cut()
            # an arena that keeps real time notices after five seconds; whether it says so is not what this cell is about
            with contextlib.suppress(Failed):
                self.until(7, lambda: re.search("waiting for shark|without shark", self.state()) or not self.lives(), "the lab's wait for its peer")
            self.judge_wait()

    def judge_wait(self):
        """Whoever waits says for whom and until when."""
        if self.lives() and not re.search(r"shark.*(for \d+ s more|until )", state := self.state()):
            self.problems.append(f"roark does not say for whom it waits and until when: {state[:150]}")

    # ------------------------------------------------------------ faults

    def do_fault(self):
        fault, process = self.fault, self.process()
        name = re.sub(", (line|terminal) away$", "", fault)
        if name in ("Ctrl-C", "SIGTERM", "SIGKILL") or " in vain" in fault:
            if name != fault:
                self.tell_emulator("ohc unplug")
            process.send_signal({"Ctrl-C": signal.SIGINT, "SIGTERM": signal.SIGTERM}.get(name, signal.SIGKILL))
            if name not in ("Ctrl-C", "SIGTERM"):
                process.wait()
            if " in vain" in fault:
                self.try_in_vain(fault.partition(" in vain")[0])
            if name != fault:
                time.sleep(LINE_AWAY_S)
                self.tell_emulator("ohc plug")
                self.line_back_s = self.emulator_time_s()
        elif fault.startswith("hangs"):
            self.hang(fault.partition(", ")[2])
        elif fault.startswith("stalls"):
            self.stall(float(fault.split()[1]), fault.endswith("during"))
        elif fault == "SIGSTOP 20 s":
            process.send_signal(signal.SIGSTOP)
            time.sleep(STANDS_STILL_S)
            process.send_signal(signal.SIGCONT)
        elif fault == "program crash":
            if self.arena == "hardware":
                self.tell_emulator("robot 0 kill")
        elif fault == "scenario exception":
            (self.out / "fail" / "roark").touch()
        elif fault == "peer killed":
            if self.phase == "waiting at 0":
                self.start_lab("shark")
                time.sleep(0.6)  # it has said nothing yet
            self.process("shark").kill()
            self.process("shark").wait()
        elif fault == "peer's states refused":
            self.process("shark").send_signal(signal.SIGSTOP)
            self.impostor = Impostor(PORTS["shark"], self.ears["shark"], "roark")
        elif fault.startswith("link cut"):
            self.link.cut()
            time.sleep(4 if fault == "link cut 4 s" else 0)
        elif fault == "disk full":
            fill(self.folders["roark"].parent)
        elif fault == "run folder removed":
            while self.folders["roark"].exists():  # the lab may be writing there
                shutil.rmtree(self.folders["roark"], ignore_errors=True)

    def command(self, *words, limit_s=300):
        """Code and words of a command of arkmesh."""
        done = subprocess.run([self.program, *words], capture_output=True, text=True, timeout=limit_s)
        return done.returncode, done.stdout + done.stderr

    def step(self, *words, codes=(0,), limit_s=300):
        """The words of a command that ends with one of these codes."""
        code, said = self.command(*words, limit_s=limit_s)
        if code not in codes:
            raise Failed(f"arkmesh {' '.join(map(str, words[:2]))} ends with {code}: {said.strip()[-300:]}")
        return said

    def tell_lab(self, word):
        """pause, resume, reset; 4: nobody saw yet that robots stand."""
        self.step(word, self.out / "roark.toml", codes=(0, 4))

    def try_in_vain(self, who):
        """Another program wants the port while nobody is reached by it; it ends so, or is killed."""
        (self.out / "program.hex").write_text(":020000000C945E\n:00000001FF\n")
        words = {"ohc": ("ohc", self.port, "pause"), "upload": ("ohc", self.port, "upload", self.out / "program.hex"),
                 "second lab": ("lab", self.out / "roark.toml", "--out", self.out / "second")}[who]
        with contextlib.suppress(subprocess.TimeoutExpired):
            code, said = self.command(*words, limit_s=8)
            if "arkmesh-guard" not in said and who == "ohc":  # it can end before the guard notices that the lab is gone
                code, said = self.command(*words, limit_s=8)
            self.wrong_if(code == 0 or "arkmesh-guard" not in said, f"{who} ends with {code} and does not say who tells the robots to stand: {said.strip()[-200:]}")

    def hang(self, what):
        """The lab stands still, for so long that its robots are told to stand, or for the fault's time."""
        began, process = self.emulator_time_s(), self.process()
        process.send_signal(signal.SIGSTOP)
        seconds = float(self.fault.split()[1]) if not what else 7
        time.sleep(seconds)
        if what in ("pause", "stop"):
            code, said = self.command(what, self.out / "roark.toml", limit_s=60)
            self.wrong_if(code != 1 or "hangs" not in said, f"{what} to a lab that hangs ends with {code} and says: {said.strip()[-200:]}")
        if seconds > HUNG_S:
            self.judge_stillness(began + HUNG_S + 0.5 - STAND_WITHIN_S)
        process.send_signal(signal.SIGKILL if what in ("stop", "SIGKILL") else signal.SIGCONT)
        if what in ("stop", "SIGKILL"):
            process.wait()

    def stall(self, seconds, during):
        """The line holds bytes back for so long; the lab is told to pause a second after that began, or a second after it ended."""
        begin = self.emulator_time_s()
        self.tell_emulator(f"ohc stall {seconds}")
        self.until_emulated(begin + (1 if during else seconds + 1))
        told = self.emulator_time_s()
        self.tell_lab("pause")
        self.judge_stillness(max(begin + seconds, told))
        self.command("resume", self.out / "roark.toml")

    def end_fault(self):
        """What comes after the fault: the peer starts, the link is mended."""
        if self.phase == "waiting at 0" and self.fault == "link cut":
            time.sleep(6)
            self.waits = self.state()
            if self.lives():
                self.process().send_signal(signal.SIGINT)
        elif self.phase == "waiting at 0" and self.lives() and self.fault not in ("Ctrl-C", "SIGTERM", "peer's states refused"):
            if self.fault == "link cut 4 s":
                self.link.mend()
            self.start_lab("shark", again=self.fault == "peer killed")
        elif self.fault == "link cut 4 s" or (self.phase == "waiting in mid-run" and self.promise.end != "stopped" and self.fault not in ("SIGKILL", "link cut")):
            time.sleep(0.5)
            self.link.mend()

    def tell_emulator(self, line):
        with socket.create_connection(("127.0.0.1", CONTROL), timeout=300) as port:
            port.sendall(line.encode() + b"\n")
            return port.makefile().readline().strip()

    def emulator_time_s(self):
        return float(re.search(r"time_s=([\d.]+)", self.tell_emulator("status"))[1])

    def until_emulated(self, time_s):
        self.until(300, lambda: self.emulator_time_s() > time_s, "the emulator's time")

    # ------------------------------------------------------------ the end

    def limit_s(self, lab, end):
        """How long after the fault a lab may take to end so."""
        if end == "finished" or self.fault in ("disk full", "run folder removed"):  # they run to the end
            return 180 + (0 if self.arena == "simulated" else self.pace.duration_s)
        return NOTICES_S + (self.patience_s if end == "failed" or lab == "shark" else 0) + (SEEN_TO_STAND_S if self.arena == "hardware" else 0)

    def wait_for_ends(self, since):
        """{lab: seconds from the fault to its end}; a lab that is not over in time is a problem. The hardware's robots are looked at meanwhile."""
        wanted = {"roark": self.promise.end, "shark": self.promise.peer}
        if self.impostor or wanted["shark"] is None or ("lab", "shark") not in self.labs.processes:
            del wanted["shark"]
        still, before = None, {lab: run_delay_s(self.process(lab).pid) for lab in wanted}
        while open_ := [lab for lab in wanted if lab not in self.ended]:
            for lab in open_:
                if not self.lives(lab):
                    self.ended[lab] = time.monotonic() - since
                    if lab == "roark" and self.arena == "hardware":
                        still = max(self.emulator_time_s(), self.line_back_s)
                elif time.monotonic() - since > self.limit_s(lab, wanted[lab]) + run_delay_s(self.process(lab).pid) - before[lab]:
                    self.ended[lab] = None
                    self.problems.append(f"{lab} has not ended {self.limit_s(lab, wanted[lab]):.0f} s after the fault; it says: {self.ears[lab].state()[:150]}")
            time.sleep(0.02)
        if still is not None:
            self.judge_stillness(still)

    def truth(self):
        """Whole rows of the emulator's record; the last one may be half written."""
        with open(self.out / "truth.csv", newline="") as truth:
            return [row for row in csv.DictReader(truth) if row["in_arena"]]

    def judge_stillness(self, end_s):
        """By the emulator's truth robots stand still from then on."""
        begin_s, places = end_s + STAND_WITHIN_S, {}
        self.until_emulated(begin_s + 2.5)
        for row in self.truth():
            if begin_s <= float(row["time_s"]) <= begin_s + 2:
                places.setdefault(row["robot"], []).append([float(row[key]) for key in ("x_m", "y_m", "heading_rad")])
        moved = sum(max(abs(a - b) for a, b in zip(way[0], way[-1])) > 5e-4 for way in places.values())
        if moved or len(places) != self.robots:
            self.problems.append(f"{moved} of {len(places)} robots that the emulator's record holds, of {self.robots}, move {STAND_WITHIN_S} s after the end")

    def result_of(self, lab):
        if lab == "roark" and self.fault == "run folder removed":
            text = self.said()
            with contextlib.suppress(ValueError):
                return json.JSONDecoder().raw_decode(text, text.index("{\n"))[0]
            return {}
        try:
            return json.loads((self.folders[lab] / "result.json").read_text())
        except FileNotFoundError:
            return {}
        except ValueError:
            self.problems.append(f"result.json of {lab} is no JSON ({(self.folders[lab] / 'result.json').stat().st_size} bytes)")
            return {}

    def judge_lab(self, lab, end, says):
        if end is None or (lab not in self.ended and end != "killed") or self.ended.get(lab, 0) is None:
            return
        code = self.process(lab).poll()
        wanted = campaign_promises.EXIT_CODES[end] if lab != "roark" or self.promise.code is None else self.promise.code
        result = self.result_of(lab)
        away_ms = result.get("counters", {}).get("arena.lab.longest_pause_ms")
        if away_ms is not None and not self.fault.startswith(("hangs", "SIGSTOP")):
            self.figures["lab_away_ms"] = away_ms
        if code == 4 and wanted == campaign_promises.EXIT_CODES["stopped"] and result.get("not_standing"):
            wanted = 4  # its cameras did not see robots stand in time; whether they do, the emulator's record says
        self.wrong_if(code != wanted, f"{lab} ended with code {code} instead of {wanted}: {self.labs.last_words('lab', lab)[:200]}")
        state, wanted = result.get("state", "no result"), "running" if end == "killed" else end
        # another lab has been started beside it; where there is no terminal, it was refused before
        wanted = end if self.fault == "second lab in vain, line away" and lab == "roark" else wanted
        self.wrong_if(state != wanted and not (state == "finished" and self.promise.may_be_finished), f"the result of {lab} says {state} instead of {wanted}")
        words = f"{self.said(lab)}\n{result.get('ended', '')}\n{self.waits if lab == 'roark' else ''}"
        self.wrong_if(says and not re.search(says, words), f"{lab} does not say /{says}/ but: {str(result.get('ended') or self.labs.last_words('lab', lab))[:200]}")
        if (end == "finished" or self.fault == "full disk") and self.arena == "simulated" and result.get("final_hash") not in (self.hash, None):
            self.problems.append(f"{lab} has hash {result['final_hash']} instead of {self.hash}")

    def judge_recording(self):
        if self.fault == "run folder removed":
            said = self.said()
            if said.count("stopped: the folder was removed") > 1 or not re.search("the folder was removed|is printed instead", said):
                self.problems.append(f"that the folder was removed is said {said.count('the folder was removed')} times")
            return
        try:
            worlds = sum(channel == "world" for _, channel, _ in read_log.events(read_log.log_in(self.folders["roark"])))
        except OSError as error:
            worlds = 0
            self.problems.append(f"no recording ({error.strerror})")
        least = 1 if self.phase == "waiting at 0" else self.pace.fault_at
        self.wrong_if(self.fault != "disk full" and 0 < worlds < least, f"the recording holds {worlds} states of at least {least}")

    def judge_next_start(self):
        """After a kill the next start beside it marks the result."""
        with contextlib.suppress(FileNotFoundError, ValueError):
            process = json.loads((self.folders["roark"] / "result.json").read_text()).get("process", {})
            self.wrong_if(process.get("pid") != self.process().pid, f"result.json of the killed lab names process {process.get('pid')}, not {self.process().pid}")
        killed = self.process()
        again = self.folders["roark"].with_name("roark-again")
        self.labs.start("lab", "roark", again)
        begin = time.monotonic()
        while self.lives() and not (again / "config.toml").exists() and time.monotonic() - begin < 300:
            time.sleep(0.05)
        time.sleep(0.5)
        self.process().send_signal(signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process().wait(300)
        self.labs.processes["lab", "roark"] = killed
        state = self.result_of("roark").get("state", "no result")
        if state != "killed" and not (state == "finished" and self.promise.may_be_finished):
            self.problems.append(f"after the next start the killed lab's result says {state} instead of killed")

    # ------------------------------------------------------------ all of it

    def listen(self):
        return {lab: BusEar(port, ["status", "world", "roark/world"]) for lab, port in PORTS.items()}

    @contextlib.contextmanager
    def prepared(self, own_overrides=None):
        """Files, ears, the link and the emulator are there; whatever is started within is ended."""
        self.out.mkdir(parents=True, exist_ok=True)
        if self.fault == "disk full":
            small_disk(self.folders["roark"].parent)
        (self.out / "fail").mkdir()
        os.environ["ARKMESH_FAIL_IN"] = str(self.out / "fail")
        self.labs = LabProcesses(self.write_files(), self.out, own_overrides=own_overrides, program=self.program)
        self.ears = self.listen()
        self.link = Link(THROUGH, LISTENS)
        with contextlib.ExitStack() as ending:
            ending.callback(self.labs.stop)
            if self.arena == "hardware":
                more = ["--calibration", self.out / "testbed.yaml"]
                ending.enter_context(emulated_testbed(self.out, self.program, self.out / "emulator.toml", more))
            yield

    def run(self):
        """What was wrong, as sentences; empty when the promise was kept."""
        try:
            with self.prepared():
                self.play()
        except (Failed, subprocess.TimeoutExpired) as failure:
            self.problems.append(f"not brought about: {failure}")
        return self.problems

    def play(self):
        self.enter_phase()
        if not self.lives() and not (self.phase == "ending" or self.fault == "program crash"):
            raise Failed(f"the lab ended before the fault: {self.labs.last_words('lab', 'roark')}")
        begin = time.monotonic()
        self.do_fault()
        if self.fault == "SIGSTOP 20 s":
            begin = time.monotonic()
        self.end_fault()
        self.wait_for_ends(begin)
        self.judge_lab("roark", self.promise.end, self.promise.says)
        if "shark" in self.ended or self.promise.peer == "killed":
            self.judge_lab("shark", self.promise.peer, self.promise.peer_says)
        self.judge_recording()
        if self.promise.end == "killed":
            self.judge_next_start()
