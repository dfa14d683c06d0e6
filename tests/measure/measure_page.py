"""How fast the page draws: frames per frame of an empty page, and script time a frame, for 100 and 1000 robots with trails.

Chromium draws in software (--headless=new --disable-gpu), 1280x720; a stand-in for a lab's server sends 30 frames of poses a second. Empty page and
measured pages take turns, so that a busy machine slows all alike.
"""
import json
import math
import tempfile
import time

from lab_processes import Failed

COUNT = """
const done = arguments[arguments.length - 1], until = performance.now() + arguments[0] * 1000;
let frames = 0;
const step = (now) => { if (now < until) { frames += 1; requestAnimationFrame(step); } else done(frames); };
requestAnimationFrame(step);
"""


def rows(types, robots, side_m):
    """A minute of a lab in which robots drive in circles of their own."""
    from made_run import encode, pose
    columns = math.ceil(math.sqrt(robots))
    arena = {"lab": "lab", "platform": "ode", "width_m": side_m, "height_m": side_m, "body_radius_m": 0.0165, "frame_period_us": 100_000, "robots": robots}
    frames = ({"stamp_us": k * 100_000, "number": k, "parts": 1, "robots": [pose(i, k * 100_000, side_m, columns) for i in range(robots)]} for k in range(600))
    return [(0, 0, "arena", encode(types, "arena_info_t", arena)), *((frame["stamp_us"], 0, "poses", encode(types, "pose_frame_t", frame)) for frame in frames)]


def script_s(driver):
    metrics = driver.execute_cdp_cmd("Performance.getMetrics", {})["metrics"]
    return next(m["value"] for m in metrics if m["name"] == "ScriptDuration")


def measure(driver, url, seconds):
    """(frames, script milliseconds a frame) of that page."""
    driver.get(url)
    driver.execute_cdp_cmd("Performance.enable", {})
    time.sleep(2)
    before = script_s(driver)
    frames = driver.execute_async_script(COUNT, seconds)
    return frames, (script_s(driver) - before) * 1000 / max(1, frames)


def totals_of(seconds=5, rounds=3):
    """(frames, script milliseconds a frame) of each round, for no page, 100 and 1000 robots."""
    from chromium import browser  # needs scripts/setup film; other measures do without
    from double_server import Double, types_json
    with tempfile.TemporaryDirectory() as folder:
        types = types_json(folder)
    of = json.loads(types)["types"]
    servers = {robots: Double(["lab"], rows(of, robots, side_m), types, speed=3) for robots, side_m in ((100, 1.0), (1000, 3.0))}
    totals = {0: [], 100: [], 1000: []}
    with browser(1280, 720) as driver:
        driver.set_script_timeout(seconds + 30)
        for _ in range(rounds):
            for robots in totals:
                totals[robots].append(measure(driver, servers[robots].url if robots else "data:text/html,<title>empty</title>", seconds))
                if robots and (seen := driver.execute_script("return arkmesh.world.labs[0].robots.length")) != robots:
                    raise Failed(f"the page shows {seen} of {robots} robots")
    for server in servers.values():
        server.stop()
    return totals


def page_frames(bench):
    """frames of the page per frame of an empty one, and script time a frame"""
    totals = totals_of()
    empty = sum(frames for frames, _ in totals[0])
    share = {robots: sum(frames for frames, _ in each) / empty for robots, each in totals.items()}
    script_ms = {robots: sum(ms for _, ms in each) / len(each) for robots, each in totals.items()}
    met = share[100] >= 0.9 and share[1000] >= 0.5 and script_ms[100] <= 2 and script_ms[1000] <= 8
    return (met, f"{share[100]:.2f} and {share[1000]:.2f} of an empty page, script {script_ms[100]:.1f} and {script_ms[1000]:.1f} ms",
            "100 and 1000 robots: at least 0.9 and 0.5, at most 2 and 8 ms")


MEASURES = [page_frames]
NOT_JUDGED_SHORT = {page_frames}
