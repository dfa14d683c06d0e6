# Robots whose wheels a lab can set come to those of the other labs.
import arkmesh
import numpy


class Meet(arkmesh.Scenario):
    def begin(self, lab):
        self.speed = lab.setting("speed_m_per_s", 0.1, low=0.01, high=0.15, unit="m/s", about="of a robot on its way")
        self.near = lab.setting("near_m", 0.15, low=0.01, high=10, unit="m", about="where it stops, in the shared world")

    def frame(self, lab):
        if not lab.wheels_m_per_s or len(lab.others.ids) == 0:
            return
        way = lab.others.xy.mean(axis=0) - lab.xy
        turn = numpy.remainder(numpy.arctan2(way[:, 1], way[:, 0]) - lab.heading + numpy.pi, 2 * numpy.pi) - numpy.pi
        goes = self.far(lab) > self.near
        ahead, aside = goes * self.speed * numpy.maximum(numpy.cos(turn), 0), goes * 0.05 * numpy.clip(turn, -1, 1)
        lab.drive(lab.seen, ahead - aside, ahead + aside)

    def period(self, lab):
        if lab.wheels_m_per_s and len(lab.others.ids):
            lab.row("met", time_s=round(lab.now_s, 1), near=int((self.far(lab) < 1.5 * self.near).sum()))

    @staticmethod
    def far(lab):
        way = lab.shared_xy - lab.others.shared_xy.mean(axis=0)
        return numpy.hypot(way[:, 0], way[:, 1])
