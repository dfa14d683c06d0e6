"""One cell about what robots know: a word or start parameters reach all robots, although some forget or miss them. A robot shows what it knows by its
LED, and the emulator's truth judges; see tests/campaign/campaign."""
import re
import time

import campaign_files
from campaign_cell import LINE_AWAY_S, Cell, Pace, failing_program
from lab_processes import Failed

OFF_S, AWAY_S = 15, 60  # both longer than robots.absent_s
KNOWS_WITHIN_S = 15     # of the fault's end; a robot that comes back is named first
SHOWS = {"word1": "green", "word2": "blue", "parameters": "red"}
ROBOT = """#include <arkmesh_id.h>
#include <kilolib.h>
static volatile uint8_t told, number;
static void on_message(message_t *message, distance_measurement_t *distance) {
  uint8_t i;
  (void)distance;
  if (message->type == 20) number = message->data[0];
  if (message->type != NORMAL) return;
  for (i = 0; i < 9; i += 3) {
    const uint8_t *block = message->data + i;
    if (((uint16_t)block[0] << 2 | block[1] >> 6) == kilo_uid) told = block[1] >> 2 & 15;
  }
}
static void setup(void) {}
static void loop(void) { set_color(told == 1 ? RGB(0, 3, 0) : told == 2 ? RGB(0, 0, 3) : number == 7 ? RGB(3, 0, 0) : RGB(0, 0, 0)); }
int main(void) {
  kilo_init();
  kilo_message_rx = on_message;
  kilo_start(setup, loop);
  return 0;
}
"""
SCENARIO = """import os
import arkmesh
class Words(arkmesh.Scenario):
    def begin(self, lab):
        if os.path.exists("{0}/parameters"):
            lab.parameters([7] * 9, 20)
    def frame(self, lab):
        for word in (2, 1):
            if os.path.exists("{0}/word%d" % word):
                return lab.tell(lab.seen, kind=word)
"""
HEAD = 'shared = {labs = ["roark", "shark"], owner = "shark"}\n'


class WordsCell(Cell):
    def __init__(self, language, _, fault, out, program, *more):
        super().__init__("hardware", "waiting at 0", fault, out, program, *more)
        self.language, self.patience_s, self.pace = language, 300, Pace(0.5, 1000.0, 6)
        self.program = failing_program(program) if language == "C++" else program  # which has the scenario
        self.what, self.when = fault.split(", ")

    def write_files(self):
        files = super().write_files()
        (self.out / "words.c").write_text(ROBOT)
        (self.out / "words.py").write_text(SCENARIO.format(self.out / "fail"))
        if self.what == "parameters":
            self.tell("parameters")
        scenario = "words" if self.language == "C++" else "words.py"
        for file in [*files, self.out / "emulator.toml"]:
            text = file.read_text().replace(str(campaign_files.DHTF), str(self.out / "words.c"))
            file.write_text(re.sub("^include.*\n", HEAD, text).replace("run.duration_s", f'run.scenario = "{scenario}"\nrun.duration_s'))
        return files

    def tell(self, what):
        (self.out / "fail" / what).touch()

    def seen(self):
        """{robot: its newest row of the emulator's truth}."""
        return {row["robot"]: row for row in self.truth()}

    def show(self, what, robots=("0", "1", "2")):
        rows = self.seen()
        return all(robot in rows and rows[robot]["led"] == SHOWS[what] for robot in robots)

    def until_shown(self, what):
        since_s = self.emulator_time_s()
        self.until(300, lambda: self.show(what) or self.emulator_time_s() > since_s + KNOWS_WITHIN_S, "the emulator's time")
        if not self.show(what):
            raise Failed(f"robots show {', '.join(row['led'] for row in self.seen().values())} and not {SHOWS[what]} {KNOWS_WITHIN_S} s after they were to")
        return self.emulator_time_s() - since_s

    def run_from(self, period):
        self.start_lab("shark")
        self.until(300, lambda: self.ears["roark"].period() >= period, "the run's beginning")

    def begin_fault(self):
        if self.what in ("reset", "parameters"):
            return self.tell_lab("reset")
        self.place = [self.seen()["0"][key] for key in ("x_m", "y_m")]
        self.tell_emulator("robot 0 kill" if self.what == "robot off and on" else "robot 0 take")

    def end_fault(self):
        if self.what in ("reset", "parameters"):
            return self.tell_lab("resume")
        said = self.tell_emulator("robot 0 revive" if self.what == "robot off and on" else "robot 0 put " + " ".join(self.place))
        if said != "ok":
            raise Failed(f"the emulator says: {said}")

    def words(self):
        self.run_from(self.pace.fault_at)
        last, away = "word1", self.when == "while the line is away"
        if self.when != "before words":
            self.tell(last)
            self.until_shown(last)
        if away:
            self.tell_emulator("ohc unplug")
        self.begin_fault()
        if self.when != "after words" or self.what == "robot away":
            last = "word1" if self.when == "before words" else "word2"
            self.tell(last)
        time.sleep({"reset": 3, "robot off and on": OFF_S, "robot away": AWAY_S}[self.what])
        if self.show(last, ["0"]):
            raise Failed("the fault has done nothing")
        self.end_fault()
        if away:
            self.tell_emulator("ohc plug")
        self.figures["knows_s"] = round(self.until_shown(last), 1)

    def parameters(self):
        if self.when == "line away at the start":
            self.tell_emulator("ohc unplug")
            self.run_from(2)
            self.tell_lab("pause")
            time.sleep(LINE_AWAY_S)
            self.tell_emulator("ohc plug")
        elif self.when == "pause before the start":
            self.tell_lab("pause")
            self.run_from(2)
        else:
            self.run_from(2)
            self.until_shown("parameters")
            self.begin_fault()
            time.sleep(3)
        if self.show("parameters", ["0"]):
            raise Failed("the fault has done nothing")
        self.tell_lab("resume")
        self.figures["knows_s"] = round(self.until_shown("parameters"), 1)

    def play(self):
        self.enter_phase()
        self.parameters() if self.what == "parameters" else self.words()
