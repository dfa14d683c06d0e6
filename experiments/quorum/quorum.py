# Robots light up when enough robots of all labs are near in the shared world.
import arkmesh
import numpy


class Quorum(arkmesh.Scenario):
    def begin(self, lab):
        self.reach = lab.setting("reach_m", 0.25, low=0.001, high=100, unit="m", about="how near, in the shared world")
        self.least = lab.setting("robots", 5, low=1, high=1000, about="how many others there must be")

    def frame(self, lab):
        everyone = numpy.concatenate([lab.shared_xy[lab.seen], lab.others.shared_xy])
        distances = numpy.linalg.norm(lab.shared_xy[:, None] - everyone, axis=2)
        near = (distances < self.reach).sum(axis=1) - 1  # not the robot itself
        enough = (near >= self.least) & lab.seen
        lab.tell(lab.seen, kind=enough, shown=(lab.led % 8 != 0) == enough)

    def period(self, lab):
        lab.count("lit_periods", (lab.led % 8 != 0).sum())
        lab.row("lit", time_s=round(lab.now_s, 1), robots=int((lab.led % 8 != 0).sum()))
