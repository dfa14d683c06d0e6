"""Pictures of rooms that never were, with their truth: what the search net is trained on.

Painted on purpose by other code than the emulator's, whose rooms test the net. A picture is as large as the net sees
it: its robots have a radius of some 5 pixels, or, a third of them, another one, so that they are to be left alone.
"""
import cv2
import numpy as np

from things import TAU, add_spot, box, disc, noise, point, things, tinted, write

SIZE = 160  # of a picture's sides
LEDS = np.array([[(i >> 2) & 1, (i >> 1) & 1, i & 1] for i in range(1, 8)], float)  # blue, green, red


def floor_of(rng, h, w, r, board, near):
    grey = rng.choice([rng.uniform(120, 240), rng.uniform(120, 240), rng.uniform(60, 140), rng.uniform(15, 70), board * rng.uniform(0.7, 1.5)],
                      p=[0.24, 0.24, 0.2, 0.2, 0.12])
    out = np.ones((h, w, 3), np.float32) * tinted(rng, grey, rng.choice([0.02, 0.05, 0.25], p=[0.5, 0.35, 0.15])).astype(np.float32)
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    for _ in range(rng.integers(0, 4)):
        strong = rng.choice([0.1, 0.5], p=[0.9, 0.1])
        out *= np.maximum(0.1, 1 + rng.uniform(0, strong) * rng.random() * noise(rng, (h, w), r * 10 ** rng.uniform(-1, 1)))[..., None]
    kind = rng.random() * (0.7 if near else 1)
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
        write(rng, out, r, rng.integers(3, 40))
    elif kind < 0.38:  # small print, as bits of ink in rows
        bits = (rng.random((max(2, int(6 * h / period)), max(2, int(w * 10 ** rng.uniform(0.2, 1) / period)))) < rng.uniform(0.15, 0.6)) * 1.0
        bits[::rng.integers(2, 5)] = 0
        bits = cv2.warpAffine(cv2.resize(bits, (w, h), interpolation=cv2.INTER_NEAREST),
                              cv2.getRotationMatrix2D((w / 2, h / 2), rng.choice([0, 90, rng.uniform(0, 360)]), 1), (w, h))
        out *= 1 - rng.uniform(0.2, 0.9) * bits[..., None].astype(np.float32)
    elif kind < 0.42:  # projected or painted areas
        for _ in range(rng.integers(1, 6)):
            disc(out, (rng.uniform(0, w), rng.uniform(0, h)), r * rng.uniform(1.5, 12), tinted(rng, rng.uniform(30, 255), 0.5))
    return out


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


def places(rng, size, r, count, near):
    """Where robots stand, apart or touching."""
    found = []
    touching = rng.choice([0, rng.uniform(0, 0.9), rng.uniform(0.8, 1)], p=[0.25, 0.35, 0.4]) if near else rng.choice([0, rng.uniform(0, 0.9)])
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


def room(seed, near=False):
    """A BGR picture, and x, y, r of its robots, in pixels. For the close look, `near`: radii of 4 to 26, more empty rooms, and more that may be taken for robots."""
    rng = np.random.default_rng([28 if near else 27, seed])
    if near:
        scale, wanted = 1.0, 4 * 6.5 ** rng.random()
    else:
        scale = float(rng.choice([1, 1, 1.5, 2, 3]))  # the camera's pixels to one of the net's
        wanted = rng.uniform(3.7, 6.6) if rng.random() < 0.68 else rng.choice([rng.uniform(1.5, 3), rng.uniform(7.2, 9), rng.uniform(7.2, 12), rng.uniform(8, 40)])
    r, size = wanted * scale, int(SIZE * scale)
    look = Look(rng)
    if near and rng.random() < 0.15:  # black discs, with hardly anything to be seen on them
        look.cell_grey = look.board.mean() * rng.uniform(0.7, 1.8)
    canvas = floor_of(rng, size, size, r, look.board.mean(), near)
    empty = rng.random() < (0.3 if near else 0.2)
    things(rng, canvas, r, rng.poisson(rng.choice([6, 15, 30] if empty else [0, 2, 6, 12])), near)
    most = int((size / r) ** 2 / 4 * 0.6) + 1
    count = 0 if empty else min(most, int(rng.choice([rng.integers(1, 6), rng.integers(4, 40), rng.integers(20, 120)])))
    robots = places(rng, size, r, count, near)
    # Shadows and what a mirroring floor shows.
    drop, soft, dark = rng.uniform(0, 0.6) * r, rng.uniform(0.05, 0.5) * r, rng.uniform(0, 0.75)
    if near and rng.random() < 0.15:  # of a lamp that hangs low
        drop = rng.uniform(0.6, 2.4) * r
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
    canvas *= np.exp(rng.normal(0, rng.choice([0.03, 0.2, 0.4], p=[0.65, 0.28, 0.07]), 3)).astype(np.float32)
    haze = rng.choice([0, rng.uniform(0, 60)]) * np.ones((size, size, 1), np.float32)
    if rng.random() < 0.12:  # in a part of it
        steep = 10 ** rng.uniform(0.3, 1.5)
        haze += rng.uniform(30, 190) / (1 + np.exp(-steep * (x * np.cos(way := rng.uniform(0, TAU)) + y * np.sin(way) + rng.uniform(-0.3, 0.3))))[..., None]
    haze = np.minimum(haze, 200)
    curve = rng.choice([rng.uniform(0.75, 1.35), rng.uniform(0.45, 2.2)], p=[0.8, 0.2])
    canvas = 255 * (np.clip(canvas, 0, 255) / 255) ** curve * (1 - haze / 255) + haze
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
