"""What a scenario shows, as drawing/plot draws it: by the pixels of pictures with one shape each."""
import io
import unittest

import run_folder  # noqa: F401  finds the modules of scripts
import draw_overlay
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from PIL import Image  # noqa: E402
from run_folder import new  # noqa: E402

SIDE_PX = 400


def point(x_m, y_m):
    return new("point_t", x_m=x_m, y_m=y_m)


def square(half_m, **how):
    return new("overlay_polygon_t", corners=[point(-half_m, -half_m), point(half_m, -half_m), point(half_m, half_m), point(-half_m, half_m)], **how)


class Picture:
    """A square metre, 400 pixels wide, with these shapes."""

    def __init__(self, **shapes):
        message = new("overlay_t", **shapes)
        message = type(message).decode(message.encode())  # as it comes from a log
        figure = plt.figure(figsize=(4, 4), dpi=100)
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set(xlim=(-0.5, 0.5), ylim=(-0.5, 0.5))
        axes.set_axis_off()
        self.legend = [entry.get_label() for entry in draw_overlay.draw(axes, message)]
        png = io.BytesIO()
        figure.savefig(png)
        plt.close(figure)
        self.image = Image.open(png).convert("RGB")

    def at(self, x_m, y_m):
        return self.image.getpixel((int((x_m + 0.5) * SIDE_PX), int((0.5 - y_m) * SIDE_PX)))

    def inked(self, x_m, y_m, half_m=0.008):
        """Pixels about a place that are not white."""
        half, x, y = round(half_m * SIDE_PX), int((x_m + 0.5) * SIDE_PX), int((0.5 - y_m) * SIDE_PX)
        return sum(max(abs(255 - part) for part in self.image.getpixel((a, b))) > 24
                   for a in range(x - half, x + half + 1) for b in range(y - half, y + half + 1))


def under(name, opacity):
    """White under a colour of that opacity."""
    colour = draw_overlay.TABLE["colours"][name]["light"]
    return tuple(255 * (1 - opacity) + int(colour[i:i + 2], 16) * opacity for i in (1, 3, 5))


class Shapes(unittest.TestCase):
    def assert_alike(self, seen, wanted):
        self.assertTrue(all(abs(a - b) < 10 for a, b in zip(seen, wanted)), f"{seen} is not {wanted}")

    def test_circle(self):
        fill = draw_overlay.TABLE["fill_opacity"]
        for filled in (False, True):
            drawn = Picture(circles=[new("overlay_circle_t", x_m=0.1, y_m=0.2, radius_m=0.2, colour="site_active", filled=filled, label="2/3")])
            self.assert_alike(drawn.at(0.1, 0.2), under("site_active", fill) if filled else (255, 255, 255))
            self.assertGreater(drawn.inked(0.3, 0.2), 0)
            self.assertGreater(drawn.inked(0.1, 0.42, 0.02), 10)  # the label
            self.assertEqual(drawn.inked(-0.2, 0.2), 0)
            self.assertEqual(drawn.legend, [draw_overlay.TABLE["colours"]["site_active"]["means"]])

    def test_polygon_and_pattern(self):
        """A plain fill is alike everywhere; a hatched one is not."""
        for name, shades in (("region_poor", 1), ("region_rich", 2), ("site_hard", 2), ("warning", 2)):
            drawn = Picture(polygons=[square(0.3, colour=name, filled=True)])
            seen = {drawn.at(x / SIDE_PX, y / SIDE_PX) for x in range(-60, 60) for y in range(-60, 60)}
            self.assertGreaterEqual(len(seen), shades, name)
            if shades == 1:
                self.assertEqual(len(seen), 1)
            self.assertGreater(drawn.inked(0.3, 0), 0)
            self.assertEqual(drawn.inked(0.4, 0), 0)

    def test_dashes(self):
        """A dashed line and a dashed outline have gaps."""
        for dashed in (False, True):
            line = Picture(lines=[new("overlay_line_t", points=[point(-0.4, 0), point(0.4, 0)], colour="note", dashed=dashed)])
            outline = Picture(polygons=[square(0.3, colour="note", dashed=dashed)])
            for drawn, y_m in ((line, 0), (outline, 0.3)):
                gaps = sum(drawn.inked(x / SIDE_PX, y_m, 0.003) == 0 for x in range(-100, 100))
                self.assertEqual(gaps > 20, dashed)

    def test_text(self):
        drawn = Picture(texts=[new("overlay_text_t", x_m=-0.2, y_m=0.3, text="here $5", colour="note")])
        self.assertGreater(drawn.inked(-0.2, 0.3, 0.04), 20)

    def test_raster(self):
        """Cells by their values; the grid turned by 90 degrees goes north with its rows and west with its columns."""
        full = draw_overlay.TABLE["raster_opacity"]
        for turn, side in ((0, 1), (1.5707963267948966, -1)):
            drawn = Picture(rasters=[new("overlay_raster_t", heading_rad=turn, cell_m=0.1, columns=2, rows=2, cells=bytes([255, 100, 0, 255]),
                                         colour="pheromone")])
            low, none = ((0.15, 0.05), (0.05, 0.15)) if side == 1 else ((-0.05, 0.15), (-0.15, 0.05))
            self.assert_alike(drawn.at(side * 0.05, 0.05), under("pheromone", full))
            self.assert_alike(drawn.at(*low), under("pheromone", full * 100 / 255))
            self.assert_alike(drawn.at(*none), (255, 255, 255))
            self.assert_alike(drawn.at(side * 0.15, 0.15), under("pheromone", full))

    def test_what_is_not_known_or_not_whole(self):
        """An unknown colour is a note; a raster whose cells are not its rows and a line without points draw nothing."""
        drawn = Picture(circles=[new("overlay_circle_t", radius_m=0.2, colour="of_the_future", filled=True)])
        self.assert_alike(drawn.at(0, 0), under("note", draw_overlay.TABLE["fill_opacity"]))
        drawn = Picture(rasters=[new("overlay_raster_t", cell_m=0.1, columns=2, rows=2, cells=b"\xff", colour="own")],
                        lines=[new("overlay_line_t", points=[], colour="own")], polygons=[new("overlay_polygon_t", corners=[], colour="own")])
        self.assertEqual(drawn.inked(0, 0, 0.4), 0)


if __name__ == "__main__":
    unittest.main()
