"""Files of pictures: each is of the kind that the ending of its name says, or is refused in one sentence."""
import pathlib
import sys

# Endings, and the kinds that matplotlib and Pillow write for them.
KINDS = {".png": "png", ".jpg": "jpeg", ".jpeg": "jpeg", ".pdf": "pdf", ".svg": "svg"}


def kind_of(file, kinds=KINDS, what="pictures"):
    """Ends the script when no such file can be written."""
    ending = pathlib.Path(file).suffix.lower()
    if ending not in kinds:
        *some, last = kinds
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {file}: {what} end in {', '.join(some)} or {last}; give a name with one of these")
    return kinds[ending]


def save(figure, file, **how):
    """Writes a figure of matplotlib."""
    kind = kind_of(file)
    try:
        figure.savefig(file, format=kind, **how)
    except OSError as why:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {file} cannot be written: {why.strerror}; choose another place with --out")


def seed_words(seeds):
    """Of the runs that a picture shows: ", seed 7", ", seeds 1 to 20"; nothing when they are not known."""
    seeds = sorted(seeds)
    if len(seeds) < 2:
        return "".join(f", seed {seed}" for seed in seeds)
    if seeds == list(range(seeds[0], seeds[-1] + 1)) and len(seeds) > 2:
        return f", seeds {seeds[0]} to {seeds[-1]}"
    return f", seeds {', '.join(map(str, seeds[:-1]))} and {seeds[-1]}" if len(seeds) < 8 else f", {len(seeds)} seeds"
