"""The table of colours by meaning: told apart by people who cannot tell red from green, readable on its grounds, documented."""
import itertools
import json
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COLOURS = json.loads((ROOT / "view/page/colours.json").read_text())["colours"]
GROUNDS = {"light": "#ffffff", "dark": "#101418"}
# How linear RGB looks to eyes without one kind of cones: Machado, Oliveira and Fernandes, IEEE Trans. Vis. Comput. Graph. 15 (2009), severity 1.
EYES = {
    "all cones": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "protanopia": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "deuteranopia": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
}
XYZ = ((0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505))  # of linear sRGB, D65


def times(matrix, vector):
    return [sum(a * b for a, b in zip(row, vector)) for row in matrix]


def linear(colour):
    parts = [int(colour[i:i + 2], 16) / 255 for i in (1, 3, 5)]
    return [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]


def lab(colour, eyes):
    """CIELAB of what these eyes see."""
    seen = [min(1, max(0, part)) for part in times(EYES[eyes], linear(colour))]
    f = [v ** (1 / 3) if v > 0.008856 else 7.787 * v + 16 / 116 for v in (a / b for a, b in zip(times(XYZ, seen), (0.9505, 1, 1.089)))]
    return 116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])


def distance(a, b, eyes):
    return sum((p - q) ** 2 for p, q in zip(lab(a, eyes), lab(b, eyes))) ** 0.5


def contrast(a, b):
    """As WCAG 2 defines it."""
    dark, light = sorted(times(XYZ, linear(colour))[1] for colour in (a, b))
    return (light + 0.05) / (dark + 0.05)


class Colours(unittest.TestCase):
    def test_all_eyes_tell_them_apart(self):
        """Any two differ by 12 (2.3 is just noticeable) for all eyes, and by 15 where their patterns are the same, on either ground."""
        for ground, eyes, (a, b) in itertools.product(GROUNDS, EYES, itertools.combinations(COLOURS, 2)):
            apart = distance(COLOURS[a][ground], COLOURS[b][ground], eyes)
            self.assertGreater(apart, 15 if COLOURS[a]["pattern"] == COLOURS[b]["pattern"] else 12, f"{a}, {b}: {ground}, {eyes}")

    def test_red_and_green_alone_would_fail(self):
        """The measure sees what it is for: a red and a green of one lightness are far apart for most people, and near for some."""
        self.assertGreater(distance("#b06030", "#607818", "all cones"), 40)
        self.assertLess(distance("#b06030", "#607818", "deuteranopia"), 12)

    def test_they_can_be_seen(self):
        """Each has the contrast that WCAG 2.1 asks of graphical objects, 3 to 1."""
        for name, colour in COLOURS.items():
            for ground, rgb in GROUNDS.items():
                self.assertGreaterEqual(contrast(colour[ground], rgb), 3, f"{name} on {ground}")

    def test_the_table_for_scenario_writers_is_this_one(self):
        """docs/writing-a-scenario.md lists the same colours with the same meanings."""
        page = (ROOT / "docs/writing-a-scenario.md").read_text().split("| colour | meaning |")[1].split("\n\n")[0]
        listed = dict(re.findall(r"\| `(\w+)` \| ([^|;]+?) *[;|]", page))
        self.assertEqual(listed, {name: colour["means"] for name, colour in COLOURS.items()})


if __name__ == "__main__":
    unittest.main()
