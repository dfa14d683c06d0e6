# Robots choose between two sites, one of which becomes the better one later. Do they follow? The farther they hear, the less.
import arkmesh
import numpy

OPINION = numpy.array([-1, 0, -1, -1, 1, -1, -1, -1, -1])  # of an LED: red is for site 0, blue for site 1


class Adaptation(arkmesh.Scenario):
    every = 10  # once a second

    def begin(self, lab):
        reach = lab.setting("range_m", 0.05, low=0.02, high=2, unit="m", about="how far robots hear each other")
        self.noise = lab.setting("noise", 1.0, low=0, high=8, about="s.d. of what a robot senses of a quality, of 15")
        self.hears = lab.setting("hears", True, about="false: robots are told that nobody is near")
        self.changes = lab.setting("changes", True, about="false: qualities stay as they are")
        self.change = lab.setting("change_s", 300, low=1, high=100_000, unit="s", about="when site 2 becomes the better one")
        self.last = lab.setting("last_s", 300, low=1, high=100_000, unit="s", about="the end of the run, over which right_pct is a mean")
        self.end = lab.setting("end_s", 1800, low=1, high=100_000, unit="s", about="the end of the run")
        self.sites = [lab.region(centre=(x, 0), radius=0.2, label=name) for x, name in ((-0.25, "site 1"), (0.25, "site 2"))]
        self.voices = lab.voices("opinions", 2, reach)
        self.shares = {"before": [], "after": []}

    def qualities(self, lab):
        return numpy.array([8.0, 13.0 if self.changes and lab.now_s >= self.change else 3.0])

    def frame(self, lab):
        self.voices.say(lab.seen, OPINION[lab.led])
        heard, random = self.voices.heard, lab.random("robots")
        at = self.sites[0].inside + 2 * self.sites[1].inside
        quality = self.qualities(lab)[at - 1] + random.normal(0, self.noise, len(lab.ids))
        # what most near it say: 1 or 2; 0 where nobody is near or both are as many
        most = numpy.where(heard[:, 0] > heard[:, 1], 1, 2 * (heard[:, 1] > heard[:, 0]))
        lab.tell(lab.seen, kind=at, value=quality.round().clip(0, 15) * 4 + most * self.hears, shown=lab.seen)

    def period(self, lab):
        opinions = OPINION[lab.led]
        share = (opinions == 1).sum() / max(1, (opinions >= 0).sum())
        lab.row("site2", time_s=round(lab.now_s, 1), share=round(float(share), 3))
        for name, until in (("before", self.change), ("after", self.end)):
            if until - self.last < lab.now_s <= until:
                self.shares[name].append(share)
            if lab.now_s == until:
                lab.count(f"{name}_pct", round(100 * numpy.mean(self.shares[name])))
