"""A film of a recorded run without a browser: arenas, what the scenario shows, robots with trails that fade, the clock and a scale. Robots of other labs are left out."""
import bisect
import math
import pathlib
import struct
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path += [str(HERE.parent / "scripts"), str(HERE.parent / "scenarios/python"), str(HERE / "python")]  # of the sources; where arkmesh is installed
import numpy
from PIL import Image, ImageDraw, ImageFont

import arkmesh
import draw_overlay
import read_log
from figure_style import LEDS
from film_file import moments_of, write

FINER = 2  # edges are smooth because pictures are drawn larger
PAGE, GROUND, WALL, INK, BODY = "#e9e7e1", "#fbfaf6", "#4a4a46", "#1c1f22", "#3b4148"
TRAILS = ["#dcdad4", "#bfc2c4", "#9aa2a8"]  # the oldest third first
TRAIL_S = 30


def font_of(pixels):
    try:
        return ImageFont.truetype("DejaVuSans.ttf", pixels)
    except OSError:  # Pillow's own has one size
        return ImageFont.load_default()


def clock(t_s):
    minutes, seconds = divmod(math.floor(t_s * 10 + 1e-6) / 10, 60)
    return f"{int(minutes)}:{seconds:04.1f}"


class Arena:
    """One lab's, in its part of the picture."""

    def __init__(self, lab, left, top, width, height, caption_px):
        self.lab, self.overlays = lab, []
        for _, channel, data in read_log.events(read_log.log_in(lab.folder)):
            if channel == "arena":
                arena = read_log.decode(data)
            elif channel == "overlay":
                self.overlays.append((struct.unpack(">q", data[8:16])[0] / 1e6, data))
        self.size, self.radius_m = (arena.width_m, arena.height_m), arena.body_radius_m
        self.scale = 0.94 * min(width / arena.width_m, (height - caption_px) / arena.height_m)
        self.middle, self.caption_px = (left + width / 2, top + caption_px + (height - caption_px) / 2), caption_px
        self.drawn_at, self.floor = None, None

    def place(self, x_m, y_m):
        return self.middle[0] + x_m * self.scale, self.middle[1] - y_m * self.scale

    def disc(self, x_m, y_m, radius_m):
        x, y = self.place(x_m, y_m)
        return [x - radius_m * self.scale, y - radius_m * self.scale, x + radius_m * self.scale, y + radius_m * self.scale]

    def words(self, draw, x, y, text, colour, share=0.55):
        """As high as that share of a caption."""
        draw.text((x, y), text, fill=colour, font=font_of(round(share * self.caption_px)), anchor="mm")

    def paint_floor(self, picture, t_s):
        """What lies still, which is kept until the scenario draws anew."""
        at = bisect.bisect_right([stamp for stamp, _ in self.overlays], t_s) - 1
        if self.floor is None or at != self.drawn_at:
            self.drawn_at, self.floor = at, Image.new("RGBA", picture.size)
            draw = ImageDraw.Draw(self.floor)
            w, h = self.size
            draw.rectangle([*self.place(-w / 2, h / 2), *self.place(w / 2, -h / 2)], fill=GROUND, outline=WALL, width=2 * FINER)
            overlay = read_log.decode(self.overlays[at][1]) if at >= 0 else None
            if overlay is not None:
                self.paint_overlay(overlay)
            self.words(ImageDraw.Draw(self.floor), *self.place(0, h / 2 + 0.6 * self.caption_px / self.scale), self.lab.name, INK)
        picture.paste(self.floor, (0, 0), self.floor)

    def paint_overlay(self, overlay):
        layer = Image.new("RGBA", self.floor.size)
        draw, texts = ImageDraw.Draw(layer), []

        def colours(shape):
            colour = draw_overlay.look_of(shape.colour)[0]
            return colour, colour + f"{round(255 * draw_overlay.TABLE['fill_opacity']):02x}" if getattr(shape, "filled", False) else None
        for raster in overlay.rasters:
            colour = colours(raster)[0]
            for i, value in enumerate(bytes(raster.cells) if raster.columns > 0 else b""):
                if value:
                    row, column = divmod(i, raster.columns)
                    corners = [self.place(*draw_overlay.raster_corner(raster, column + a, row + b)) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
                    draw.polygon(corners, fill=colour + f"{round(value * draw_overlay.TABLE['raster_opacity']):02x}")
        for polygon in overlay.polygons:
            corners = [self.place(p.x_m, p.y_m) for p in polygon.corners]
            colour, fill = colours(polygon)
            draw.polygon(corners, fill=fill, outline=colour)
            texts.append((*numpy.mean(corners, axis=0), polygon.label, colour))
        for circle in overlay.circles:
            colour, fill = colours(circle)
            draw.ellipse(self.disc(circle.x_m, circle.y_m, circle.radius_m), fill=fill, outline=colour, width=FINER)
            texts.append((*self.place(circle.x_m, circle.y_m + circle.radius_m + 0.3 * self.caption_px / self.scale), circle.label, colour))
        for line in overlay.lines:
            draw.line([self.place(p.x_m, p.y_m) for p in line.points], fill=colours(line)[0], width=2 * FINER)
        texts += [(*self.place(text.x_m, text.y_m), text.text, colours(text)[0]) for text in overlay.texts]
        self.floor.alpha_composite(layer)
        for x, y, text, colour in texts:
            self.words(ImageDraw.Draw(self.floor), x, y, text, colour, 0.4)

    def paint_robots(self, draw, t_s, trail_s):
        lab = self.lab
        row = max(0, int(numpy.searchsorted(lab.t_s, t_s + 1e-9, "right")) - 1)
        first = int(numpy.searchsorted(lab.t_s, t_s - trail_s))
        parts = numpy.linspace(first, row, len(TRAILS) + 1).astype(int)
        for colour, begin, end in zip(TRAILS, parts, parts[1:]):
            for robot in range(len(lab.ids)):
                path = lab.xy[begin:end + 1, robot]
                path = path[~numpy.isnan(path[:, 0])]
                if len(path) > 1:
                    draw.line([self.place(x, y) for x, y in path[:: max(1, len(path) // 20)]] + [self.place(*path[-1])], fill=colour, width=FINER)
        for (x, y), heading, led in zip(lab.xy[row], lab.heading[row], lab.led[row]):
            if math.isnan(x):
                continue
            draw.ellipse(self.disc(x, y, self.radius_m), fill=BODY)
            draw.ellipse(self.disc(x, y, 0.6 * self.radius_m), fill=LEDS[min(led, 8)])
            draw.line([self.place(x + r * self.radius_m * math.cos(heading), y + r * self.radius_m * math.sin(heading)) for r in (0.6, 1.4)], fill=BODY, width=2 * FINER)


def pictures(labs, begin_s, step_s, moments, length_s, speed, width, height, trail_s=None):
    """Each moment as bytes of RGB, and how many there are so far."""
    size, caption_px = (FINER * width, FINER * height), FINER * 28
    columns = max(range(1, len(labs) + 1), key=lambda n: min(size[0] / n, size[1] / math.ceil(len(labs) / n)))
    rows = math.ceil(len(labs) / columns)
    cell = size[0] / columns, (size[1] - caption_px) / rows
    arenas = [Arena(lab, i % columns * cell[0], i // columns * cell[1], *cell, caption_px) for i, lab in enumerate(labs)]
    # Labs see their arenas in scales of their own.
    bar_m = 10 ** math.floor(math.log10(min(arena.size[0] for arena in arenas) / 2))
    for i in range(1, moments + 1):
        t_s = begin_s + i * step_s
        picture = Image.new("RGB", size, PAGE)
        for arena in arenas:
            arena.paint_floor(picture, t_s)
        draw = ImageDraw.Draw(picture)
        for arena in arenas:
            arena.paint_robots(draw, t_s, TRAIL_S if trail_s is None else trail_s)
            x, y = arena.place(-arena.size[0] / 2, -arena.size[1] / 2)
            draw.line([x + 4 * FINER, y - 5 * FINER, x + 4 * FINER + bar_m * arena.scale, y - 5 * FINER], fill=INK, width=3 * FINER)
        arenas[0].words(draw, size[0] / 2, size[1] - caption_px / 2, f"{clock(t_s)} of {clock(length_s)}, {speed:g}×, bar {bar_m:g} m", INK)
        yield i, picture.resize((width, height), Image.BOX).tobytes()


def film(folder, out, begin_s, end_s, speed, per_s, width, height, trail_s=None):
    """As film_frames.film, of a run's folder."""
    labs = [lab for lab in arkmesh.open_run(folder).labs.values() if len(lab.t_s)]
    length_s = max(float(lab.t_s[-1]) for lab in labs)
    moments, step_s = moments_of(begin_s, min(end_s, length_s), length_s, speed, per_s)
    write(out, pictures(labs, max(0, begin_s), step_s, moments, length_s, speed, width, height, trail_s), moments, per_s,
          ["rawvideo", "-pix_fmt", "rgb24", "-video_size", f"{width}x{height}"])
    return moments
