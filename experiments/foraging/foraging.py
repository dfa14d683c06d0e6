# Robots bring food from the east to the nest in the west, lay pheromone on their way home, and follow it. How many trips?
import arkmesh
import numpy

NEST, FOOD, RADIUS = numpy.array([-0.33, 0.0]), numpy.array([0.33, 0.0]), 0.1


class Foraging(arkmesh.Scenario):
    def begin(self, lab):
        half_life = lab.setting("half_life_s", 60.0, low=1, high=100_000, unit="s", about="after which half of the pheromone is left")
        self.smells = lab.setting("smells", True, about="false: robots are told that there is no pheromone")
        shares = lab.setting("shares", True, about="false: each lab has a trail of its own")
        trails = {each: lab.trail(f"of_{each}", lab.width_m, lab.height_m, cell=0.02, half_life=half_life, cap=5, full=2,
                                  zones=(4, numpy.pi, 0.06, 0.3)) for each in (["all"] if shares else lab.labs)}
        self.trail = trails["all" if shares else lab.name]
        lab.declare("trips")
        lab.show("trips", "trips home", curve=True)
        lab.legend(4, "carries food")
        lab.legend(2, "looks for food")
        self.carries, self.trips, self.counted = numpy.zeros(len(lab.ids), dtype=bool), 0, 0

    def frame(self, lab):
        home = self.carries & (numpy.hypot(*(lab.xy - NEST).T) < RADIUS)
        self.trips += int(home.sum())
        lab.publish("trips", self.trips)
        self.carries = (self.carries & ~home) | (numpy.hypot(*(lab.xy - FOOD).T) < RADIUS)
        self.trail.lay(self.carries & (lab.led == 4), 0.2)
        bearing = numpy.arctan2(*(NEST - lab.xy).T[::-1]) - lab.heading
        sector = numpy.rint(bearing / (numpy.pi / 6)).astype(int) % 12
        # outwards: what lies towards the nest is no news
        away = numpy.cos(bearing) < 0
        lab.tell(lab.seen, kind=self.carries, value=numpy.where(self.carries, sector, self.trail.zones * (away & self.smells)),
                 shown=(lab.led == 4) == self.carries)

    def period(self, lab):
        trips = int(lab.field(lab.name, "trips").sum())
        lab.count("trips", trips - self.counted)
        self.counted = trips
        for place, name in ((NEST, "nest"), (FOOD, "food")):
            lab.circle(place, RADIUS, label=name)
