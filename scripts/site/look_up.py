"""Pages of the site that are made of what is there: commands, messages, counters."""
import csv
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/package"))
import pages  # noqa: E402


def output(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def words(text):
    """Plain text as Markdown, with its `code`."""
    parts = re.split(r"(`[^`]*`)", text)
    plain = [re.sub(r"([\\*_\[\]|#])", r"\\\1", part.replace("&", "&amp;").replace("<", "&lt;")) for part in parts[::2]]
    return "".join(a + b for a, b in zip(plain, [part.replace("|", "\\|") for part in parts[1::2]] + [""]))


def table(heads, rows):
    return "\n".join("| " + " | ".join(row) + " |" for row in [heads, ["---"] * len(heads), *rows]) + "\n\n"


def table_of(file):
    """A table of values separated by commas; an address is shown by the repository that it names."""
    def cell(text):
        return re.sub(r"^https://github.com/([^/]+/[^/]+)/.*", r"[\1](\g<0>)", text) if text.startswith("https://") else words(text)

    heads, *rows = csv.reader(file.read_text().splitlines())
    return table(heads, [[cell(text) for text in row] for row in rows])


def blocks(text):
    """The end of a help: lines that begin with two blanks are commands."""
    out = ""
    for is_code, part in re.findall(r"((?m:^  ))?((?(1)(?:.*\n?)(?:  .*\n?)*|(?:(?!  ).*\n?)+))", text + "\n"):
        part = part.strip("\n")
        if part:
            out += f"```\n{part}\n```\n\n" if is_code else words(part) + "\n\n"
    return out


def commands(program):
    """What `arkmesh --help` and `arkmesh COMMAND --help` say."""
    whole = pages.Help(program, [])

    def section(command, depth):
        out = f"{'#' * depth} arkmesh {' '.join(command.words)}\n\n{words(command.purpose)}.\n\n```\n{command.usage}\n```\n\n"
        rows = [row for part in ("Positionals", "Options") for row in command.parts.get(part, []) if row[0] != "-h,--help"]
        if rows:
            out += table(["argument", "meaning"], [[f"`{name}`".replace("|", "\\|"), words(meaning)] for name, meaning in rows])
        out += "".join(section(each, depth + 1) for each in command.subcommands)
        return out + (blocks(command.end) if command.end and command.end != whole.end else "")

    rows = [[f"[{each.words[0]}](#arkmesh-{each.words[0]})", words(each.purpose)] for each in whole.subcommands]
    return (f"# Commands\n\nThe output of `--help` of each command.\n\n{table(['arkmesh', 'what it does'], rows)}{blocks(whole.end)}"
            + "".join(section(each, 2) for each in whole.subcommands))


def messages(folder):
    """The LCM types as lcmtypes/*.lcm define them, with their comments."""
    out = ("# Messages\n\nThe types of LCM messages. [Formats](formats.md#loglcm) says which channel carries which and when. All of them are in the "
           "package `arkmesh`.\n\n")
    files = {file.stem: file.read_text() for file in sorted(folder.glob("*.lcm"))}
    out += " ".join(f"[{words(name)}](#{name})" for name in files) + "\n\n"
    for name, text in files.items():
        about = " ".join(re.findall(r"^// ?(.*)$", text.partition("struct")[0], re.M))
        out += f"## {name}\n\n{words(about)}\n\n"
        rows, before = [], ""
        for line in text.partition("{")[2].splitlines():
            field, _, comment = (part.strip() for part in line.partition("//"))
            if found := re.match(r"(const\s+)?(\w+)\s+(.+?)\s*;", field):
                constant, kind, member = found.groups()
                kind = f"[{words(kind)}](#{kind})" if kind in files else f"`{constant or ''}{kind}`"
                rows.append([f"`{member}`", kind, words(f"{before} {comment}".strip())])
                before = ""
            elif comment and line.startswith("     "):  # goes on what stands behind the field above
                rows[-1][2] += " " + words(comment)
            elif comment:
                before = f"{before} {comment}".strip()
        out += table(["field", "type", "meaning"], rows)
    return out


def counters_of(file):
    """Where the section on counters of a README is, or None."""
    return re.search(r"^## Counters\n(.*?)(?=^## |\Z)", file.read_text(), re.M | re.S)


def counters(root):
    """The tables of counters in the READMEs of the folders below `root`, which afterwards lead here."""
    out = ("# Counters\n\nEverything dropped, replaced, late or refused is counted. `arkmesh status` shows the counters of a running lab; "
           "`result.json` holds them afterwards.\n\n")
    for file in sorted(root.rglob("README.md")):
        text, found = file.read_text(), counters_of(file)
        if not found:
            continue
        folder = file.parent.relative_to(root)
        here = re.sub(r"\]\((?!#|\w+:)([^)]+)\)", lambda link: f"]({os.path.relpath(folder / link[1], 'docs')})", found[1])
        out += f"## {folder}\n\n{here.strip()}\n\n"
        there = os.path.relpath("docs/counters.md", folder) + "#" + str(folder).replace("/", "")
        file.write_text(text.replace(found[0], f"## Counters\n\nSee [counters]({there}).\n\n"))
    return out


def python_api(package):
    """A page of Markdown for mkdocstrings: what the package exports, then what a Lab has besides; each by the module that defines it."""
    init = (package / "__init__.py").read_text()
    home = {name: module for module, names in re.findall(r"^ *from \.(\w+) import (.+)$", init, re.M) for name in names.split(", ")}
    exported = re.findall(r'"(\w+)"', re.search(r"^__all__ = \[(.*)\]$", init, re.M)[1])
    pieces = re.findall(r"^class (\w+)\(Piece\):", (package / "pieces.py").read_text(), re.M)
    parts = {"Runs": [*(f"{home[name]}.{name}" for name in ("run", "batch", "sweep", "check", "lab", "Failed")), "running.Loop"],
             "Scenarios": ["scenario.Scenario", "lab_facade.Lab", "telling.Telling", "showing.Showing", "kit.Kit", "scenario.Others", "scenario.Solid", "places.within"],
             "Pieces of the kit": [f"pieces.{name}" for name in pieces],
             "Recorded runs": ["batches.open_run", "recorded.Run", "recorded.LabRun", "recorded.Arrays", "batches.Batch", "tables.read_table"]}
    missing = set(exported) - {name.rpartition(".")[2] for names in parts.values() for name in names}
    if missing:
        sys.exit(f"site: no part of the page of Python's package has {', '.join(sorted(missing))}")
    out = "# Python\n\nWhat `import arkmesh` offers, with units and shapes; [Writing a scenario](writing-a-scenario.md) and [Reading results](reading-results.md) explain it. " \
          "A `Lab` has the methods of `Telling`, `Showing` and `Kit`, too; a `Run` and a `LabRun` have what `Arrays` has.\n\n"
    return out + "".join(f"## {part}\n\n" + "".join(f"::: arkmesh.{name}\n\n" for name in names) for part, names in parts.items())
