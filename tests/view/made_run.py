"""A small run of two labs, made by hand: what every message of it says is known exactly. Also the encoder that writes its messages."""
import math
import struct

FORMATS = {"int8_t": "b", "byte": "B", "boolean": "?", "int16_t": "h", "int32_t": "i", "float": "f", "int64_t": "q", "double": "d"}
PERIOD_US = 2_000_000
FRAME_US = 100_000


def encode(types, name, values):
    """An LCM message of that type; counts that `values` leaves out follow from its lists."""
    return bytes.fromhex(types[name]["fingerprint"]) + body(types, name, values)


def body(types, name, values):
    out = b""
    counts = {dim: len(values[f["name"]]) for f in types[name]["fields"] for dim in f.get("dims", [])[:1] if f["name"] in values}
    for field in types[name]["fields"]:
        value = values.get(field["name"], counts.get(field["name"], [] if field.get("dims") else 0))
        items = value if field.get("dims") else [value]
        out += b"".join(one(types, field["type"], item) for item in items)
    return out


def one(types, kind, value):
    if kind in FORMATS:
        return struct.pack(">" + FORMATS[kind], value)
    if kind == "string":
        data = str(value or "").encode() + b"\0"
        return struct.pack(">I", len(data)) + data
    return body(types, kind, value)


def pose(robot, t_us, side_m=1.0, columns=4):
    """Where a robot is: on a circle of 5 cm around its place on a grid, once round in 60 s."""
    angle = t_us / 60e6 * 2 * math.pi + robot
    x = (robot % columns + 0.5) / columns * side_m - side_m / 2 + 0.05 * math.cos(angle)
    y = (robot // columns + 0.5) / columns * side_m - side_m / 2 + 0.05 * math.sin(angle)
    return {"robot": robot, "x_m": x, "y_m": y, "heading_rad": math.remainder(angle + math.pi / 2, 2 * math.pi), "led": 1 + robot % 7, "confidence": 0.3 if robot == 3 else 0.9}


def rows(types, seconds=60, labs=("shark", "roark"), robots=(12, 6)):
    """All messages as (t_us, lab, channel, data), in time order."""
    out, scale = [], {0: 1.0, 1: 2.0}
    for t_us in range(0, int(seconds * 1e6) + 1, FRAME_US):
        period = t_us // PERIOD_US
        for lab, name in enumerate(labs):
            side_m = 1.0 / scale[lab]

            def add(channel, kind, values):
                out.append((t_us, lab, channel, encode(types, kind, values)))
            if t_us % 60_000_000 == 0:
                add("arena", "arena_info_t", {
                    "lab": name, "platform": "ode", "width_m": side_m, "height_m": side_m, "can_wait": True, "frame_period_us": FRAME_US, "robots": robots[lab], "max_robot": 1022,
                    "kinds": 16, "values": 1024, "body_radius_m": 0.0165, "solids": [{"x_m": 0.3, "y_m": 0.3, "radius_m": 0.05}, {"x_m": -0.3, "y_m": 0.3, "first_corner": 0, "n_corners": 4},
                                                            {"x_m": 0, "y_m": 0, "radius_m": 0.04, "mass_kg": 0.1}] if lab == 0 else [],
                    "corners": [{"x_m": x, "y_m": y} for x, y in ((-0.05, -0.02), (0.05, -0.02), (0.05, 0.02), (-0.05, 0.02))] if lab == 0 else [],
                    "object_names": ["box"] if lab == 0 else []})
                add("shown", "shown_t", {"words": [{"of": "series.completed", "words": "tasks done", "curve": True}, {"of": "colour.site_hard", "words": "task: robots here + there"},
                                                   {"of": "led.4", "words": "walks"}]})
            frame = t_us // FRAME_US
            add("poses", "pose_frame_t", {"stamp_us": t_us, "number": frame, "parts": 1, "robots": [pose(i, t_us, side_m) for i in range(robots[lab])],
                                          "objects": [{"x_m": 0.001 * frame / 10, "y_m": 0, "confidence": 1}] if lab == 0 else []})
            if t_us % 1_000_000 == 0:
                add("to_robots", "to_robots_t", {"stamp_us": t_us, "frame": frame, "messages": [{"robot": 2, "slot": 0, "kind": 1, "value": period}],
                                                  "whole": [{"robot": -1, "slot": 3, "type": 9, "data": bytes((0, 255, period, 1, 2, 3, 4, 5, 6))}]})
            if t_us % PERIOD_US:
                continue
            views = [{"lab": n, "period": period, "age_periods": 1 if i != lab else 0, "fields": [{"name": "team", "values": [1, 2, period]}], "robots": [
                {"robot": r, "x_um": round(pose(r, t_us, 1 / scale[i])["x_m"] * scale[i] * 1e6), "y_um": round(pose(r, t_us, 1 / scale[i])["y_m"] * scale[i] * 1e6),
                 "heading_urad": round(pose(r, t_us, 1 / scale[i])["heading_rad"] * 1e6), "led": 1 + r % 7} for r in range(robots[i])]} for i, n in sorted(enumerate(labs), key=lambda x: x[1])]
            add("shared", "shared_view_t", {"stamp_us": t_us, "period": period, "scale": scale[lab], "labs": views})
            circle = {"x_m": 0.25 / scale[lab], "y_m": -0.25 / scale[lab], "radius_m": 0.08 / scale[lab], "colour": "site_hard", "filled": True, "label": f"1+{period}"}
            add("overlay", "overlay_t", {
                "stamp_us": t_us, "circles": [circle, circle | {"x_m": -0.25 / scale[lab], "colour": "site_idle", "filled": False, "dashed": True, "label": ""}],
                "polygons": [{"corners": [{"x_m": x / scale[lab], "y_m": y / scale[lab]} for x, y in ((-0.45, 0.0), (-0.25, 0.0), (-0.35, 0.2))], "colour": "region_rich", "filled": True, "label": "rich"}],
                "lines": [{"points": [{"x_m": -0.4 / scale[lab], "y_m": 0.45 / scale[lab]}, {"x_m": 0.4 / scale[lab], "y_m": 0.45 / scale[lab]}], "colour": "note"}],
                "texts": [{"x_m": 0.1 / scale[lab], "y_m": 0.4 / scale[lab], "colour": "warning", "text": "a word"}],
                "rasters": [{"x_m": 0.2 / scale[lab], "y_m": 0, "cell_m": 0.02 / scale[lab], "columns": 8, "rows": 8, "cells": [4 * i for i in range(64)], "colour": "pheromone", "label": "trace"}]})
            add("status", "lab_status_t", {
                "lab": name, "nonce": 0x2599_0102_0304_0507, "phase": 1 if period == 7 else 2, "state": "waiting for roark: link down" if period == 7 else "running", "stamp_us": t_us, "period": period, "last_period": int(seconds * 1e6) // PERIOD_US,
                "speed": 20.0, "can_wait": True, "counters": [{"name": "counts.completed", "value": period // 3}, {"name": "to_robots.replaced", "value": period}]})
            add("peers", "peers_t", {"lab": name, "peers": [{
                "lab": labs[1 - lab], "up": period != 7, "why": "as asked", "version": "1.0.0", "round_trip_us": 850, "clock_offset_us": -120, "clock_uncertainty_us": 400,
                "channels": [{"channel": f"{labs[1 - lab]}/world", "age_us": 20_000, "messages": period, "bytes": 1000 * period}], "counters": [{"name": "link.dropped.full", "value": 2}]}]})
            add("world", "world_t", {"lab": name, "nonce": 5 + lab, "window": [{"period": period, "behaviour": 1000 * lab + period}]})
    return sorted(out, key=lambda row: row[0])
