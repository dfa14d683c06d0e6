# Robots choose between two sites. A robot decides when enough others near it favour the same one. How many are right, and when?
import arkmesh
import numpy

OPINION = numpy.array([-1, 0, -1, 0, 1, -1, 1, -1, -1])  # of an LED: red and yellow are for site 0, blue and cyan for site 1
DECIDED = numpy.isin(numpy.arange(9), (3, 6))  # yellow or cyan


class BestOfN(arkmesh.Scenario):
    every = 10  # once a second

    def begin(self, lab):
        quorum = lab.setting("quorum", 3, low=1, high=7, about="so many others of its opinion, and a robot decides")
        reach = lab.setting("range_m", 0.25, low=0.02, high=2, unit="m", about="how far robots hear each other")
        self.noise = lab.setting("noise", 2.0, low=0, high=8, about="s.d. of what a robot senses of a quality, of 15")
        alike = lab.setting("alike", False, about="true: both sites are of the same quality")
        self.limit = lab.setting("limit_s", 1800, low=1, high=100_000, unit="s", about="the run ends then at the latest")
        lab.parameters([quorum] + 8 * [0], message_type=1)
        self.better = int(lab.random("better").integers(2))  # in the west or in the east
        self.qualities = numpy.full(2, 8.0) if alike else numpy.where(numpy.arange(2) == self.better, 12.0, 4.0)
        self.sites = [lab.region(centre=(x, 0), radius=0.15, label=f"{q:g}", colour="region_rich" if q > 8 else "region_poor")
                      for x, q in zip((-0.25, 0.25), self.qualities)]
        self.voices = lab.voices("opinions", 2, reach)
        self.over = False

    def frame(self, lab):
        self.voices.say(lab.seen, OPINION[lab.led])
        heard, random = self.voices.heard, lab.random("robots")
        # what a robot learns of: the site that it is at, else the opinion of a neighbour, whichever
        one = random.random(len(lab.ids)) * heard.sum(axis=1) >= heard[:, 0]
        site = numpy.where(heard.any(axis=1), 1 + one, 0)
        for k, each in enumerate(self.sites):
            site[each.inside] = 1 + k
        quality = self.qualities[site - 1] + random.normal(0, self.noise, len(lab.ids))
        many = heard.clip(0, 7)
        lab.tell(lab.seen, kind=site, value=quality.round().clip(0, 15) * 64 + many[:, 0] * 8 + many[:, 1], shown=lab.seen)

    def period(self, lab):
        opinions, decided = OPINION[lab.led], DECIDED[lab.led].mean()
        right = (opinions == self.better).sum() / max(1, (opinions >= 0).sum())
        lab.row("decided", time_s=round(lab.now_s, 1), share=round(float(decided), 3), right=round(float(right), 3))
        if decided >= 0.9 or lab.now_s >= self.limit:
            lab.count("right_pct", round(100 * right))
            lab.count("decided_s", round(lab.now_s))
            self.over = True

    def finished(self, lab):
        return self.over
