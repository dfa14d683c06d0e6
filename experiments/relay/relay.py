# A colour spreads from one robot of the owner's lab to robots that are near one that shows it, of whichever lab.
import arkmesh
import numpy


class Relay(arkmesh.Scenario):
    def begin(self, lab):
        self.reach = lab.setting("reach_m", 0.15, low=0.001, high=100, unit="m", about="how near, in the shared world")
        self.has_it = numpy.zeros(len(lab.ids), dtype=bool)
        self.has_it[0] = lab.is_owner

    def frame(self, lab):
        shows = lab.seen & (lab.led % 8 != 0)
        lit = numpy.concatenate([lab.shared_xy[shows], lab.others.shared_xy[lab.others.led % 8 != 0]])
        reached = arkmesh.within(lab.shared_xy, lit, self.reach) & lab.seen & ~self.has_it
        self.has_it |= reached
        lab.count("reached", reached.sum())
        lab.tell(lab.seen, kind=self.has_it, shown=(lab.led % 8 != 0) == self.has_it)

    def period(self, lab):
        lab.row("lit", time_s=round(lab.now_s, 1), robots=int((lab.led % 8 != 0).sum()))
