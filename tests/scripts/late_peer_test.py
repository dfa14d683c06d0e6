"""A lab on emulated hardware in real time that is ready long before its peer: it looks at its robots, serves its overhead controller and shows
its arena meanwhile, so that nothing is missing when the run begins."""
import json
import pathlib
import signal
import tempfile
import time
import unittest

import run_folder  # noqa: F401  (makes the scripts importable)
import page_viewers
import read_log
from campaign_cell import Cell
from lab_processes import PROGRAM

PAGE_PORT = 7991


def pictures(count):
    """Different camera pictures that the lab's page gets, until so many have come."""
    seen, got, end = set(), b"", time.monotonic() + 300
    with page_viewers.join(PAGE_PORT) as page:
        while len(seen) < count and time.monotonic() < end:
            got += page.recv(1 << 16)
            seen = set(got.split(b"\xff\xd8\xff")[1:-1])  # where a JPEG begins
    return seen


class LatePeer(unittest.TestCase):
    def test_waits_with_open_eyes(self):
        """Every frame from the first on holds everybody, and nothing was withheld; the controller was unplugged and plugged in meanwhile."""
        if not PROGRAM.exists():
            self.skipTest("scripts/build has not been run")
        frames, counters = self.run_with_late_peer()
        # the camera is as slow as the lab: now and then a frame has no new picture, which is counted
        self.assertLessEqual(len(set(range(10)) - {frame.number for frame in frames}), counters.get("arena.frame.no_picture", 0))
        withheld = [name for name, count in counters.items() if "withheld" in name and count]
        held = {len(frame.robots) for frame in frames}
        self.assertEqual(max(held), Cell.robots, counters)
        # robots are hidden from a lab that has no picture for 0.2 s, as on a machine that stands still: it names them again
        if not counters.get("arena.poses.lost.no_picture"):
            self.assertEqual((held, withheld), ({Cell.robots}, []), counters)

    def run_with_late_peer(self):
        """The frames and the counters of a run whose peer comes late."""
        with tempfile.TemporaryDirectory() as folder:
            cell = Cell("hardware", "waiting at 0", "SIGTERM", pathlib.Path(folder), PROGRAM, "")
            with cell.prepared({"roark": ["view.use=true", f"view.port={PAGE_PORT}"]}):
                cell.enter_phase()
                self.assertEqual(len(pictures(5)), 5)
                self.assertTrue(cell.state().startswith("waiting for shark"), cell.state())
                cell.tell_emulator("ohc unplug")
                cell.until(300, lambda: "the overhead controller is gone" in cell.said(), "a controller that is unplugged")
                cell.tell_emulator("ohc plug")
                cell.until(300, lambda: cell.said().count("the overhead controller listens") == 2, "a controller that is plugged in")
                cell.start_lab("shark")
                cell.until(300, lambda: cell.ears["roark"].period() >= 3, "the run")
                cell.process().send_signal(signal.SIGTERM)
                cell.process().wait(300)
                events = read_log.events(cell.folders["roark"] / "log.lcm")
                frames = [read_log.decode(data) for _, channel, data in events if channel == "poses"]
                return frames, json.loads((cell.folders["roark"] / "result.json").read_text())["counters"]


if __name__ == "__main__":
    unittest.main()
