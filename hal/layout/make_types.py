#!/usr/bin/python3
"""Writes what lcmtypes/*.lcm say as one JSON object: types with their fields, fingerprints and comments, and which channel carries which.

    hal/layout/make_types.py lcmtypes build/types.json [build/types_json.cpp]
    hal/layout/make_types.py --former lcmtypes build/former      the definitions of each former step, for lcm-gen
    hal/layout/make_types.py --check lcmtypes                    whether the former definitions of all changed types are kept

{"types": {"pose_frame_t": {"fingerprint": "0123456789abcdef", "comment": "...", "fields": [{"name", "type", "dims", "comment"}],
"constants": {"run": 0}}}, "channels": {"poses": "pose_frame_t"}}. A dimension is the name of an earlier field, or a number. Of channels of other labs,
as `shark/world`, the part behind the last `/` counts. The build runs it; C++, the page in the browser, exports and Python read its outcome.
It takes the part of LCM's language that our types use, and says where a file is beyond that.

lcmtypes/former/N/ keeps the definitions that step N has changed, as they were before it; what is not there was as in step N + 1, and after the last
step as today. Each type that had another fingerprint then is told as NAME-N: also one that only holds a type which was changed.
"""
import json
import pathlib
import re
import sys

PRIMITIVES = {"int8_t", "int16_t", "int32_t", "int64_t", "float", "double", "string", "boolean", "byte"}
FIELD = re.compile(r"(\w+)\s+(\w+)((?:\[\w+\])*);")
SOURCE = """// Made by hal/layout/make_types.py.
#include "hal/layout/types.hpp"

namespace arkmesh::hal::layout {

std::string_view types_json() {
  return R"json(%s)json";
}

}  // namespace arkmesh::hal::layout
"""
CHANNEL = re.compile(r"Channel `(\w+)`")


def fail(file, line, sentence):
    sys.exit(f"make_types: {file}:{line}: {sentence}")


def signed(value):
    value &= (1 << 64) - 1
    return value - (1 << 64) if value >> 63 else value


def stir(value, number):
    """LCM's hash_update: on signed 64 bits, the right shift arithmetic."""
    return signed((value << 8 ^ value >> 55) + number)


def stir_text(value, text):
    value = stir(value, len(text))
    for letter in text.encode():
        value = stir(value, letter - 256 if letter > 127 else letter)
    return value


def parse(file):
    """One struct of one file: (name, comment, fields, constants)."""
    name, about, fields, constants, above = None, "", [], {}, []
    for number, line in enumerate(file.read_text().splitlines(), 1):
        code, _, comment = line.partition("//")
        code, comment = code.strip(), comment.strip()
        if not code:
            if comment and fields and not above:
                fields[-1]["comment"] = (fields[-1]["comment"] + " " + comment).strip()
            elif comment:
                above.append(comment)
            continue
        if code in ("{", "}", "package arkmesh;"):
            above = []
        elif start := re.fullmatch(r"struct (\w+)", code):
            if name:
                fail(file, number, "a file holds one struct")
            name, about, above = start[1], " ".join(above), []
        elif constant := re.fullmatch(r"const \w+ (.+);", code):
            for part in constant[1].split(","):
                key, _, value = part.partition("=")
                constants[key.strip()] = int(value.strip(), 0)
            above = []
        elif field := FIELD.fullmatch(code):
            dims = [int(d) if d.isdigit() else d for d in re.findall(r"\w+", field[3])]
            known = {f["name"] for f in fields if f["type"].startswith("int") and not f["dims"]}
            for dim in dims:
                if isinstance(dim, str) and dim not in known:
                    fail(file, number, f"the size {dim} is no whole-number field above it")
            fields.append({"name": field[2], "type": field[1], "dims": dims, "comment": " ".join(above + [comment]).strip()})
            above = []
        else:
            fail(file, number, f"this line is not understood: {code}")
    if name != file.stem:
        fail(file, 1, f"the struct of this file must be called {file.stem}")
    return name, about, fields, constants


def own_hash(fields):
    value = 0x12345678
    for field in fields:
        value = stir_text(value, field["name"])
        if field["type"] in PRIMITIVES:
            value = stir_text(value, field["type"])
        value = stir(value, len(field["dims"]))
        for dim in field["dims"]:
            value = stir_text(stir(value, 1 if isinstance(dim, str) else 0), str(dim))
    return value


def fingerprint(types, name, parents=()):
    """As generated code computes it: its own hash and those of its members' types, turned by one bit."""
    if name not in types:
        sys.exit(f"make_types: {parents[-1]}.lcm: there is no type {name}")
    if name in parents:
        sys.exit(f"make_types: {name}.lcm: a type must not contain itself")
    value = own_hash(types[name]["fields"])
    for field in types[name]["fields"]:
        if field["type"] not in PRIMITIVES:
            value += fingerprint(types, field["type"], (*parents, name))
    value &= (1 << 64) - 1
    return (value << 1 | value >> 63) & ((1 << 64) - 1)


def definitions(files):
    types = {}
    for file in files.values():
        name, about, fields, constants = parse(file)
        types[name] = {"comment": about, "fields": fields} | ({"constants": constants} if constants else {})
    return types


def steps(folder):
    """[(N, {name: file})], the newest step first: the definitions before step N. The last is those of today, with None as N."""
    files = {file.stem: file for file in sorted(folder.glob("*.lcm"))}
    numbers = [int(each.name) for each in folder.glob("former/*") if each.name.isdigit()]
    out = [(None, dict(files))]
    for number in sorted(numbers, reverse=True):
        files.update({file.stem: file for file in sorted(folder.glob(f"former/{number}/*.lcm"))})
        out.append((number, dict(files)))
    return out


def tables(folder):
    """{name: type}, today's first, then former ones as NAME-N; each with the fingerprint as text."""
    out, known = {}, {}
    for number, files in steps(folder):
        types = definitions(files)
        prints = {name: f"{fingerprint(types, name):016x}" for name in types}
        new = [name for name in types if (name, prints[name]) not in known]
        for name in new:
            known[name, prints[name]] = name if number is None else f"{name}-{number}"
        for name in new:
            fields = [field | {"type": known.get((field["type"], prints.get(field["type"])), field["type"])} for field in types[name]["fields"]]
            out[known[name, prints[name]]] = {"fingerprint": prints[name]} | types[name] | {"fields": fields}
    return out


def write_former(folder, out):
    """OUT/arkmesh_former_N/*.lcm of each step, in a package of that name, so that generated code of all of them can be loaded."""
    for number, files in steps(folder)[1:]:
        package = out / f"arkmesh_former_{number}"
        package.mkdir(parents=True, exist_ok=True)
        for name, file in files.items():
            (package / f"{name}.lcm").write_text(file.read_text().replace("package arkmesh;", f"package {package.name};"))


def missing(folder):
    """What to do, a sentence for each layout that FOLDER/fingerprints.txt lists and no definition has, and for each that it does not list."""
    listed = [tuple(line.split()) for line in (folder / "fingerprints.txt").read_text().splitlines() if not line.startswith("#")]
    known = {(name.partition("-")[0], each["fingerprint"]): name for name, each in tables(folder).items()}
    number = len(steps(folder))
    out = []
    for name, print_ in listed:
        if (name, print_) not in known:
            out.append(f"no definition has the layout {print_} of {name} any more, so its recorded messages cannot be read: keep the former file as "
                       f"{folder.name}/former/{number}/{name}.lcm (git show HEAD:{folder.name}/{name}.lcm prints it)")
    out += [f"the layout {print_} of {name} is new: add the line \"{name} {print_}\" to {folder.name}/fingerprints.txt, and leave those that are there"
            for name, print_ in known if (name, print_) not in listed and "-" not in known[name, print_]]
    return out


def main():
    arguments = [argument for argument in sys.argv[1:] if not argument.startswith("--")]
    option = next((argument for argument in sys.argv[1:] if argument.startswith("--")), None)
    if len(arguments) not in {None: (2, 3), "--former": (2,), "--check": (1,)}.get(option, ()):
        sys.exit(__doc__.strip())
    folder = pathlib.Path(arguments[0])
    if option == "--check":
        sys.exit("\n".join(f"make_types: {sentence}" for sentence in missing(folder)) or 0)
    if option == "--former":
        return write_former(folder, pathlib.Path(arguments[1]))
    types = tables(folder)
    channels = {channel[1]: name for name, each in types.items() if "-" not in name and (channel := CHANNEL.search(each["comment"]))}
    text = json.dumps({"types": types, "channels": channels}, separators=(",", ":"))
    pathlib.Path(arguments[1]).write_text(text + "\n")
    if len(arguments) == 3:
        pathlib.Path(arguments[2]).write_text(SOURCE % text)


if __name__ == "__main__":
    main()
