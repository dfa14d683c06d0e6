# Robots are told how many others are near, and stay where there are some. How long until half of them are in a group?
import arkmesh


class Aggregation(arkmesh.Scenario):
    def begin(self, lab):
        self.crowd = lab.crowd(lab.setting("range_m", 0.1, low=0.02, high=1, unit="m", about="how far a robot sees others"))
        self.sees = lab.setting("sees", True, about="false: robots are told that nobody is near")
        self.half = None

    def frame(self, lab):
        lab.tell(lab.seen, value=self.crowd.count.clip(0, 15) * self.sees)

    def period(self, lab):
        grouped = ((self.crowd.count >= 2) & (lab.led == 1)).mean()
        lab.row("grouped", time_s=round(lab.now_s, 1), share=round(float(grouped), 3))
        if self.half is None:
            lab.count("until_half_s", lab.period_s)
            self.half = lab.now_s if grouped >= 0.5 else None
