"""Pictures of rooms that never were, with their truth: what the search net is trained on.

Painted on purpose by other code than the emulator's, whose rooms test the net. A picture is as large as the net sees
it: its robots have a radius of some 5 pixels, or, a third of them, another one, so that they are to be left alone.
"""
import cv2
import numpy as np

TAU = 2 * np.pi
SIZE = 160  # of a picture's sides
LEDS = np.array([[(i >> 2) & 1, (i >> 1) & 1, i & 1] for i in range(1, 8)], float)  # blue, green, red


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


def floor_of(rng, h, w, r):
    grey = rng.choice([rng.uniform(120, 240), rng.uniform(120, 240), rng.uniform(60, 140), rng.uniform(15, 70)])
    out = np.ones((h, w, 3), np.float32) * tinted(rng, grey, rng.choice([0.02, 0.05, 0.25], p=[0.5, 0.35, 0.15])).astype(np.float32)
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    for _ in range(rng.integers(0, 4)):
        out *= 1 + rng.uniform(0, 0.1) * rng.random() * noise(rng, (h, w), r * 10 ** rng.uniform(-0.7, 1))[..., None]
    kind = rng.random()
    turn = rng.uniform(0, TAU)
    along = x * np.cos(turn) + y * np.sin(turn)
    across = y * np.cos(turn) - x * np.sin(turn)
    period = r * 10 ** rng.uniform(-0.3, 0.9)
    dark = rng.uniform(0.3, 1.3)
    if kind < 0.08:  # ruled
        out[np.mod(along, period) < rng.uniform(0.05, 0.25) * period] *= dark
        if rng.random() < 0.5:
            out[np.mod(across, period) < 0.15 * period] *= dark
    elif kind < 0.13:  # checks
        out[(np.floor(along / period) + np.floor(across / period)) % 2 > 0] *= dark
    elif kind < 0.2:  # wood, cloth
        out *= 1 + rng.uniform(0.03, 0.2) * np.sin(across / period * 3 + 2 * noise(rng, (h, w), 4 * r))[..., None]
    elif kind < 0.32:  # print and handwriting
        ink = tinted(rng, rng.uniform(0, 120), 0.2)
        for _ in range(rng.integers(3, 40)):
            words = "".join(rng.choice(list("abcdeghopqO0689BRDQ@%&#mnst ")) for _ in range(rng.integers(1, 9)))
            cv2.putText(out, words, (int(rng.uniform(-20, w)), int(rng.uniform(0, h))), int(rng.integers(0, 8)),
                        r * rng.uniform(0.02, 0.14), ink.tolist(), int(max(1, r * rng.uniform(0.05, 0.4))), cv2.LINE_AA)
    elif kind < 0.36:  # projected or painted areas
        for _ in range(rng.integers(1, 6)):
            disc(out, (rng.uniform(0, w), rng.uniform(0, h)), r * rng.uniform(1.5, 12), tinted(rng, rng.uniform(30, 255), 0.5))
    return out


def things(rng, canvas, r, count):
    """What lies about and is no robot."""
    h, w = canvas.shape[:2]
    for _ in range(count):
        at = rng.uniform(-10, w + 10), rng.uniform(-10, h + 10)
        colour = tinted(rng, rng.choice([rng.uniform(0, 60), rng.uniform(40, 255)]), rng.choice([0.03, 0.4]))
        other = tinted(rng, rng.uniform(0, 255), 0.2)
        turn, kind, large = rng.uniform(0, TAU), rng.integers(0, 14), r * 10 ** rng.uniform(-0.7, 0.7)
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
        else:  # half a disc
            cv2.ellipse(canvas, (int(at[0]), int(at[1])), (int(large) + 1, int(large) + 1), np.degrees(turn), 0, 180,
                        colour.tolist(), -1, cv2.LINE_AA)


class Look:
    """What the robots of one picture have in common."""

    def __init__(self, rng):
        grey = rng.choice([rng.uniform(8, 40), rng.uniform(15, 75)])
        self.board = tinted(rng, grey, 0.12)
        if rng.random() < 0.08:
            self.board = np.array([40, 90, 40]) * rng.uniform(0.4, 1.4)
        self.rim = self.board * rng.choice([1, rng.uniform(0.3, 1.6)])
        self.parts = [(rng.uniform(0, TAU), rng.uniform(0.72, 0.97), rng.uniform(0.02, 0.14), rng.uniform(0.02, 0.1),
                       tinted(rng, rng.uniform(10, 230), 0.15)) for _ in range(rng.integers(4, 22))]
        self.jumper = np.array([50, 45, 150]) * rng.uniform(0.4, 1.4)
        self.cell_grey = rng.choice([rng.uniform(20, 90), rng.uniform(70, 200), rng.uniform(70, 200), rng.uniform(180, 600)])
        self.cell_spread = rng.choice([0.05, 0.5])
        self.cell_radius = rng.uniform(0.58, 0.77)
        self.cell_off = rng.uniform(0, 0.16) * rng.random() ** 2
        self.holder = rng.random() < 0.4
        self.clip = rng.choice([0, rng.uniform(0.06, 0.2)]), rng.uniform(20, 255)
        self.lean = rng.uniform(0, 0.22) * rng.random()
        self.glare = rng.random() < 0.45, rng.uniform(0, TAU), rng.uniform(0.5, 0.9), rng.uniform(100, 500)
        self.domes = rng.choice([0, rng.uniform(80, 400)])
        self.motors = rng.choice([0, rng.uniform(80, 500)], p=[0.7, 0.3])
        self.legs = rng.choice([0, 0, 0.12])
        self.tab = rng.random() < 0.5
        self.halo = rng.uniform(0.15, 0.9), rng.uniform(20, 260), rng.uniform(0.06, 0.17), rng.uniform(200, 900)
        self.core = rng.random((3, 3)) * rng.choice([0, 0.6], p=[0.7, 0.3]) + np.eye(3)
        rng.integers(1 << 30)  # what once was drawn here keeps the rooms the same


def paint_robot(rng, canvas, x, y, r, turn, look, middle):
    fine = 4 if r < 9 else 2
    half = int(1.35 * r) + 2
    left, top = int(round(x)) - half, int(round(y)) - half
    size = 2 * half * fine
    c = ((x - left + 0.5) * fine - 0.5, (y - top + 0.5) * fine - 0.5)
    R = r * fine
    layer, cover = np.zeros((size, size, 3), np.float32), np.zeros((size, size), np.float32)

    def both(draw, *words):
        draw(layer, *words)
        draw(cover, *words[:-1], 1.0)

    shade = rng.uniform(0.85, 1.15)
    if look.legs:
        for at in (0, 2.3, -2.3):
            both(disc, point(c, turn + at, R), look.legs * R, look.rim)
    if look.tab:
        both(box, point(c, turn + 1.25, R), turn + 1.25, 0.12 * R, 0.16 * R, np.full(3, 105.0))
    both(disc, c, R, look.rim * shade)
    disc(layer, c, 0.95 * R, look.board * shade)
    layer += cover[..., None] * look.board.mean() * 0.15 * noise(rng, (size, size), 0.15 * R)[..., None]
    for angle, far, length, width, colour in look.parts:
        box(layer, point(c, turn + angle, far * R), turn + angle + np.pi / 2, length * R, width * R, colour)
    box(layer, point(c, turn, 0.88 * R), turn + np.pi / 2, 0.12 * R, 0.07 * R, look.jumper)
    out = np.array([x - middle[0], y - middle[1]]) / max(1.0, np.hypot(*middle))
    cell = (c[0] + R * (look.cell_off * np.cos(turn + 1) + look.lean * out[0]),
            c[1] + R * (look.cell_off * np.sin(turn + 1) + look.lean * out[1]))
    if look.holder:
        disc(layer, cell, (look.cell_radius + 0.07) * R, look.board * 0.6)
    grey = look.cell_grey * (1 + look.cell_spread * rng.uniform(-1, 1))
    metal = tinted(rng, 100, 0.04) / 100 * grey
    radius = look.cell_radius * R * rng.uniform(0.97, 1.03)
    mask = np.zeros((size, size), np.float32)
    disc(mask, cell, radius, 1.0)
    gy, gx = np.mgrid[0:size, 0:size].astype(np.float32)
    slope = ((gx - cell[0]) * np.cos(look.glare[1]) + (gy - cell[1]) * np.sin(look.glare[1])) / R
    sheen = 1 + rng.uniform(0, 0.8) * slope + rng.uniform(0, 0.3) * noise(rng, (size, size), R * rng.uniform(0.2, 1))
    layer[mask > 0] = (metal * np.maximum(sheen, 0.1)[..., None])[mask > 0]
    disc(layer, cell, radius, metal * rng.uniform(0.5, 1.5), max(1, int(0.06 * R)))
    if look.clip[0]:
        box(layer, point(cell, turn, 0.3 * R), turn, rng.uniform(0.4, 0.65) * R, look.clip[0] * R, np.full(3, look.clip[1]))
    if rng.random() < 0.5:
        disc(layer, point(cell, turn + 2, 0.2 * R), rng.uniform(0.05, 0.2) * R, metal * rng.uniform(0.4, 1.4))
    if look.glare[0]:
        at = point(c, look.glare[1] + rng.normal(0, 0.1), look.glare[2] * R)
        box(layer, at, look.glare[1] + np.pi / 2, rng.uniform(0.08, 0.35) * R, rng.uniform(0.03, 0.15) * R, np.full(3, look.glare[3]))
    if look.domes:
        disc(layer, point(c, turn + 1.43, 0.88 * R), 0.08 * R, np.full(3, look.domes))
    if look.motors:
        for at in (1.57, -1.57):
            box(layer, point(c, turn + at, rng.uniform(0.7, 0.85) * R), turn, 0.12 * R, 0.06 * R, np.full(3, look.motors))
    layer = cv2.resize(layer * cover[..., None], (2 * half, 2 * half), interpolation=cv2.INTER_AREA)
    cover = cv2.resize(cover, (2 * half, 2 * half), interpolation=cv2.INTER_AREA)[..., None]
    h, w = canvas.shape[:2]
    x0, y0, x1, y1 = max(0, left), max(0, top), min(w, left + 2 * half), min(h, top + 2 * half)
    if x1 > x0 and y1 > y0:
        part = np.s_[y0 - top:y1 - top, x0 - left:x1 - left]
        canvas[y0:y1, x0:x1] = canvas[y0:y1, x0:x1] * (1 - cover[part]) + layer[part]


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


def places(rng, size, r, count):
    """Where robots stand, apart or touching."""
    found = []
    touching = rng.choice([0, rng.uniform(0, 0.9)])
    for _ in range(count * 6):
        if len(found) >= count:
            break
        if found and rng.random() < touching:
            at = point(found[rng.integers(len(found))], rng.uniform(0, TAU), 2.02 * r * rng.choice([1, rng.uniform(1, 1.15)]))
        else:
            at = rng.uniform(-r, size + r, 2)
        if all(np.hypot(at[0] - o[0], at[1] - o[1]) > 2.01 * r for o in found):
            found.append(tuple(at))
    return found


def room(seed):
    """A BGR picture, and x, y, r of its robots, in pixels."""
    rng = np.random.default_rng([27, seed])
    scale = float(rng.choice([1, 1, 1.5, 2, 3]))  # the camera's pixels to one of the net's
    wanted = rng.uniform(3.7, 6.6) if rng.random() < 0.68 else rng.choice([rng.uniform(1.5, 2.8), rng.uniform(8.2, 12), rng.uniform(8.2, 40)])
    r, size = wanted * scale, int(SIZE * scale)
    canvas = floor_of(rng, size, size, r)
    things(rng, canvas, r, rng.poisson(rng.choice([0, 2, 6])))
    look = Look(rng)
    most = int((size / r) ** 2 / 4 * 0.6) + 1
    count = 0 if rng.random() < 0.1 else min(most, int(rng.choice([rng.integers(1, 6), rng.integers(4, 40), rng.integers(20, 120)])))
    robots = places(rng, size, r, count)
    # Shadows and what a mirroring floor shows.
    drop, soft, dark = rng.uniform(0, 0.6) * r, rng.uniform(0.05, 0.5) * r, rng.uniform(0, 0.75)
    light = rng.uniform(0, TAU)
    shadow = np.zeros((size, size), np.float32)
    for at in robots:
        disc(shadow, point(at, light, drop), 1.02 * r, 1.0)
    if robots:
        canvas *= 1 - dark * cv2.GaussianBlur(shadow, (0, 0), max(0.4, soft))[..., None]
    if rng.random() < 0.15:
        mirrored, away = rng.uniform(0.1, 0.45), rng.uniform(0.4, 1.3) * r
        image, way = canvas.copy(), rng.uniform(0, TAU)
        for at in robots:
            disc(image, point(at, way, away), r, look.board)
            disc(image, point(at, way, away), look.cell_radius * r, np.full(3, min(255, look.cell_grey)))
        canvas = canvas * (1 - mirrored) + image * mirrored
    middle = np.array([rng.uniform(-1, 2), rng.uniform(-1, 2)]) * size
    turns = rng.uniform(0, TAU, len(robots))
    for at, turn in zip(robots, turns):
        paint_robot(rng, canvas, at[0], at[1], r, turn, look, middle)
    # Light: lamps, LEDs, and one colour over everything.
    y, x = np.mgrid[0:size, 0:size].astype(np.float32) / size - 0.5
    way = rng.uniform(0, TAU)
    canvas *= np.clip(1 + rng.uniform(0, 0.8) * (x * np.cos(way) + y * np.sin(way)), 0.2, 2)[..., None]
    lit = rng.choice([0, 0, rng.uniform(0.1, 1)])
    one = rng.random() < 0.4 and LEDS[rng.integers(7)]
    width, halo, core_width, core = look.halo
    for at, turn in zip(robots, turns):
        if rng.random() < lit:
            colour = one if one is not False else LEDS[rng.integers(7)]
            led = point(at, turn + 1.43 + rng.normal(0, 0.1), rng.uniform(0.81, 0.96) * r)
            add_spot(canvas, led, width * r, colour * halo)
            add_spot(canvas, led, core_width * r, np.clip(look.core @ colour + rng.uniform(0, 0.4), 0, 1) * core)
    if rng.random() < 0.3:
        things(rng, canvas, r, int(rng.integers(1, 3)))
    truth = np.array([(*at, r) for at in robots], float).reshape(-1, 3)
    # A view that slants.
    if rng.random() < 0.45:
        corners = np.float32([[0, 0], [size, 0], [size, size], [0, size]])
        strong = rng.choice([0.04, 0.14])
        to = np.float32(corners + rng.uniform(-strong, strong, (4, 2)) * size)
        move = cv2.getPerspectiveTransform(corners, to)
        canvas = cv2.warpPerspective(canvas, move, (size, size), borderMode=cv2.BORDER_REFLECT_101)
        moved = []
        for px, py, pr in truth:
            around = cv2.perspectiveTransform(np.float64([[[px, py], [px + 1, py], [px, py + 1]]]), move)[0]
            moved.append((*around[0], pr * np.sqrt(abs(np.linalg.det(around[1:] - around[0])))))
        truth = np.array(moved).reshape(-1, 3)
    # The camera.
    # As it exposes itself, mostly.
    bright = np.percentile(canvas[::4, ::4].max(2), rng.uniform(60, 98))
    canvas *= np.clip(rng.choice([rng.uniform(130, 250), rng.uniform(50, 330)], p=[0.8, 0.2]) / max(bright, 10), 0.3, 4)
    if rng.random() < 0.4:
        canvas += rng.uniform(0.1, 0.6) * cv2.GaussianBlur(np.maximum(canvas - 200, 0), (0, 0), rng.uniform(0.2, 1.2) * r)
    canvas = cv2.GaussianBlur(canvas, (0, 0), rng.uniform(0.35, 1.3))
    if rng.random() < 0.12:
        length = int(rng.uniform(2, 0.9 * r + 3))
        kernel = np.zeros((length, length), np.float32)
        cv2.line(kernel, (0, int(rng.integers(length))), (length - 1, int(rng.integers(length))), 1.0)
        canvas = cv2.filter2D(canvas, -1, kernel / kernel.sum())
    canvas *= np.exp(rng.normal(0, rng.choice([0.03, 0.2], p=[0.7, 0.3]), 3)).astype(np.float32)
    haze = rng.choice([0, rng.uniform(0, 60)])
    canvas = 255 * (np.clip(canvas, 0, 255) / 255) ** rng.uniform(0.75, 1.35) * (1 - haze / 255) + haze
    if rng.random() < 0.25:  # sharpened
        canvas += rng.uniform(0.3, 1.5) * (canvas - cv2.GaussianBlur(canvas, (0, 0), 1.2))
    canvas += rng.normal(0, rng.uniform(0.3, 8) * rng.choice([0.3, 1]), canvas.shape)
    if rng.random() < 0.08:
        canvas[:] = canvas.mean(2, keepdims=True)
    picture = np.clip(canvas, 0, 255).astype(np.uint8)
    if rng.random() < 0.6:
        picture = cv2.imdecode(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(30, 96))])[1], 1)
    picture = cv2.resize(picture, (SIZE, SIZE), interpolation=cv2.INTER_AREA)
    truth[:, :2] = (truth[:, :2] + 0.5) / scale - 0.5
    truth[:, 2] /= scale
    return picture, truth
