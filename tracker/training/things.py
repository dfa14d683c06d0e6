"""What lies about in pictures of rooms and is no robot; and what draws it.

Drawn on pictures of floats, blue first, 0..255 and above; lengths are in pixels, `r` is a robot's radius.
"""
import cv2
import numpy as np

TAU = 2 * np.pi


def noise(rng, shape, cell):
    """Smooth noise of about -1..1 whose patches have `cell` pixels."""
    small = rng.normal(0, 1, (max(2, int(shape[0] / cell) + 2), max(2, int(shape[1] / cell) + 2))).astype(np.float32)
    return cv2.resize(small, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)


def tinted(rng, grey, spread):
    return np.clip(grey * (1 + rng.normal(0, spread, 3)), 0, 255)


def point(centre, angle, far):
    return centre[0] + far * np.cos(angle), centre[1] + far * np.sin(angle)


def fixed(*values):
    """OpenCV's coordinates with four bits behind the point."""
    return tuple(int(round(v * 16)) for v in values)


def disc(canvas, centre, radius, colour, thick=-1):
    cv2.circle(canvas, fixed(*centre), max(1, int(radius * 16)), tuple(map(float, np.ravel(colour))), thick,
               cv2.LINE_8, 4)


def box(canvas, centre, angle, length, width, colour):
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    corners = [np.array(centre) + a * along * length + b * across * width for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    cv2.fillPoly(canvas, [np.round(np.array(corners) * 16).astype(np.int32)], tuple(map(float, np.ravel(colour))),
                 cv2.LINE_8, 4)


def corners(at, angles, far):
    """Of a polygon, as OpenCV wants them: with four bits behind the point."""
    return [np.round(np.stack([at[0] + far * np.cos(angles), at[1] + far * np.sin(angles)], 1) * 16).astype(np.int32)]


def add_spot(canvas, at, sigma, colour):
    h, w = canvas.shape[:2]
    reach = int(4 * sigma) + 2
    x0, y0 = max(0, int(at[0]) - reach), max(0, int(at[1]) - reach)
    x1, y1 = min(w, int(at[0]) + reach), min(h, int(at[1]) + reach)
    if x1 <= x0 or y1 <= y0:
        return
    y, x = np.mgrid[y0:y1, x0:x1].astype(np.float32)
    d = ((x - at[0]) ** 2 + (y - at[1]) ** 2) / sigma ** 2
    canvas[y0:y1, x0:x1] += np.exp(-d / 2)[..., None] * np.asarray(colour, np.float32)


def write(rng, canvas, r, count):
    ink, h, w = tinted(rng, rng.uniform(0, 120), 0.2), *canvas.shape[:2]
    for _ in range(count):
        words = "".join(rng.choice(list("abcdeghopqO0689BRDQ@%&#mnstKLX .")) for _ in range(rng.integers(1, 12)))
        cv2.putText(canvas, words, (int(rng.uniform(-20, w)), int(rng.uniform(0, h))), int(rng.integers(0, 8)),
                    r * rng.uniform(0.02, 0.14), ink.tolist(), int(max(1, r * rng.uniform(0.05, 0.4))), cv2.LINE_AA)


def letters(rng, canvas, at, high, count, ink, thick):
    """A word, about its middle, in letters so many pixels high; `thick`: their lines in parts of that."""
    word, font = "".join(rng.choice(list("OOQC0689eaoc@GDbdpqgS%&")) for _ in range(count)), int(rng.integers(0, 8))
    size, line = high / 21, max(1, int(thick * high))
    wide = cv2.getTextSize(word, font, size, line)[0][0]
    cv2.putText(canvas, word, (int(at[0] - wide / 2), int(at[1] + high / 2)), font, size, ink.tolist(), line, cv2.LINE_AA)


def cap(rng, canvas, at, r):
    """A bottle cap of any colour: teeth, a shaded edge, light from one side, perhaps a word."""
    hue = np.clip(rng.normal(0.5, 0.5, 3), 0.03, 1) if rng.random() < 0.7 else np.full(3, rng.uniform(0.1, 1))
    colour, light = 255 * hue / hue.max() * rng.uniform(0.25, 1), rng.uniform(0, TAU)
    angles = np.linspace(0, TAU, int(rng.choice([21, rng.integers(14, 60)])) * 4, endpoint=False)
    far = r * (1 - rng.uniform(0.02, 0.1) * (1 + np.cos(angles * len(angles) / 4)) / 2)
    turn = rng.uniform(0, TAU)
    cv2.fillPoly(canvas, corners(at, angles + turn, far), (colour * rng.uniform(0.35, 1)).tolist(), cv2.LINE_8, 4)
    disc(canvas, at, rng.uniform(0.7, 0.95) * r, colour)
    if rng.random() < 0.3:
        disc(canvas, at, rng.uniform(0.5, 0.75) * r, colour * rng.uniform(0.7, 1.3))
    if rng.random() < 0.7:
        add_spot(canvas, point(at, light, rng.uniform(0.1, 0.6) * r), r * rng.uniform(0.1, 0.6), np.full(3, rng.uniform(20, 250)))
    ink = tinted(rng, rng.choice([rng.uniform(0, 60), rng.uniform(180, 255)]), 0.1)
    if rng.random() < 0.75:
        letters(rng, canvas, at, r * rng.uniform(0.15, 0.8), rng.integers(1, 8), ink, rng.uniform(0.05, 0.2))


def round_thing(rng, canvas, at, r, look):
    """Lids, caps, coins, pads, capacitors: a disc with a rim, perhaps toothed, and something on it. `look` seeds what
    is alike in all of a kind."""
    alike = np.random.default_rng(look)
    colour, other, dark = (tinted(alike, alike.uniform(5, 250), 0.25) for _ in range(3))
    r = r * alike.choice([1, rng.uniform(0.9, 1.1)])
    if alike.random() < 0.3:
        disc(canvas, point(at, alike.uniform(0, TAU), 0.2 * r), 1.05 * r, canvas.mean((0, 1)) * 0.6)
    teeth = int(alike.integers(12, 45)) if alike.random() < 0.4 else 0
    if teeth:
        angles = np.arange(2 * teeth) * np.pi / teeth + rng.uniform(0, 1)
        far = r * np.where(np.arange(2 * teeth) % 2, alike.uniform(0.8, 0.95), 1)
        cv2.fillPoly(canvas, corners(at, angles, far), colour.tolist(), cv2.LINE_8, 4)
    else:
        disc(canvas, at, r, colour)
    inner = alike.uniform(0.4, 0.92)
    if alike.random() < 0.8:
        disc(canvas, at, inner * r, colour * alike.uniform(0.6, 1.5) if alike.random() < 0.5 else other)
    turn = rng.uniform(0, TAU)
    for _ in range(alike.integers(0, 4)):  # scratches, letters, slots, marks
        box(canvas, point(at, rng.uniform(0, TAU), r * rng.uniform(0, 0.5)), turn + alike.integers(0, 2) * np.pi / 2, r * alike.uniform(0.1, 0.6),
            r * alike.uniform(0.03, 0.12), dark)
    if alike.random() < 0.3:  # half of it, as on capacitors
        cv2.ellipse(canvas, (int(at[0]), int(at[1])), (int(0.9 * r) + 1, int(0.9 * r) + 1), np.degrees(turn), -40, 40, dark.tolist(), -1, cv2.LINE_AA)
    if alike.random() < 0.4:
        for _ in range(alike.integers(1, 14)):
            disc(canvas, point(at, rng.uniform(0, TAU), r * rng.uniform(0, inner)), r * alike.uniform(0.04, 0.15), tinted(rng, rng.uniform(20, 230), 0.1))
    if alike.random() < 0.4:
        add_spot(canvas, point(at, alike.uniform(0, TAU), 0.4 * r), r * alike.uniform(0.1, 0.4), np.full(3, alike.uniform(30, 200)))


def electronics(rng, canvas, at, r, turn, large):
    """A board with rows of pins, holes, chips, wires, and round parts."""
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    wide = large * rng.uniform(0.4, 1)
    box(canvas, at, turn, large, wide, rng.choice([[40, 90, 40], [110, 60, 20], [35, 35, 35], [40, 40, 130], [200, 200, 200]]) * rng.uniform(0.4, 1.4))
    anywhere = lambda: at + along * rng.uniform(-large, large) + across * rng.uniform(-wide, wide)
    for _ in range(rng.integers(0, 12)):  # wires
        start = anywhere()
        for way in rng.permutation([along, across]):
            end = start + way * rng.normal(0, large / 2)
            cv2.line(canvas, fixed(*start), fixed(*end), tinted(rng, rng.uniform(30, 220), 0.2).tolist(), max(1, int(r * rng.uniform(0.03, 0.2))), cv2.LINE_AA, 4)
            start = end
    for _ in range(rng.integers(0, 12)):  # chips
        box(canvas, anywhere(), turn, r * 10 ** rng.uniform(-0.9, 0.5), r * 10 ** rng.uniform(-0.9, 0.3), tinted(rng, rng.choice([25, rng.uniform(0, 240)]), 0.1))
    for _ in range(rng.integers(1, 5)):  # rows and grids of holes and pins
        start, look, size = anywhere(), int(rng.integers(1 << 30)), r * 10 ** rng.uniform(-0.8, 0.1)
        step = size * rng.uniform(2.1, 3.5)
        for i in range(rng.integers(2, 12)):
            for k in range(rng.choice([1, 2, 5])):
                round_thing(rng, canvas, tuple(start + step * (i * along + k * across)), size, look)
    for _ in range(rng.integers(0, 6)):
        round_thing(rng, canvas, tuple(anywhere()), r * 10 ** rng.uniform(-0.5, 0.3), int(rng.integers(1 << 30)))


def oval(canvas, at, turn, length, squeeze, colour, thick=-1, arc=(0, 360)):
    cv2.ellipse(canvas, fixed(*at), fixed(length, length * squeeze), float(np.degrees(turn)), *map(float, arc), tuple(map(float, np.ravel(colour))), thick,
                cv2.LINE_AA, 4)


def metal(rng):
    return np.array([rng.uniform(70, 130), 170, 210]) * rng.uniform(0.4, 1.2) if rng.random() < 0.4 else tinted(rng, rng.uniform(60, 260), 0.04)


def plated_hole(rng, canvas, at, r, look):
    """A hole or pad with a metal ring, as boards have: one looks through it, or sees its wall, a pin, solder, a screw.
    `look` seeds what is alike in all of a row."""
    alike = np.random.default_rng(look)
    squeeze, turn = alike.choice([1, alike.uniform(0.65, 1)], p=[0.7, 0.3]), alike.uniform(0, TAU)
    ring, wall = metal(alike), metal(alike) * alike.uniform(0.2, 1)
    through = tinted(alike, alike.choice([alike.uniform(0, 40), alike.uniform(200, 300), alike.uniform(40, 200)]), 0.06)
    inner, light = alike.uniform(0.5, 0.95), alike.uniform(0, TAU)
    line = lambda part: max(1, int(part * r))
    around = lambda part, colour, thick=-1, arc=(0, 360): oval(canvas, at, turn, part * r, squeeze, colour, thick, arc)
    if alike.random() < 0.5:  # a line printed about it: a circle, or straight lines
        ink, far, angles = np.full(3, alike.uniform(150, 270)), alike.uniform(1.15, 1.6) * r, np.arange(8) * TAU / 8 + alike.choice([0, TAU / 16])
        if alike.random() < 0.5:
            around(far / r, ink, line(alike.uniform(0.04, 0.15)))
        else:
            cv2.polylines(canvas, corners(at, angles, far), True, ink.tolist(), line(alike.uniform(0.04, 0.15)), cv2.LINE_AA, 4)
    if alike.random() < 0.4:
        beside = canvas[int(np.clip(at[1] + 1.3 * r, 0, canvas.shape[0] - 1)), int(np.clip(at[0], 0, canvas.shape[1] - 1))]
        around(alike.uniform(1.04, 1.2), beside * alike.uniform(0.3, 0.8))
    around(1, ring if alike.random() < 0.8 else through)
    filling = alike.random()
    if filling < 0.55:  # one looks through, and at its wall on one side
        around(inner, wall)
        off = alike.uniform(0, 0.15) * inner * r
        oval(canvas, point(at, light, off), turn, inner * r - off, squeeze, through)
    else:
        around(inner, wall if filling < 0.7 else ring * alike.uniform(0.4, 1.2))
        for _ in range(alike.integers(0, 5)):  # solder shines, here and there
            add_spot(canvas, point(at, rng.uniform(0, TAU), rng.uniform(0, 0.6) * r), r * rng.uniform(0.06, 0.3),
                     np.full(3, rng.choice([rng.uniform(40, 300), rng.uniform(-150, -30)])))
        for slot in range(alike.choice([0, 1, 2])):  # a screw's slots
            box(canvas, at, light + slot * np.pi / 2, inner * r * alike.uniform(0.5, 0.95), r * alike.uniform(0.05, 0.2), through)
        if alike.random() < 0.4:
            box(canvas, point(at, light, rng.uniform(0, 0.2) * r), turn, r * alike.uniform(0.1, 0.35), r * alike.uniform(0.1, 0.35), metal(alike))
    if alike.random() < 0.6:  # edges that face the light, and others
        for part in (1, inner):
            start = np.degrees(light - turn) + rng.uniform(-30, 30)
            around(part * 0.97, ring * alike.uniform(1.1, 1.8), line(0.08), (start - 60, start + 60))
            around(part * 0.97, ring * alike.uniform(0.1, 0.6), line(0.08), (start + 120, start + 240))


def holed_board(rng, canvas, at, r, turn):
    """A board with rows of plated holes, about as large as robots, and words."""
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    colour = np.array(rng.choice([[40, 110, 40], [130, 70, 20], [35, 35, 35], [40, 40, 190], [110, 40, 90], [210, 205, 200]])) * rng.uniform(0.4, 1.3)
    columns, rows, step = rng.integers(1, 9), rng.choice([1, 1, 2, 3]), r * rng.uniform(2.6, 4)
    box(canvas, at, turn, step * (0.5 * columns + rng.uniform(0, 1)), step * (0.5 * rows + rng.uniform(0, 2)), colour)
    start, size, look = at - step * ((columns - 1) / 2 * along + (rows - 1) / 2 * across), r * rng.uniform(0.75, 1.15), int(rng.integers(1 << 30))
    for i in range(columns):
        for k in range(rows):
            hole = start + step * (i * along + k * across)
            plated_hole(rng, canvas, tuple(hole), size, look)
            if rng.random() < 0.2:
                letters(rng, canvas, hole + rng.choice([-1, 1]) * 1.6 * r * across, r * rng.uniform(0.4, 1), rng.integers(1, 4), np.full(3, rng.uniform(150, 260)), 0.1)


def icon(rng, canvas, at, r):
    """A sign such as pages and devices bear, mostly round: wheels, suns, dots in a circle, a letter within."""
    ground, ink = (tinted(rng, grey, rng.choice([0.02, 0.5])) for grey in rng.permutation([rng.uniform(0, 120), rng.uniform(150, 270)]))
    if rng.random() < 0.7:
        box(canvas, at, 0, r * rng.uniform(1.3, 4), r * rng.uniform(1.3, 4), ground)
    kind, turn, count, part = rng.integers(0, 5), rng.uniform(0, TAU), int(rng.integers(6, 20)), rng.uniform(0.5, 0.9)
    thick = max(1, int(r * rng.uniform(0.05, 0.25)))
    if kind == 0:  # a toothed wheel or star
        angles = np.arange(4 * count) * TAU / (4 * count) + turn
        far = r * np.where(np.arange(4 * count) // 2 % 2, part, 1)
        cv2.fillPoly(canvas, corners(at, angles, far), ink.tolist(), cv2.LINE_AA, 4)
    elif kind == 1:  # dots or rays
        size = rng.uniform(0.05, 0.2) * r
        for i in range(count):
            angle = turn + TAU * i / count
            if part < 0.7:
                box(canvas, point(at, angle, r), angle, size * rng.uniform(1, 1.2), size, ink)
            else:
                disc(canvas, point(at, angle, r), size * (1 + i / count), ink)
    elif kind == 2:  # parts of a ring
        for i in range(count // 3):
            start = 360 * i / (count // 3)
            oval(canvas, at, turn, 0.85 * r, 1, ink, thick, (start, start + rng.uniform(40, 110)))
    else:
        oval(canvas, at, 0, r, 1, ink, thick if kind == 3 else -1)
    what = rng.random()
    if what < 0.3:
        oval(canvas, at, turn, r * rng.uniform(0.3, 0.75), 1, rng.choice([ground, ink]), -1, rng.choice([(0, 360), (0, 180)]))
    elif what < 0.7:
        letters(rng, canvas, at, r * rng.uniform(0.6, 1.3), rng.integers(1, 3), ground if kind in (0, 4) else ink, rng.uniform(0.08, 0.25))


def knob(rng, canvas, at, r):
    """Knobs, capacitors and buttons seen from aside: discs that move to one side and shine."""
    colour, way = tinted(rng, rng.choice([rng.uniform(10, 60), rng.uniform(60, 250)]), rng.choice([0.05, 0.5])), rng.uniform(0, TAU)
    size, off = r, rng.uniform(0, 0.35) * r
    for _ in range(rng.integers(2, 5)):
        disc(canvas, at, size, colour * rng.uniform(0.4, 1.5))
        if rng.random() < 0.4:
            oval(canvas, at, way, 0.95 * size, 1, colour * rng.uniform(1.2, 3), max(1, int(0.08 * r)), (-70, 70))
        at, size = point(at, way, off), size * rng.uniform(0.55, 0.95)
        off = min(off, 0.3 * size)
    if rng.random() < 0.5:
        add_spot(canvas, point(at, rng.uniform(0, TAU), 0.3 * r), r * rng.uniform(0.05, 0.3), np.full(3, rng.uniform(30, 250)))


def things(rng, canvas, r, count, near=False):
    """What lies about and is no robot; if `near`, about half of it is easily taken for one."""
    of_one_kind = int(rng.integers(1 << 30))
    h, w = canvas.shape[:2]
    for _ in range(count):
        at = rng.uniform(-10, w + 10), rng.uniform(-10, h + 10)
        colour = tinted(rng, rng.choice([rng.uniform(0, 60), rng.uniform(40, 255)]), rng.choice([0.03, 0.4]))
        other = tinted(rng, rng.uniform(0, 255), 0.2)
        turn, kind, large = rng.uniform(0, TAU), rng.integers(0, 21), r * 10 ** rng.uniform(-0.7, 0.7)
        if near and rng.random() < 0.5:
            kind = rng.choice([21, 21, 22, 23, 24, 25, 26, 27, 28])
        if kind == 0:  # bars, walls, clamps, rails
            box(canvas, at, turn, r * rng.uniform(2, 40), r * rng.uniform(0.1, 2), colour)
        elif kind == 1:  # boxes, paper, electronics
            box(canvas, at, turn, large * 1.5, large * rng.uniform(0.5, 1.5), colour)
            for _ in range(rng.integers(0, 25)):
                box(canvas, (at[0] + rng.normal(0, large * 0.6), at[1] + rng.normal(0, large * 0.6)),
                    turn + rng.integers(0, 2) * np.pi / 2, large * rng.uniform(0.02, 0.4), large * rng.uniform(0.02, 0.3),
                    tinted(rng, rng.uniform(0, 255), 0.2))
        elif kind == 2:  # cables
            steps = np.cumsum(rng.normal(0, 0.25, 40)) + turn
            line = np.cumsum(np.stack([np.cos(steps), np.sin(steps)], 1) * r * 0.7, 0) + at
            cv2.polylines(canvas, [np.round(line * 16).astype(np.int32)], False, colour.tolist(),
                          max(1, int(r * rng.uniform(0.1, 0.6))), cv2.LINE_AA, 4)
        elif kind == 3:  # plain discs: caps, coins, holes
            disc(canvas, at, large, colour)
        elif kind == 4:  # rings
            disc(canvas, at, large, colour)
            disc(canvas, at, large * rng.uniform(0.5, 0.95), canvas[int(np.clip(at[1] + 1.5 * large, 0, h - 1)),
                                                                     int(np.clip(at[0], 0, w - 1))])
        elif kind == 5:  # knobs and lids: a rim of little contrast
            disc(canvas, at, large, colour)
            disc(canvas, (at[0] + 0.1 * large, at[1]), large * rng.uniform(0.2, 0.9), colour * rng.uniform(0.8, 1.2))
        elif kind == 6:  # hands
            skin = np.array([110, 140, 195.0]) * rng.uniform(0.5, 1.25)
            for finger in range(5):
                end = point(at, turn + 0.3 * finger, r * rng.uniform(3, 7))
                cv2.line(canvas, fixed(*at), fixed(*end), skin.tolist(), max(1, int(r * 1.2)), cv2.LINE_AA, 4)
            disc(canvas, at, 2.5 * r, skin)
        elif kind == 7:  # frame corners
            box(canvas, at, turn, large, 0.2 * r, colour)
            box(canvas, point(at, turn, large), turn + np.pi / 2, large, 0.2 * r, colour)
        elif kind == 8:  # spots of light
            y, x = np.mgrid[0:h, 0:w].astype(np.float32)
            d = ((x - at[0]) ** 2 + (y - at[1]) ** 2) / large ** 2
            canvas += (rng.uniform(20, 250) * np.exp(-d ** rng.choice([1, 3]) / 2))[..., None].astype(np.float32)
        elif kind == 9:  # shadows of something
            box(canvas, at, turn, large, large * rng.uniform(0.2, 1), canvas.mean((0, 1)) * rng.uniform(0.3, 0.8))
        elif kind == 10:  # screws, specks
            for _ in range(rng.integers(3, 30)):
                disc(canvas, (at[0] + rng.normal(0, 3 * r), at[1] + rng.normal(0, 3 * r)), r * rng.uniform(0.05, 0.5), colour)
        elif kind == 11:  # round boards without a cell, with parts
            disc(canvas, at, large, colour * 0.5)
            for _ in range(rng.integers(3, 25)):
                box(canvas, point(at, rng.uniform(0, TAU), large * rng.uniform(0, 0.85)), rng.uniform(0, 3),
                    large * rng.uniform(0.03, 0.4), large * rng.uniform(0.03, 0.2), tinted(rng, rng.uniform(0, 255), 0.2))
        elif kind == 12:  # a toppled robot
            box(canvas, at, turn, r, 0.45 * r, tinted(rng, rng.uniform(10, 60), 0.1))
            box(canvas, point(at, turn + 1.57, 0.25 * r), turn, 0.65 * r, 0.2 * r, other)
        elif kind in (13, 14):  # round things, each of its own
            round_thing(rng, canvas, at, large, int(rng.integers(1 << 30)))
        elif kind in (15, 16):  # as large as robots, and alike
            round_thing(rng, canvas, at, r * rng.uniform(0.7, 1.2), of_one_kind)
        elif kind == 17:  # circuit boards, words
            if rng.random() < 0.5:
                electronics(rng, canvas, np.array(at), r, turn, r * 10 ** rng.uniform(0.5, 1.5))
            else:
                write(rng, canvas, r, rng.integers(1, 6))
        elif kind == 18:  # stains
            y, x = np.mgrid[0:h, 0:w].astype(np.float32)
            x, y = (x - at[0]) * np.cos(turn) + (y - at[1]) * np.sin(turn), (y - at[1]) * np.cos(turn) - (x - at[0]) * np.sin(turn)
            canvas *= 1 - rng.uniform(0.1, 0.9) * np.exp(-(x**2 + rng.uniform(1, 6) * y**2) / (2 * (0.6 * r)**2))[..., None]
        elif kind == 19:  # loops
            cv2.ellipse(canvas, (int(at[0]), int(at[1])), (int(large) + 1, int(large * rng.uniform(0.4, 1)) + 1), np.degrees(turn), 0,
                        rng.uniform(180, 360), colour.tolist(), max(1, int(r * rng.uniform(0.1, 0.4))), cv2.LINE_AA)
        elif kind == 20:  # half a disc
            cv2.ellipse(canvas, (int(at[0]), int(at[1])), (int(large) + 1, int(large) + 1), np.degrees(turn), 0, 180,
                        colour.tolist(), -1, cv2.LINE_AA)
        elif kind == 21:  # caps with a word on them
            cap(rng, canvas, at, rng.choice([large, r * rng.uniform(0.8, 1.2)]))
        elif kind == 22:  # a wire in a loop, and where it comes from
            angles = np.linspace(0, rng.uniform(4, 8), 40)
            far = large * (1 + rng.uniform(-0.3, 0.3) * np.sin(angles + turn)) * (1 + np.maximum(0, angles - 5.5) * rng.uniform(0, 1))
            line = np.stack([at[0] + far * np.cos(angles + turn), at[1] + far * np.sin(angles + turn)], 1)
            line = np.concatenate([line[:1] + rng.normal(0, 2 * large, 2), line])
            cv2.polylines(canvas, [np.round(line * 16).astype(np.int32)], False, colour.tolist(), max(1, int(large * rng.uniform(0.05, 0.25))), cv2.LINE_AA, 4)
        elif kind == 23:  # large letters, most of them round
            letters(rng, canvas, at, r * rng.uniform(0.8, 2.4), rng.integers(1, 5), colour, rng.uniform(0.05, 0.3))
        elif kind == 24:  # screws
            disc(canvas, at, large, colour)
            for slot in range(rng.integers(1, 3)):
                box(canvas, at, turn + slot * np.pi / 2, large * rng.uniform(0.4, 0.9), large * rng.uniform(0.05, 0.2), other)
        elif kind == 25:  # as large as robots, and one like the other
            round_thing(rng, canvas, at, r, of_one_kind)
        elif kind == 27:  # boards with rows of holes
            holed_board(rng, canvas, np.array(at), r, turn)
        elif kind == 28:  # signs, knobs
            (icon if rng.random() < 0.6 else knob)(rng, canvas, at, rng.choice([large, r * rng.uniform(0.8, 1.2)]))
        else:  # plain discs as large as robots, mostly bright: paper, lids, holes; in a soft shade
            grey = rng.choice([rng.uniform(150, 300), rng.uniform(60, 200), rng.uniform(0, 60)], p=[0.6, 0.25, 0.15])
            size, shade = r * rng.uniform(0.85, 1.15), rng.uniform(0, 0.5) * rng.choice([0, 1])
            add_spot(canvas, point(at, turn, 0.1 * r), size, -shade * canvas.mean((0, 1)))
            disc(canvas, at, size, tinted(rng, grey, rng.choice([0.02, 0.3])))
            if rng.random() < 0.3:
                disc(canvas, at, size, tinted(rng, grey * rng.uniform(0.7, 1.1), 0.02), max(1, int(0.08 * r)))
