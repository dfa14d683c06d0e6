"""What all figures share: their size and type, words for names, and files, each of the kind that the ending of its name says."""
import contextlib
import json
import pathlib
import re
import sys
import textwrap

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "scripts"))  # where arkmesh is not installed: of read_log, which modules of figures take
# Of the page, too: beside an installed script, or among the sources.
TABLE = json.loads(next(file for file in (HERE / "colours.json", HERE.parent / "view/page/colours.json") if file.is_file()).read_text())
# By bits of red, green and blue, on light ground; the last is unknown.
LEDS, LED_NAMES = TABLE["leds"]["light"], ["off", "red", "green", "yellow", "blue", "magenta", "cyan", "white", "unknown"]
# Inches: one column and both columns of a journal's page (IEEE's templates).
WIDTHS_IN = {"column": 3.5, "page": 7.16}
# Type 42 is TrueType: journals refuse the Type 3 fonts that matplotlib writes otherwise.
STYLE = {"pdf.fonttype": 42, "ps.fonttype": 42, "font.size": 8, "axes.titlesize": 9, "legend.fontsize": 7, "legend.title_fontsize": 7, "legend.frameon": False,
         "xtick.labelsize": 7, "ytick.labelsize": 7}
COLOURS = ["#1b6ca8", "#d95f02", "#66a61e", "#7f4fa0", "#a6761d", "#e7298a", "#444444"]
# Endings of names that are units, as labels write them; "_s" after another unit is "per second".
UNITS = {"s": "s", "ms": "ms", "us": "\u00b5s", "m": "m", "cm": "cm", "mm": "mm", "deg": "deg", "rad": "rad", "hz": "Hz", "pct": "%", "ppm": "ppm", "bytes": "bytes"}

# Endings, and the kinds that matplotlib and Pillow write for them.
KINDS = {".png": "png", ".jpg": "jpeg", ".jpeg": "jpeg", ".pdf": "pdf", ".svg": "svg"}


class Refused(ValueError):
    """What cannot be drawn, in one sentence."""


def told_in(folder):
    """{name: what the scenario tells of it} of settings by key and of series, in the folder of a lab, a run or a batch; in its order."""
    results = (file for pattern in ("", "*/", "runs/*/", "runs/*/*/") for file in sorted(folder.glob(pattern + "result.json")))
    shown = next((told for file in results if (told := json.loads(file.read_text()).get("shown"))), [])
    return {each["of"].partition(".")[2]: each for each in shown if each["of"].startswith(("series.", "setting."))}


def words_of(name, told=None):
    """The words and the unit, if it has one, of a setting, a count or a column: "gate.period_s" is ("gate period", "s"), "lit@b" ("lit, lab b", "").
    What the scenario tells of it (told_in) takes their place."""
    name, _, lab = name.partition("@")
    about = (told or {}).get(name, {})
    *words, last = re.split("[._]", re.sub("^(scenario|arena)[.]", "", name)) or [name]
    unit = UNITS.get(last.lower()) if words else None
    if unit == "s" and len(words) > 1 and words[-1].lower() in UNITS:
        unit = UNITS[words.pop().lower()] + "/s"
    text = about.get("words") or " ".join(words if unit else [*words, last])
    return text + (f", lab {lab}" if lab else ""), about.get("unit") or unit or ""


def label_of(name, told=None):
    """An axis's: "gate period (s)"."""
    words, unit = words_of(name, told)
    return words + (f" ({unit})" if unit else "")


def setting_of(name, value, told=None):
    """A legend's: "gate period 2 s"."""
    words, unit = words_of(name, told)
    return f"{words} {value} {unit}".rstrip()


def new(width="page", height_per_width=0.62, rows=1, columns=1, **how):
    """A figure of matplotlib as wide as a journal's column or page, and its axes."""
    import matplotlib.pyplot as plt  # here, so that whoever only wants words needs no matplotlib
    if width not in WIDTHS_IN:
        raise Refused(f"width {width!r}: a figure is as wide as a journal's {' or '.join(WIDTHS_IN)}")
    inches = WIDTHS_IN[width]
    return plt.subplots(rows, columns, figsize=(inches, inches * height_per_width), dpi=300 if width == "column" else 150, layout="constrained", **how)


@contextlib.contextmanager
def styled():
    """Within it figures are made and saved in our style; a caller's own settings are left as they were."""
    import matplotlib
    with matplotlib.rc_context(STYLE):
        yield


def wrapped(words, inches):
    """Lines of the smallest type, no wider than that."""
    return "\n".join(textwrap.wrap(words, max(30, round(inches * 24))))


def note(axes, words, title=None):
    """Small words above the axes that tell what is drawn, below a title."""
    words = wrapped(words, axes.get_position().width * axes.figure.get_figwidth())
    axes.set_title(words, loc="left", fontsize=6, color="#444444")
    if title:
        axes.set_title(title + "\n" * (words.count("\n") + 1))


def whole_numbers(axis, values):
    """Ticks at whole numbers where all values are such."""
    from matplotlib.ticker import MaxNLocator
    if all(value == round(value) for value in values):
        axis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))


def add_looks(parser, words=("xlabel", "ylabel", "title")):
    """Options of every drawer."""
    parser.add_argument("--width", choices=list(WIDTHS_IN), default="page", help="as wide as a journal's column (3.5 inches) or page (7.16), which is the default")
    for name in words:
        parser.add_argument("--" + name, help="label instead of the default one")


def run(main):
    """A drawer's main(): files instead of windows, and a sentence instead of a trace."""
    import matplotlib
    matplotlib.use("Agg")
    try:
        with styled():
            main()
    except Refused as why:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {why}")


def kind_of(file, kinds=KINDS, what="pictures"):
    """Of the file's name. Raises Refused when no such file can be written."""
    ending = pathlib.Path(file).suffix.lower()
    if ending not in kinds:
        *some, last = kinds
        raise Refused(f"{file}: {what} end in {', '.join(some)} or {last}; give a name with one of these")
    return kinds[ending]


def save(figure, file, **how):
    """Writes a figure of matplotlib."""
    kind = kind_of(file)
    try:
        figure.savefig(file, format=kind, **how)
    except OSError as why:
        raise Refused(f"{file} cannot be written: {why.strerror}; choose another place with --out") from None


def seed_words(seeds):
    """Of the runs that a picture shows: ", seed 7", ", seeds 1 to 20"; nothing when they are not known."""
    seeds = sorted(seeds)
    if len(seeds) < 2:
        return "".join(f", seed {seed}" for seed in seeds)
    if seeds == list(range(seeds[0], seeds[-1] + 1)) and len(seeds) > 2:
        return f", seeds {seeds[0]} to {seeds[-1]}"
    return f", seeds {', '.join(map(str, seeds[:-1]))} and {seeds[-1]}" if len(seeds) < 8 else f", {len(seeds)} seeds"
