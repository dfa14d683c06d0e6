"""The process of a scenario in Python. A lab starts it with one end of a socket pair as descriptor 3, and asks; it answers.
A message is its length (4 bytes), its kind (1 byte) and its content; numbers are little-endian. python_scenario.cpp is the
other end."""
import faulthandler
import hashlib
import importlib.util
import json
import os
import pathlib
import platform
import signal
import socket
import struct
import sys
import traceback

HEAD = struct.Struct("<IB")


class Wrong(Exception):
    """A sentence about the user's file."""


class Line:
    """The socket pair's end."""

    def __init__(self):
        self.socket = socket.socket(fileno=3)

    def read(self, n):
        data = bytearray(n)
        view, at = memoryview(data), 0
        while at < n:
            got = self.socket.recv_into(view[at:])
            if got == 0:
                os._exit(0)  # the lab is gone
            at += got
        return data

    def receive(self):
        size, kind = HEAD.unpack(self.read(HEAD.size))
        return chr(kind), self.read(size)

    def send(self, kind, content):
        self.socket.sendall(HEAD.pack(len(content), ord(kind)) + content)

    def ask_setting(self, setting):
        self.send("V", json.dumps(setting).encode())
        return json.loads(self.receive()[1])


class Reader:
    def __init__(self, numpy, data):
        self.numpy, self.data, self.at = numpy, data, 0

    def number(self, form):
        value = struct.unpack_from("<" + form, self.data, self.at)[0]
        self.at += struct.calcsize("<" + form)
        return value

    def array(self, dtype, n):
        found = self.numpy.frombuffer(self.data, dtype, n, self.at).astype(self.numpy.dtype(dtype).newbyteorder("="))
        self.at += found.nbytes
        return found

    def robots(self):
        n = self.number("I")
        ids = self.array("<u4", n)
        xy, heading = self.array("<f8", 2 * n).reshape(n, 2), self.array("<f8", n)
        return {"ids": ids, "xy": xy, "heading": heading, "shared_xy": self.array("<f8", 2 * n).reshape(n, 2),
                "led": self.array("u1", n)}

    def text(self):
        n = self.number("B")
        self.at += n
        return self.data[self.at - n:self.at].decode()


def place_of(error, file):
    """`light_up.py:12: ` for what the user's folder holds of the traceback; the innermost line counts."""
    if isinstance(error, SyntaxError) and error.filename:
        return f"{pathlib.Path(error.filename).name}:{error.lineno}: "
    inside = [f for f in traceback.extract_tb(error.__traceback__) if is_users(f.filename, file.parent)]
    return f"{pathlib.Path(inside[-1].filename).name}:{inside[-1].lineno}: " if inside else f"{file.name}: "


def is_users(filename, folder):
    path = pathlib.Path(filename)
    return folder in path.parents and "site-packages" not in path.parts and pathlib.Path(__file__).parent not in path.parents


def load(arkmesh, file):
    if not file.is_file():
        raise Wrong(f"there is no file {file}; run.scenario is looked up beside the lab's file")
    sys.path.insert(0, str(file.parent))
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[file.stem] = module
    spec.loader.exec_module(module)
    found = [c for c in vars(module).values()
             if isinstance(c, type) and issubclass(c, arkmesh.Scenario) and c.__module__ == file.stem]
    if len(found) != 1:
        names = " and ".join(c.__name__ for c in found)
        raise Wrong(f"{file.name}:{line_of(found[1])}: it holds {len(found)} scenarios, {names}; keep one in a file" if found else
                    f"{file.name}:1: it holds no scenario; write a class that derives from arkmesh.Scenario")
    return found[0]()


def line_of(found):
    import inspect
    return inspect.getsourcelines(found)[1]


def sources(file):
    """{path below the scenario's folder: text} of it and of the modules there that it has imported."""
    found = {file.name: file}
    for module in list(sys.modules.values()):
        name = getattr(module, "__file__", None)
        if name and name.endswith(".py") and is_users(os.path.abspath(name), file.parent):
            path = pathlib.Path(os.path.abspath(name))
            found[path.relative_to(file.parent).as_posix()] = path
    return {name: path.read_text() for name, path in sorted(found.items())}


def begin(arkmesh, numpy, line, facts, file):
    scenario = load(arkmesh, file)
    lab = arkmesh.Lab(facts, line.ask_setting)
    scenario.begin(lab)
    lab._ask = None
    every = scenario.every
    if not isinstance(every, int) or isinstance(every, bool) or not 1 <= every <= 1_000_000:
        raise Wrong(f"{file.name}: `every` is a whole number from 1, and not {every!r}")
    kept = sources(file)
    about = {"python": platform.python_version(), "numpy": numpy.__version__, "every": every, "sources": kept,
             "fingerprint": hashlib.sha256(json.dumps(kept).encode()).hexdigest()[:16]}
    return scenario, lab, about


def answer(line, lab, more=None):
    words, said = lab._take()
    said.update(more or {})
    line.send("A", struct.pack("<I", len(words)) + words + (json.dumps(said).encode() if said else b""))


def serve(line, state):
    kind, content = line.receive()
    facts = json.loads(content)
    state["file"] = file = pathlib.Path(facts["file"])
    try:
        import numpy
    except ImportError as error:
        raise Wrong(f"numpy cannot be imported by {sys.executable}: {error}; install it (python3-numpy), or name another "
                    "Python in the environment, as ARKMESH_PYTHON") from error
    import arkmesh
    scenario, lab, about = begin(arkmesh, numpy, line, facts, file)
    answer(line, lab, {"about": about})
    while True:
        kind, content = line.receive()
        reader = Reader(numpy, content)
        now_us, number = reader.number("q"), reader.number("I")
        if kind == "F":
            lab._see(now_us, reader.robots())
            scenario.frame(lab)
            answer(line, lab)
            continue
        states = []
        for name in lab.labs:
            robots = reader.robots()
            fields = {reader.text(): reader.array("<i8", reader.number("I")) for _ in range(reader.number("I"))}
            states.append((name, robots, fields))
        lab._merge(now_us, number, states)
        scenario.period(lab)
        answer(line, lab, {"finished": True} if scenario.finished(lab) else None)


def main():
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the lab ends it
    faulthandler.register(signal.SIGUSR1, all_threads=False)  # where it hangs
    line, state = Line(), {"file": pathlib.Path("the scenario")}
    try:
        serve(line, state)
    except BaseException as error:  # also what the user's file raises to exit
        where = "" if isinstance(error, Wrong) else place_of(error, state["file"])
        what = str(error) if isinstance(error, Wrong) else f"{type(error).__name__}: {error}"
        if not isinstance(error, Wrong):
            traceback.print_exc()
        sys.stderr.flush()
        sys.stdout.flush()
        line.send("E", (where + " ".join(what.split()))[:1000].encode())
        os._exit(1)


main()
