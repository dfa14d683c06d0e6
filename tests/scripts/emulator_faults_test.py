"""A lab on an emulated testbed, both processes of their own: faults given over the emulator's command port are noticed by the lab, which comes
through them, and are in its counters afterwards."""
import unittest

from emulated_lab import EmulatedLab


class EmulatorFaults(EmulatedLab):
    def test_faults(self):
        self.begin()

        def sees_again(times):
            return lambda: self.said("lab").count("the cameras see the testbed again") >= times
        self.command("camera camera0 gone")
        self.until(300, lambda: "the cameras have delivered no picture" in self.said("lab"), "a camera that is gone")
        self.command("camera camera0 ok")
        self.until(300, sees_again(1), "a camera that is back")
        self.command("camera camera0 frozen")
        self.until(300, lambda: self.said("lab").count("the cameras have delivered no picture") == 2, "a camera that is frozen")
        self.command("camera camera0 ok")
        self.until(300, sees_again(2), "a camera that is frozen no more")
        self.command("camera camera0 move 0.02 0")
        self.until(300, lambda: "was moved" in self.said("lab"), "a camera that is knocked about")
        self.until(300, sees_again(3), "a calibration that follows")
        self.command("ohc unplug")
        self.until(300, lambda: "the overhead controller is gone" in self.said("lab"), "a controller that is unplugged")
        self.command("ohc plug")
        self.command("ohc garbage 500")
        self.until(300, lambda: self.said("lab").count("the overhead controller listens") == 2, "a controller that is plugged in")
        _, result = self.end_lab()
        for name in ("camera.gone", "camera.frozen", "camera.moved", "camera.realigned", "overhead.port_lost", "poses.lost.no_picture"):
            self.assertGreater(result["counters"].get(f"arena.{name}", 0), 0, f"{name} of {result['counters']}")


if __name__ == "__main__":
    unittest.main()
