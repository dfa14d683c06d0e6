#!/usr/bin/python3
"""scripts/package/pages.py PROGRAM FOLDER: writes man pages and completions of bash and zsh, from what PROGRAM and its
commands say by --help.

Below FOLDER there is a folder for each component of scripts/package, laid out as share/ is. A page is in the package of
the program that it is named after, and all others are in that of the command arkmesh.
"""
import pathlib
import re
import subprocess
import sys
import textwrap

COMPONENTS = {"arkmesh-lab": "lab", "arkmesh-recording": "lab", "arkmesh-testbed": "testbed",
              "arkmesh-guard": "testbed"}
# Programs that are no commands.
PROGRAMS = {
    "arkmesh-recording": (
        "reads recorded runs", r"The commands \fBarkmesh export\fR and \fBarkmesh plot\fR start it.",
        "arkmesh-export(1), arkmesh-plot(1)"),
    "arkmesh-guard": (
        "tells robots to stand when their lab is gone", "A lab with real robots starts it. It is not started by hand.",
        "arkmesh-lab(1), arkmesh-ohc(1)")}


class Help:
    """What `arkmesh WORDS --help` says, and those of its subcommands."""

    def __init__(self, program, words, before=()):
        command = [program, *before, *words[-1:], "--help"]
        said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        self.words, self.purpose = words, said.partition("\n")[0]
        self.usage = re.search(r"^Usage: (.*)$", said, re.M)[1]
        self.parts = {}
        rest = said.partition(self.usage)[2].lstrip("\n")
        while found := re.match(r"(Positionals|Options|Subcommands):\n((?:[ ].*\n?)*)\n*", rest):
            self.parts[found[1]] = self.rows(found[2])
            rest = rest[found.end():]
        self.end = rest.strip()
        # A subcommand is asked for behind what its command must be told.
        told = re.search(r"\[OPTIONS\] (.*) ?SUBCOMMAND", self.usage)
        inner = [*before, *words[-1:], *(told[1].split() if told and words else [])]
        self.subcommands = [Help(program, [*words, name], inner) for name, _ in self.parts.get("Subcommands", [])]

    @staticmethod
    def rows(text):
        rows = []
        for line in text.splitlines():
            if line.startswith("   "):
                rows[-1][1] = (rows[-1][1] + " " + line.strip()).strip()
            else:
                name, _, meaning = line.strip().partition("  ")
                rows.append([name, meaning.strip()])
        return rows

    def options(self):
        """(names, meaning, whether a value follows)"""
        for name, meaning in self.parts.get("Options", []):
            names, _, value = name.partition(" ")
            yield [each for each in re.split(r"[,=]", names) if each.startswith("-")], meaning, bool(value)


def roff(text):
    return re.sub(r"^([.'])", r"\\&\1", text.replace("\\", "\\e").replace("-", "\\-").replace('"', "\\(dq"), flags=re.M)


def rows_of(rows):
    return "".join(f".TP\n.B {roff(name)}\n{roff(meaning)}\n" for name, meaning in rows)


def end_of(text):
    out, is_example = "", False
    for line in text.splitlines():
        if line.startswith("  ") != is_example:
            is_example = not is_example
            out += ".PP\n.nf\n" if is_example else ".fi\n.PP\n"
        out += roff(line) + "\n"
    return out + (".fi\n" if is_example else "")


def page(title, purpose, body, version):
    head = f'.TH {title.upper()} 1 "" "arkmesh {version}" "User Commands"\n'
    return f"{head}.SH NAME\n{title} \\- {roff(purpose)}\n{body}"


def body_of(command):
    out = f".SH SYNOPSIS\n.B {roff(command.usage)}\n"
    for part in ("Positionals", "Options"):
        if part in command.parts:
            out += f".SH {'ARGUMENTS' if part == 'Positionals' else 'OPTIONS'}\n" + rows_of(command.parts[part])
    if command.subcommands:
        out += ".SH COMMANDS\n"
        for each in command.subcommands:
            if len(command.words) == 0:
                out += f".TP\n.BR arkmesh\\-{roff(each.words[0])} (1)\n{roff(each.purpose)}\n"
                continue
            out += f".SS {roff(each.usage)}\n{roff(each.purpose)}\n"
            out += rows_of(each.parts.get("Positionals", []))
            out += rows_of([row for row in each.parts["Options"] if row[0] != "-h,--help"])
            # A subcommand without an end of its own says that of all commands.
            is_own = each.end != command.end and "Exit codes: 0 done, 1 failed" not in each.end
            out += end_of(each.end) if is_own else ""
    return out + (f".SH NOTES\n{end_of(command.end)}" if command.end else "")


def tree(command):
    """All commands below, and itself."""
    yield command
    for each in command.subcommands:
        yield from tree(each)


def bash(whole):
    cases = ""
    for each in tree(whole):
        flags = [name for names, _, _ in each.options() for name in names]
        takes = [name for names, _, value in each.options() if value for name in names]
        words = " ".join(command.words[-1] for command in each.subcommands)
        cases += f"    '{' '.join(each.words)}') commands='{words}' options='{' '.join(flags)}'"
        cases += f" takes=' {' '.join(takes)} ' ;;\n"
    return textwrap.dedent("""\
        # Completion of arkmesh for bash, made from its --help.
        _arkmesh_words() {
          commands='' options='' takes=''
          case "$1" in
        CASES  esac
        }
        _arkmesh() {
          local word path='' commands options takes i
          local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}
          _arkmesh_words ''
          for ((i = 1; i < COMP_CWORD; i++)); do
            word=${COMP_WORDS[i]}
            if [[ -n $word && " $commands " == *" $word "* ]]; then
              path="${path:+$path }$word"
              _arkmesh_words "$path"
            fi
          done
          COMPREPLY=()
          if [[ $current == -* ]]; then
            mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")
          elif [[ -n $commands && $takes != *" $before "* ]]; then
            mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$current")
          fi
        }
        complete -o bashdefault -o default -F _arkmesh arkmesh
        """).replace("CASES", cases)


def zsh_word(text):
    return "'" + text.replace("'", "'\\''") + "'"


def zsh(whole):
    cases = ""
    for each in tree(whole):
        commands = " ".join(zsh_word(f"{command.words[-1]}:{command.purpose}") for command in each.subcommands)
        flags = " ".join(zsh_word(f"{name}:{meaning}") for names, meaning, _ in each.options() for name in names)
        cases += f"    '{' '.join(each.words)}') commands=({commands}) options=({flags}) ;;\n"
    return textwrap.dedent("""\
        #compdef arkmesh
        # Completion of arkmesh for zsh, made from its --help.
        _arkmesh_words() {
          commands=() options=()
          case "$1" in
        CASES  esac
        }
        _arkmesh() {
          local -a commands options
          local word place=''
          _arkmesh_words ''
          for word in "${(@)words[2,CURRENT-1]}"; do
            if [[ -n $word && -n ${commands[(r)${(b)word}:*]} ]]; then
              place="${place:+$place }$word"
              _arkmesh_words "$place"
            fi
          done
          if [[ $PREFIX == -* ]]; then
            _describe option options
          else
            { (( $#commands )) && _describe command commands } || _files
          fi
        }
        _arkmesh "$@"
        """).replace("CASES", cases)


def main():
    program, out = sys.argv[1], pathlib.Path(sys.argv[2])
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    whole = Help(program, [])

    def write(component, name, text):
        file = out / component / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    write("gateway", "man/man1/arkmesh.1", page("arkmesh", whole.purpose.rstrip("."), body_of(whole), version))
    for command in whole.subcommands:
        title = "arkmesh-" + command.words[0]
        body = body_of(command) + ".SH SEE ALSO\n.BR arkmesh (1)\n"
        write(COMPONENTS.get(title, "gateway"), f"man/man1/{title}.1", page(title, command.purpose, body, version))
    for title, (purpose, says, others) in PROGRAMS.items():
        body = f".SH DESCRIPTION\n{says}\n.SH SEE ALSO\n{roff(others)}\n"
        write(COMPONENTS[title], f"man/man1/{title}.1", page(title, purpose, body, version))
    write("gateway", "bash-completion/completions/arkmesh", bash(whole))
    write("gateway", "zsh/vendor-completions/_arkmesh", zsh(whole))


if __name__ == "__main__":
    main()
