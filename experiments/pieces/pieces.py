# Each piece of the kit alone: robots light up where it senses something.
import math

import arkmesh


class Pieces(arkmesh.Scenario):
    def begin(self, lab):
        name = lab.setting("piece", "eyes", one_of=["eyes", "crowd", "region", "floor", "towards", "light", "trail", "voices"], about="which one")
        noise = lab.setting("noise", 0.0, low=0, high=1000, own=True, about="of its readings, in their unit")
        if name == "eyes":
            piece = lab.eyes(sectors=8, reach=0.12, noise=noise)
            self.senses = lambda: piece.bits > 0
        elif name == "crowd":
            piece = lab.crowd(reach=0.12, noise=noise)
            self.senses = lambda: piece.count >= 2
        elif name == "region":
            piece = lab.region(corners=[(-0.35, -0.3), (0.3, -0.2), (0.1, 0.35)], resource={"rate": 0.002, "growth": 0.01}, label="food", colour="resource")
            self.senses = lambda: piece.inside
        elif name == "floor":
            piece = lab.floor("tiles", lab.width_m, lab.height_m, 20, 20, shares=(2, 1), patch=1, noise=noise)
            self.senses = lambda: piece.level == 1
        elif name == "towards":
            piece = lab.towards((0.2, 0.2), noise=(noise, 0.0))
            lab.region(centre=(0.2, 0.2), radius=0.03, label="place")
            self.senses = lambda: abs(piece.bearing) < math.pi / 4
        elif name == "light":
            piece = lab.light(beams=[{"path": [(-0.3, 0), (0.3, 0)], "radius": 0.25, "speed": 0.02}], noise=noise)
            self.senses = lambda: piece.level > 500
        elif name == "trail":
            piece = lab.trail("trail", lab.width_m, lab.height_m, cell=0.02, half_life=20, diffusion=2e-5, zones=(4, math.pi, 0.06, 0.3), full=2)
            self.senses = lambda: piece.value > 0.5
        else:
            piece = lab.voices("talk", 2, reach=0.15)
            self.senses = lambda: piece.heard[:, 1] > 0
        self.piece, self.name = piece, name

    def frame(self, lab):
        if self.name == "trail":
            self.piece.lay(lab.ids % 5 == 0, 0.1)
        elif self.name == "voices":
            self.piece.say(lab.seen, (lab.ids % 10 == 0).astype(int))
        senses = self.senses()
        lab.tell(lab.seen, kind=senses, shown=(lab.led % 8 > 0) == senses)
