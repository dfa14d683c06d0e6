"""STOP for a world of three labs: pause and stop of all at each of them, over each kind of link. Robots stand, or their lab is named."""
import contextlib
import csv
import itertools
import pathlib
import subprocess
import tempfile
import time
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
import campaign_files
from demo_run import emulated_testbed
from joined_networks import make_keys, start_nats_server
from lab_bus import BusEar
from lab_processes import PROGRAM, ROOT, LabProcesses, end_all

PORTS = {"lynx": 7703, **campaign_files.PORTS}
LISTEN, NATS = {"lynx": 7813, "shark": 7814}, 7815
CONNECTS = {"lynx": (), "shark": ("lynx",), "roark": ("lynx", "shark")}
ROBOTS, LIMIT_S, STAND_WITHIN_S = 3, 300, 3.5


class World(contextlib.ExitStack):
    """lynx, roark and shark; simulated as fast as they can (strict), or in real time with roark on an emulated testbed (free)."""

    def __init__(self, kind, free, unlisted="", absent="", duration_s=100_000.0, begun=lambda ears: all(ear.period() >= 3 for ear in ears.values())):
        super().__init__()
        self.out, self.free = pathlib.Path(self.enter_context(tempfile.TemporaryDirectory())), free
        if kind == "nats":
            server = start_nats_server(self.out, f'listen: "127.0.0.1:{NATS}"\n')
            self.callback(end_all, [server])
        make_keys(sorted(PORTS), self.out / "keys")
        tls, own = "tls://" if kind == "tls" else "", {}
        for lab in PORTS:
            peers = [f'{{lab="{other}"' + (f',connect="{tls}127.0.0.1:{LISTEN[other]}"}}' if other in CONNECTS[lab] else "}") for other in PORTS if other != lab]
            own[lab] = [f'gateway.keys="{self.out}/keys/{lab}"', *(["safety.commands_from=[]"] if lab == unlisted else
                        [f"safety.commands_from={[other for other in PORTS if other not in (lab, unlisted)]}"] if unlisted else [])]
            own[lab] += ['gateway.listen=""', "gateway.peers=[]", f'gateway.connect="nats://127.0.0.1:{NATS}"'] if kind == "nats" else [
                f'gateway.listen="{tls}127.0.0.1:{LISTEN[lab]}"' if lab in LISTEN else 'gateway.listen=""', f"gateway.peers=[{','.join(peers)}]"]
        if free:
            (self.out / "emulator.toml").write_text(campaign_files.emulator(ROBOTS))
            self.enter_context(emulated_testbed(self.out, PROGRAM, self.out / "emulator.toml", ["--calibration", self.out / "testbed.yaml"]))
        files = [self.file(lab) for lab in PORTS if lab != absent]
        for lab in PORTS:
            self.file(lab).write_text(campaign_files.LAB_TEXT.format(
                root=ROOT, lab=lab, bus=PORTS[lab], port="tcp://127.0.0.1:8091", duration_s=duration_s, period_s=0.5, robots=ROBOTS, out=self.out,
                patience_s=300, use="kilobot" if free and lab == "roark" else "ode", pace=1.0 if free else 0.0,
                side_m=1.0 if lab == "shark" else 0.5, controller=campaign_files.DHTF))
        self.ears = {lab: BusEar(port, ["status", "world"]) for lab, port in PORTS.items()}
        self.labs = self.enter_context(LabProcesses(files, self.out, ['shared.labs=["lynx","roark","shark"]', 'gate.on_peer_lost="go_on"'], own))
        self.until(lambda: begun(self.ears), "the phase")

    def file(self, lab):
        return self.out / f"{lab}.toml"

    def until(self, condition, what):
        end = time.monotonic() + LIMIT_S
        while not condition():
            if time.monotonic() > end:
                raise AssertionError(f"{what} has not come: " + str({lab: (ear.state(), self.labs.last_words("lab", lab)) for lab, ear in self.ears.items()}))
            time.sleep(0.02)

    def tell(self, word, lab, *more):
        """Code and words of a command at a lab."""
        done = subprocess.run([PROGRAM, word, *more, self.file(lab), *self.labs.overrides[lab]], capture_output=True, text=True, timeout=LIMIT_S)
        return done.returncode, done.stdout + done.stderr

    def emulator_time_s(self):
        with contextlib.suppress(IndexError, ValueError):
            return float((self.out / "truth.csv").read_text().splitlines()[-2].split(",")[0])
        return 0.0

    def places(self, since_s, until_s):
        """{robot: its places} by the emulator's record."""
        places = {}
        with open(self.out / "truth.csv", newline="") as truth:
            for row in csv.DictReader(truth):
                with contextlib.suppress(TypeError, ValueError):  # the last row may be half written
                    if since_s <= float(row["time_s"]) <= until_s:
                        places.setdefault(row["robot"], []).append([float(row[key]) for key in ("x_m", "y_m", "heading_rad")])
        return places


class WorldTest(unittest.TestCase):
    def stands(self, world, since_s):
        """The testbed's robots, from 3.5 s after that moment on."""
        world.until(lambda: world.emulator_time_s() > since_s + STAND_WITHIN_S + 2, "the emulator's time")
        places = world.places(since_s + STAND_WITHIN_S, since_s + STAND_WITHIN_S + 2)
        self.assertEqual(len(places), ROBOTS)
        for robot, way in places.items():
            self.assertLess(max(abs(a - b) for a, b in zip(way[0], way[-1])), 5e-4, f"robot {robot} moves")

    def pause(self, world, lab, reached):
        """Pauses all at `lab`; the labs that were reached say so, and of others it is said that they were not."""
        since_s = world.emulator_time_s() if world.free else 0
        code, said = world.tell("pause", lab, "--world")
        for each in PORTS:
            self.assertEqual(f"{each} paused its robots" in said or f"{each} told its robots to stop" in said, each in reached, said)
            self.assertIn(each, said)
        self.assertEqual(code in (0, 4), len(reached) == len(PORTS), said)
        if world.free and "roark" in reached:
            self.stands(world, since_s)

    def stop(self, world, lab, codes):
        """Stops all at `lab`; each ends with one of the codes, and the testbed's robots stand."""
        since_s = world.emulator_time_s() if world.free else 0
        code, said = world.tell("stop", lab, "--world")
        self.assertIn(code, (0, 4), said)
        for each in PORTS:
            self.assertIn(each, said)
            self.assertIn(world.labs.processes["lab", each].wait(LIMIT_S), codes, said)
        if world.free:
            self.stands(world, since_s)


@unittest.skipUnless(PROGRAM.exists(), "scripts/build has not been run")
class WorldStop(WorldTest):
    def test_stops_all(self):
        """Over each kind of link, strict and free; the word is given at another lab each time, and both ways each lab gives each."""
        for number, (kind, free) in enumerate(itertools.product(("tls", "nats", "tcp"), (False, True))):
            pauses_at, stops_at = (list(PORTS)[(number // 2 + more) % 3] for more in (0, 1))
            with self.subTest(kind=kind, free=free, stops_at=stops_at), World(kind, free) as world:
                self.pause(world, pauses_at, PORTS)
                for each in PORTS:
                    self.assertEqual(world.tell("resume", each)[0], 0)
                self.stop(world, stops_at, (3, 4) if free else (3,))


if __name__ == "__main__":
    unittest.main()
