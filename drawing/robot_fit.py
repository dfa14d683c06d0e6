"""What single robots are like, from their tracks: the estimates of `arkmesh fit robots`. Pure: no files, no figures.

A track is a dict of arrays over frames: t (s), z (m, x + iy), direction (rad, of the LED or the body; NaN where it was not seen) and led (1 red, 2 green,
4 blue, 7 white). Robots run firmware/fit_robots.c, whose LED tells what they do; robots that walk freely tell less."""
import math

import numpy

import intervals

STRAIGHT, LEFT, RIGHT, REST = 2, 1, 4, 7
BEGIN_S, END_S, LEAST_S, GAP_S = 0.7, 0.3, 2.0, 0.35  # cut from each stretch; the shortest one; a longer gap ends it
NEAR_M, LEAST_SPEED_M_S, LEAST_TURN = 0.036, 0.002, math.radians(4)  # centres that near may touch; slower ones hardly move
PIVOT = math.atan2(9.9, 27.7 / 2)  # between heading and path of a robot that pivots about a rear leg: hal/platforms/kilobot/body.hpp
SLANT, TILT, SCALE = math.radians(0.15), math.radians(0.5), 0.01  # what lens, floor and battery add, whatever time is spent, to a turn rate (/s), a bearing, a speed; assumed
FOLLOWS = 0.92  # share of a wrong bearing that is in a tracked heading, 0.83 to 1.08 among 18 emulated robots
POOLED, LAGS_S, TIMES_S = 10, (0.6, 1, 1.5, 2, 3, 4, 6), numpy.geomspace(0.25, 6, 24)
KEYS = ("speed_m_per_s", "drift_deg_per_s", "turn_left_deg_per_s", "turn_right_deg_per_s", "turn_noise_deg_per_s", "turn_noise_s", "led_bearing_deg")


def wrapped(angle):
    return (numpy.asarray(angle) + math.pi) % (2 * math.pi) - math.pi


def stretches(track, keep):
    """(led, indices) of each time that the LED kept its colour, without its beginning and end."""
    led = track["led"].copy()
    if len(led) > 4:  # a colour that was mistaken for three frames or fewer
        windows = numpy.lib.stride_tricks.sliding_window_view(led, 5)
        led[2:-2] = numpy.where(windows[:, 0] == windows[:, 4], windows[:, 0], led[2:-2])
    breaks = numpy.flatnonzero((numpy.diff(led) != 0) | (numpy.diff(track["t"]) > GAP_S) | numpy.diff(keep)) + 1
    for part in numpy.split(numpy.arange(len(led)), breaks):
        t = track["t"][part]
        part = part[(t >= t[0] + BEGIN_S) & (t <= t[-1] - END_S)] if len(part) else part
        if len(part) > 5 and keep[part].all() and numpy.ptp(track["t"][part]) >= LEAST_S:
            yield led[part[0]], part


def free_stretches(track, keep):
    """The same of robots that walk freely: whatever looks straight."""
    t, z = track["t"], track["z"]
    ahead = numpy.searchsorted(t, t + 1.0).clip(max=len(t) - 1)
    step, span = z[ahead] - z, numpy.maximum(t[ahead] - t, 1e-9)
    speed = abs(step) / span
    turn = abs(wrapped(numpy.angle(step[ahead]) - numpy.angle(step))) / span
    straight = numpy.where((speed > LEAST_SPEED_M_S) & (turn < math.radians(14)) & (span < 1.5), STRAIGHT, 0)
    yield from ((led, part) for led, part in stretches({**track, "led": straight}, keep) if led == STRAIGHT)


def line(t, angle):
    """Angle in the middle and its rate, without outliers; None where too little was seen."""
    seen = numpy.isfinite(angle)
    if seen.sum() < max(6, 0.6 * len(t)):
        return None
    t, angle = t[seen], numpy.unwrap(angle[seen])
    rate = numpy.median(numpy.diff(angle) / numpy.diff(t))
    off = wrapped(angle - rate * t)  # without turns that an outlier made
    angle = rate * t + numpy.unwrap(off)
    for _ in range(2):
        slope, middle = numpy.polyfit(t, angle, 1)
        left = abs(angle - middle - slope * t)
        keep = left <= max(4 * 1.4826 * numpy.median(left), math.radians(2))
        t, angle = t[keep], angle[keep]
    # what wanders grows with time: its ends tell a rate better than a straight line through all of it
    ends = [(t[part].mean(), angle[part].mean()) for part in (t < t[0] + 0.5, t > t[-1] - 0.5)]
    return middle, (ends[1][1] - ends[0][1]) / (ends[1][0] - ends[0][0])


def measure(led, track, part):
    """One stretch: turn rate, speed, bearing of the LED; None where it cannot be told, or where the robot did not move evenly."""
    t, z = track["t"][part], track["z"][part]
    t = t - (t[0] + t[-1]) / 2
    told = line(t, track["direction"][part])
    if led == REST or not told and led != STRAIGHT:
        return None
    if told:
        rate = told[1]
    else:  # the path bends as the robot turns
        third = max(1, len(z) // 3)
        rate = float(wrapped(numpy.angle(z[-1] - z[-third]) - numpy.angle(z[third - 1] - z[0]))) / (numpy.mean(t[-third:]) - numpy.mean(t[:third]))
    steady = abs(rate) > 1e-6
    arc = (numpy.exp(1j * rate * t) - 1) / (1j * rate) if led == STRAIGHT and steady else t if led == STRAIGHT else numpy.exp(1j * rate * t)
    (_, way), *_ = numpy.linalg.lstsq(numpy.stack([numpy.ones_like(arc), arc], 1).astype(complex), z, rcond=None)
    halves = [abs(z[half[-1]] - z[half[0]]) / (t[half[-1]] - t[half[0]]) for half in numpy.array_split(numpy.arange(len(t)), 2)]
    even = min(halves) > 0.75 * max(halves) - 0.0005
    path = way if led == STRAIGHT else 1j * rate * way
    return {"rate": rate, "speed": abs(path), "even": even or led != STRAIGHT, "seconds": t[-1] - t[0],
            "bearing": float(wrapped(told[0] - numpy.angle(path))) if told and abs(path) > LEAST_SPEED_M_S else math.nan}


def centre(values, pooled=None, angles=False):
    """(mean, standard error, s.d., count) without outliers; a spread that is small by chance leans on that of all robots. None of fewer than three."""
    values = numpy.array([value for value in values if math.isfinite(value)])
    if len(values) < 3:
        return None
    if angles:
        first = numpy.angle(numpy.exp(1j * values).mean())
        values = first + wrapped(values - first)
    middle = numpy.median(values)
    values = values[abs(values - middle) <= 4 * max(1.4826 * numpy.median(abs(values - middle)), 1e-3 * abs(middle), 1e-9)]
    n, mean, variance = len(values), values.mean(), values.var(ddof=1) if len(values) > 1 else 0.0
    if pooled is not None:
        variance = max(variance, ((n - 1) * variance + POOLED * pooled) / (n - 1 + POOLED))
    return mean, intervals.t95(n - 1) / intervals.Z95 * math.sqrt(variance / n), math.sqrt(variance), n  # so that two of them hold 95 %


def wander(tracks_parts, drifts):
    """{robot: (s.d. of the turn rate that wanders, its s.e.)} and its correlation time: an Ornstein-Uhlenbeck process on top of drift, seen with noise."""
    sums = {}
    for robot, (track, parts) in tracks_parts.items():
        found = []
        for lag in LAGS_S:
            squares = []
            for part in parts:
                t, angle = track["t"][part], track["direction"][part]
                later = numpy.searchsorted(t, t + lag - 1e-6)
                first = numpy.flatnonzero(later < len(t))
                off = wrapped(angle[later[first]] - angle[first] - drifts[robot] * (t[later[first]] - t[first]))
                squares += list((off[numpy.isfinite(off)] ** 2).clip(max=math.radians(60) ** 2))
            found.append((numpy.mean(squares), len(squares)) if len(squares) > 20 else (math.nan, 0))
        sums[robot] = numpy.array(found)
    if not sums or ((total := sum(each[:, 1] for each in sums.values())) > 0).sum() < 4:
        return {}, None
    usable = total > 0
    lags, best = numpy.array(LAGS_S)[usable], None
    pooled = sum(numpy.nan_to_num(each[usable, 0]) * each[usable, 1] for each in sums.values()) / total[usable]
    for time in TIMES_S:
        grows = 2 * time * (lags - time * (1 - numpy.exp(-lags / time)))
        weights = 1 / numpy.maximum(pooled * numpy.sqrt(lags), 1e-12)
        columns = numpy.stack([grows, numpy.full(len(lags), 2.0)], 1)
        for used in ([0, 1], [0], [1]):  # neither may be below 0
            share, *_ = numpy.linalg.lstsq(columns[:, used] * weights[:, None], pooled * weights, rcond=None)
            if (share < 0).any():
                continue
            misfit = float((((columns[:, used] @ share - pooled) * weights) ** 2).sum())
            both = numpy.zeros(2)
            both[used] = share
            if best is None or misfit < best[0] * (1 - 1e-9):
                best = misfit, time, both, grows
    _, time, (_, noise), grows = best
    out = {}
    for robot, each in sums.items():
        weights = numpy.where(each[usable, 1] > 0, grows / pooled, 0)
        if (weights > 0).sum() > 3:
            square = max(0.0, float((numpy.nan_to_num(each[usable, 0] - 2 * noise) / grows * weights**2).sum() / (weights**2).sum()))
            seconds = sum(numpy.ptp(tracks_parts[robot][0]["t"][part]) for part in tracks_parts[robot][1])
            out[robot] = math.sqrt(square), math.sqrt(square) * math.sqrt(time / max(seconds, time))
    return out, time


def apart(tracks, width_m, height_m):
    """{robot: frames in which it touches neither a robot nor, where the sides are known, a wall}."""
    frames = {}
    for robot, track in tracks.items():
        for i, t in enumerate(numpy.round(track["t"], 2)):
            frames.setdefault(t, []).append((robot, i, track["z"][i]))
    keep = {robot: numpy.ones(len(track["t"]), bool) for robot, track in tracks.items()}
    for seen in frames.values():
        z = numpy.array([each[2] for each in seen])
        near = (abs(z[:, None] - z[None, :]) < NEAR_M).sum(1) > 1
        if width_m and height_m:
            near |= (abs(z.real) > width_m / 2 - NEAR_M / 2) | (abs(z.imag) > height_m / 2 - NEAR_M / 2)
        for (robot, i, _), touches in zip(seen, near):
            keep[robot][i] = not touches
    return keep


def fit(tracks, width_m=0.0, height_m=0.0, directions="led", own_program=None):
    """{robot: {key of a robots_file: (value, standard error)}}, {robot: {key: why it is not told}}, {robot: straight stretches}, whether robots ran fit_robots.c.
    `directions`: "led", "body", or headings that assume this bearing of each LED, in degrees."""
    keep = apart(tracks, width_m, height_m)

    def all_stretches(cut):
        return {robot: [(led, part, measure(led, track, part)) for led, part in cut(track, keep[robot])] for robot, track in tracks.items()}
    cut = all_stretches(stretches)
    if own_program is None:
        rates = {led: [each["rate"] for parts in cut.values() for one, _, each in parts if one == led and each] for led in (LEFT, RIGHT, STRAIGHT)}
        middle = {led: numpy.median(each) if len(each) >= len(tracks) else math.nan for led, each in rates.items()}
        own_program = bool(middle[LEFT] > LEAST_TURN and middle[RIGHT] < -LEAST_TURN and abs(middle[STRAIGHT]) < min(middle[LEFT], -middle[RIGHT]) / 2)
    if not own_program:
        cut = all_stretches(free_stretches)

    def of(robot, led, key):
        return [each[key] for one, _, each in cut[robot] if one == led and each and each["even"]]

    def all_of(led, key, angles=False):
        found = {robot: centre(of(robot, led, key), angles=angles) for robot in tracks}
        spread = [each[2] ** 2 for each in found.values() if each]
        pooled = float(numpy.median(spread)) if spread else None
        return {robot: centre(of(robot, led, key), pooled, angles) for robot in tracks}
    speeds, drifts, lefts, rights = all_of(STRAIGHT, "speed"), all_of(STRAIGHT, "rate"), all_of(LEFT, "rate"), all_of(RIGHT, "rate")
    bearings = {led: all_of(led, "bearing", True) for led in (STRAIGHT, LEFT, RIGHT)}
    moves = {robot for robot, speed in speeds.items() if speed and speed[0] > LEAST_SPEED_M_S}
    straights = {robot: [part for led, part, each in cut[robot] if led == STRAIGHT and each and each["even"]] for robot in tracks}
    noises, time = wander({robot: (tracks[robot], straights[robot]) for robot in sorted(moves) if drifts[robot]}, {robot: drifts[robot][0] for robot in moves if drifts[robot]})

    told, missing = {}, {}
    for robot in sorted(tracks):
        mine, why = told.setdefault(robot, {}), missing.setdefault(robot, {})
        few = "hardly moves" if speeds[robot] and robot not in moves else "too few stretches" if own_program else "too few straight stretches"
        degrees = {"drift_deg_per_s": drifts[robot] if robot in moves else None, "turn_left_deg_per_s": lefts[robot] if own_program else None,
                   "turn_right_deg_per_s": rights[robot] if own_program else None, "turn_noise_deg_per_s": noises.get(robot)}
        straight, left, right = (bearings[led][robot] for led in (STRAIGHT, LEFT, RIGHT))
        if directions != "body" and own_program and straight and robot in moves:
            degrees["led_bearing_deg"] = straight[:2]
        elif directions != "body" and own_program and left and right:  # path and heading differ by PIVOT, to either side
            turn = float(wrapped(right[0] - PIVOT - (left[0] + PIVOT)))
            degrees["led_bearing_deg"] = float(wrapped(left[0] + PIVOT + turn / 2)), math.hypot(left[1], right[1]) / 2
        if "led_bearing_deg" in degrees and directions != "led":  # the tracker follows LEDs more than paths
            off, error = degrees["led_bearing_deg"]
            degrees["led_bearing_deg"] = math.radians(directions) + off / FOLLOWS, math.hypot(error, 0.06 * off) / FOLLOWS
        if speeds[robot]:
            mine["speed_m_per_s"] = speeds[robot][0], math.hypot(speeds[robot][1], SCALE * speeds[robot][0])
        for key, found in degrees.items():
            if found:
                found = found[0], math.hypot(found[1], TILT if key == "led_bearing_deg" else SLANT)
                sign = -1 if key == "turn_right_deg_per_s" else 1
                mine[key] = max(0.0, sign * math.degrees(found[0])) if key.startswith("turn") else math.degrees(found[0]), math.degrees(found[1])
        if time is not None and robot in noises:
            mine["turn_noise_s"] = float(time), 0.0
        why.update({key: "LED not seen in a recording" if key == "led_bearing_deg" and directions == "body" else
                    "walked freely" if not own_program and key in ("turn_left_deg_per_s", "turn_right_deg_per_s", "led_bearing_deg") else few for key in KEYS if key not in mine})
    return told, missing, straights, own_program
