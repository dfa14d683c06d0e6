"""STOP for a world of three labs when not all is well: with a link cut, with a lab that hangs, by a lab that nobody listed, before the start, while robots
are named, and at the end. Over one kind of link each; with ARKMESH_THOROUGH over all."""
import os
import signal
import unittest

import world_stop_test
from world_stop_test import LIMIT_S, PORTS, World


def kinds(usual):
    return ("tls", "nats", "tcp") if os.environ.get("ARKMESH_THOROUGH") else (usual,)


@unittest.skipUnless(world_stop_test.PROGRAM.exists(), "scripts/build has not been run")
class WorldStopCases(world_stop_test.WorldTest):
    def test_names_who_is_not_reached(self):
        for kind in kinds("tls"):
            with self.subTest(kind=kind), World(kind, True) as world:
                world.labs.processes["gateway", "lynx"].kill()
                world.until(lambda: "without lynx" in world.ears["shark"].state(), "the loss of lynx")
                self.pause(world, "shark", ("roark", "shark"))

    def test_names_who_hangs(self):
        for kind in kinds("tcp"):
            with self.subTest(kind=kind), World(kind, True) as world:
                world.labs.processes["lab", "lynx"].send_signal(signal.SIGSTOP)
                self.pause(world, "shark", ("roark", "shark"))
                world.labs.processes["lab", "lynx"].send_signal(signal.SIGCONT)

    def test_obeys_nobody_who_is_not_listed(self):
        for kind in kinds("nats"):
            with self.subTest(kind=kind), World(kind, False, unlisted="lynx") as world:
                code, said = world.tell("pause", "lynx", "--world")
                self.assertEqual(code, 1, said)
                for lab in ("roark", "shark"):
                    self.assertIn(f"{lab} refused the command: no_permission", said)
                    self.assertNotEqual(world.ears[lab].message("status").kept_still, "operator")

    def test_before_the_start(self):
        """Labs that wait for one that is not there yet obey, and that one is named."""
        for kind in kinds("nats"):
            with self.subTest(kind=kind), World(kind, False, absent="roark", begun=lambda ears: all(
                    "waiting for roark" in ears[lab].state() for lab in ("lynx", "shark"))) as world:
                self.pause(world, "lynx", ("lynx", "shark"))
                code, said = world.tell("stop", "shark", "--world")
                self.assertEqual(code, 1, said)
                self.assertIn("roark is not heard", said)
                self.assertEqual([world.labs.processes["lab", lab].wait(LIMIT_S) for lab in ("lynx", "shark")], [3, 3], said)

    def test_while_robots_are_named(self):
        for kind in kinds("tls"):
            with self.subTest(kind=kind), World(kind, True, begun=lambda ears: "waiting for the testbed" in ears["roark"].state() and ears["lynx"].period() >= 0) as world:
                self.stop(world, "lynx", (3, 4))

    def test_at_the_end(self):
        """A result that stands stays; robots are told to stand."""
        for kind in kinds("tcp"):
            with self.subTest(kind=kind), World(kind, True, duration_s=6.0, begun=lambda ears: any(
                    ear.state().startswith("finished") for ear in ears.values())) as world:
                self.stop(world, "roark", (0, 3, 4))


if __name__ == "__main__":
    unittest.main()
