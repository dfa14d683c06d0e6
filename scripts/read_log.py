#!/usr/bin/python3
"""Reads an LCM event log, also one that is cut or damaged, and decodes our messages.

    scripts/read_log.py runs/demo/shark/log.lcm            channels, how many messages each, first and last time
    scripts/read_log.py runs/demo/shark/log.lcm poses      every message of one channel, decoded

log.lcm.zst, as recorder.compress makes it, is read as well, by the program zstd.

From another program: `for seconds, channel, data in events(log)`, then `decode(data)`. Debian has no LCM for Python, so the
file is read directly; the message types are the Python code that scripts/build generates.
"""
import contextlib
import importlib
import mmap
import os
import pathlib
import pkgutil
import struct
import subprocess
import sys
import tempfile

SYNC, SYNC_BYTES = 0xEDA1DA01, bytes.fromhex("eda1da01")
ZSTD_MAGIC = bytes.fromhex("28b52ffd")
MAX_CHANNEL, MAX_DATA = 255, 64 << 20
HERE = pathlib.Path(__file__).resolve().parent
# As installed, as the caller says, or as scripts/build makes them.
TYPES_DIR = next((folder for folder in (pathlib.Path(os.environ.get("ARKMESH_LCM_TYPES", "")), HERE / "lcmtypes") if folder.joinpath("arkmesh").is_dir()),
                 HERE.parent / "build/release/lcmtypes/python")


def log_in(folder):
    """The log in a lab's folder: log.lcm, or log.lcm.zst where only that is there. There may be none."""
    plain, packed = (pathlib.Path(folder) / name for name in ("log.lcm", "log.lcm.zst"))
    return packed if packed.is_file() and not plain.exists() else plain


@contextlib.contextmanager
def opened(path):
    """The bytes of a log, unpacked, and whether they are all there."""
    with open(path, "rb") as log, tempfile.TemporaryFile() as unpacked:
        whole = True
        if log.peek(4)[:4] == ZSTD_MAGIC:
            os.lseek(log.fileno(), 0, os.SEEK_SET)
            try:
                whole = subprocess.run(["zstd", "-dcq"], stdin=log, stdout=unpacked, stderr=subprocess.DEVNULL).returncode == 0
            except FileNotFoundError:
                raise SystemExit(f"{path} is compressed, and the program zstd that unpacks it is missing; apt-get install zstd") from None
            log = unpacked
        if os.fstat(log.fileno()).st_size == 0:
            yield b"", whole
            return
        with mmap.mmap(log.fileno(), 0, access=mmap.ACCESS_READ) as data:
            yield data, whole


def size_of(data, at):
    """Of the event that begins there, with its header; 0: there is none, or it is cut."""
    if at + 28 > len(data):
        return 0
    sync, _number, _utime, channel_length, length = struct.unpack_from(">IqqII", data, at)
    size = 28 + channel_length + length
    return size if sync == SYNC and 1 <= channel_length <= MAX_CHANNEL and length <= MAX_DATA and at + size <= len(data) else 0


def next_event(data, begin, end):
    """The first place of these where a whole event begins that another one, or the end, follows; None: there is none."""
    while (begin := data.find(SYNC_BYTES, begin, end)) >= 0:
        size = size_of(data, begin)
        if size and is_end(data, begin + size):
            return begin
        begin += 1
    return None


def is_end(data, at):
    return SYNC_BYTES.startswith(data[at:at + 4])  # nothing, or the beginning of an event


def events(path):
    """Every whole event as (seconds since 1970, channel, bytes). What is damaged is passed over, and said on the standard error, as what is cut."""
    with opened(path) as (data, whole):
        if not is_end(data, 0) and next_event(data, 0, len(data)) is None:
            raise SystemExit(f"{path} is not an LCM log.")
        at = skipped = places = 0
        while at < len(data):
            size = size_of(data, at)
            if not size or not is_end(data, at + size):
                found = next_event(data, at + 1, at + size if size else len(data))
                if found is not None:
                    skipped, places, at, size = skipped + found - at, places + 1, found, size_of(data, found)
            if not size:
                break
            _, _, utime, channel_length, _ = struct.unpack_from(">IqqII", data, at)
            name = at + 28 + channel_length
            yield utime / 1e6, data[at + 28:name].decode("ascii", "replace"), data[name:at + size]
            at += size
        if skipped or at < len(data) or not whole:
            left_out = [f"{skipped} bytes at {places} place{'s' * (places > 1)}"] * bool(skipped) + [f"its last {len(data) - at} bytes"] * (at < len(data))
            print(f"{path} is cut or damaged: {' and '.join(left_out + ['what zstd does not unpack'] * (not whole))} left out", file=sys.stderr)


def types():
    """Our message classes by fingerprint, the 8 bytes that every message begins with."""
    if not types.known:
        if not TYPES_DIR.is_dir():
            raise SystemExit(f"The message types are not in {TYPES_DIR}: run scripts/build first.")
        sys.path.insert(0, str(TYPES_DIR))
        package, folder = importlib.import_module("arkmesh"), str(TYPES_DIR / "arkmesh")
        if folder not in package.__path__:  # the package arkmesh of scenarios is loaded, which has the same name
            package.__path__.append(folder)
        classes = [getattr(importlib.import_module(f"arkmesh.{module.name}"), module.name) for module in pkgutil.iter_modules([folder])]
        for cls in classes:
            setattr(package, cls.__name__, cls)  # as their own package does, for they look each other up there
        types.known = {cls._get_packed_fingerprint(): cls for cls in classes}
    return types.known


types.known = {}


def decode(data):
    """The message in these bytes, or None when it is none of ours."""
    cls = types().get(data[:8])
    return cls.decode(data) if cls else None


def new(type_name, **values):
    """A message of ours by the name of its type, with these fields; counts of arrays follow from the arrays."""
    cls = next(cls for cls in types().values() if cls.__name__ == type_name)
    message = cls()
    for name, value in values.items():
        setattr(message, name, value)
        if isinstance(value, (list, bytes)) and hasattr(message, "n_" + name):
            setattr(message, "n_" + name, len(value))
    return message


def text(message, indent=""):
    """A message as indented lines, nested ones too."""
    lines = []
    for name in message.__slots__:
        value = getattr(message, name)
        if isinstance(value, list) and value and hasattr(value[0], "__slots__"):
            for i, item in enumerate(value):
                lines += [f"{indent}{name}[{i}]"] + text(item, indent + "  ")
        else:
            lines.append(f"{indent}{name} = {value}")
    return lines


def main(arguments):
    if not 1 <= len(arguments) <= 2 or arguments[0].startswith("-"):
        raise SystemExit(__doc__.strip())
    log, wanted = arguments[0], arguments[1] if len(arguments) > 1 else None
    if not os.path.isfile(log):
        raise SystemExit(f"{log} is not a file; a run folder holds log.lcm in each lab's folder.")
    seen = {}
    for seconds, channel, data in events(log):
        first, _, count, size = seen.get(channel, (seconds, 0, 0, 0))
        seen[channel] = (first, seconds, count + 1, size + len(data))
        if channel == wanted:
            message = decode(data)
            print(f"--- {seconds:.6f} {channel}")
            print("\n".join(text(message)) if message else f"{len(data)} bytes of an unknown type")
    if wanted is None:
        print(f"{'channel':<24}{'messages':>10}{'bytes':>12}{'seconds':>10}")
        for channel, (first, last, count, size) in sorted(seen.items()):
            print(f"{channel:<24}{count:>10}{size:>12}{last - first:>10.1f}")
    elif wanted not in seen:
        raise SystemExit(f"No channel {wanted} in {log}; it holds: {', '.join(sorted(seen)) or 'no whole message'}.")


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except BrokenPipeError:  # the reader, such as `head`, has had enough
        os._exit(0)
