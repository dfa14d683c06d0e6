# Robots are told in which sector the nearest robot of the owner's lab is, and gather there.
import arkmesh
import numpy

RED, GREEN, BLUE = 1, 2, 4
SHOWS = numpy.array([GREEN, RED, RED, RED, BLUE, BLUE, BLUE, BLUE])  # beacon.c's colour for each sector


class Beacon(arkmesh.Scenario):
    def begin(self, lab):
        self.reach = lab.setting("reach_m", 10.0, low=0.001, high=100, unit="m", about="how far robots sense, in the shared world")
        self.near = lab.setting("near_m", 0.15, low=0.001, high=100, unit="m", about="what counts as gathered, in the shared world")

    def frame(self, lab):
        goals = lab.others.xy[lab.others.labs == lab.owner]
        if lab.is_owner or not len(goals):
            return
        way = goals - lab.xy[:, None]
        distance = numpy.linalg.norm(way, axis=2) * lab.scale
        nearest = way[numpy.arange(len(way)), distance.argmin(axis=1)]
        bearing = numpy.arctan2(nearest[:, 1], nearest[:, 0]) - lab.heading
        sector = numpy.nan_to_num(numpy.round(bearing / (numpy.pi / 4))).astype(int) % 8
        senses = lab.seen & (distance.min(axis=1) < self.reach)
        lab.tell(lab.seen, kind=senses, value=sector * senses, shown=lab.led == SHOWS[sector] * senses)

    def period(self, lab):
        if not lab.is_owner:
            goals = lab.others.shared_xy[lab.others.labs == lab.owner]
            gathered = int((arkmesh.within(lab.shared_xy, goals, self.near) & lab.seen).sum())
            lab.count("gathered_periods", gathered)
            lab.row("gathered", time_s=round(lab.now_s, 1), robots=gathered)
