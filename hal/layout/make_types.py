#!/usr/bin/python3
"""Writes what lcmtypes/*.lcm say as one JSON object: types with their fields, fingerprints and comments, and which channel carries which.

    hal/layout/make_types.py lcmtypes build/types.json [build/types_json.cpp]

{"types": {"pose_frame_t": {"fingerprint": "0123456789abcdef", "comment": "...", "fields": [{"name", "type", "dims", "comment"}],
"constants": {"run": 0}}}, "channels": {"poses": "pose_frame_t"}}. A dimension is the name of an earlier field, or a number. Of channels of other labs,
as `shark/world`, the part behind the last `/` counts. The build runs it; C++, the page in the browser, exports and Python read its outcome.
It takes the part of LCM's language that our types use, and says where a file is beyond that.
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
            fail(file, number, f"cannot parse this line: {code}")
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


def tables(folder):
    """{name: type}, each with its fingerprint as text."""
    types = {}
    for file in sorted(folder.glob("*.lcm")):
        name, about, fields, constants = parse(file)
        types[name] = {"comment": about, "fields": fields} | ({"constants": constants} if constants else {})
    return {name: {"fingerprint": f"{fingerprint(types, name):016x}"} | each for name, each in types.items()}


def main():
    arguments = sys.argv[1:]
    if len(arguments) not in (2, 3):
        sys.exit(__doc__.strip())
    types = tables(pathlib.Path(arguments[0]))
    channels = {channel[1]: name for name, each in types.items() if (channel := CHANNEL.search(each["comment"]))}
    text = json.dumps({"types": types, "channels": channels}, separators=(",", ":"))
    pathlib.Path(arguments[1]).write_text(text + "\n")
    if len(arguments) == 3:
        pathlib.Path(arguments[2]).write_text(SOURCE % text)


if __name__ == "__main__":
    main()
