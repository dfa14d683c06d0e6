# Robots sense a floor badly, and hear what others think of it. How much may others count, so that the swarm follows when the floor changes?
import arkmesh
import numpy

BRIGHT = numpy.array([-1, 0, -1, -1, 1, -1, -1, -1, -1])  # what an LED says: red for dark, blue for bright


class Weights(arkmesh.Scenario):
    every = 10  # once a second

    def begin(self, lab):
        weight = lab.setting("weight", 0.25, low=0, high=1, about="of what others say; the rest is of what a robot senses itself")
        reach = lab.setting("range_m", 0.25, low=0.02, high=2, unit="m", about="how far robots hear each other")
        self.noise = lab.setting("noise", 0.1, low=0, high=0.5, about="share of readings that are wrong")
        self.hears = lab.setting("hears", True, about="false: robots are told that nobody is near")
        self.changes = lab.setting("changes", True, about="false: the floor stays as it is")
        self.change = lab.setting("change_s", 300, low=1, high=100_000, unit="s", about="when bright tiles become dark, and dark ones bright")
        self.last = lab.setting("last_s", 150, low=1, high=100_000, unit="s", about="the errors are means over so long")
        self.end = lab.setting("end_s", 900, low=1, high=100_000, unit="s", about="the end of the run")
        lab.parameters([round(64 * weight)] + 8 * [0], message_type=1)
        self.floor = lab.floor("floor", lab.width_m, lab.height_m, columns=20, rows=20, shares=(3, 1))  # three of four tiles are bright, level 0
        self.voices = lab.voices("thoughts", 2, reach)
        self.errors = {"before": [], "after": []}

    def frame(self, lab):
        self.voices.say(lab.seen, BRIGHT[lab.led])
        changed = self.changes and lab.now_s >= self.change
        wrong = lab.random("readings").random(len(lab.ids)) < self.noise
        reading = (self.floor.level == 0) ^ changed ^ wrong
        heard = self.voices.heard * self.hears
        near = heard.sum(axis=1)
        lab.tell(lab.seen, kind=4 + 2 * (near > 0) + reading, value=255 * heard[:, 1] // near.clip(1), shown=lab.seen)

    def period(self, lab):
        right = not self.changes or lab.now_s <= self.change
        error = (BRIGHT[lab.led] != right).mean()
        lab.row("wrong", time_s=round(lab.now_s, 1), share=round(float(error), 3))
        for name, until in (("before", self.change), ("after", self.end)):
            if until - self.last < lab.now_s <= until:
                self.errors[name].append(error)
            if lab.now_s == until:
                lab.count(f"wrong_{name}_pct", round(100 * numpy.mean(self.errors[name])))
