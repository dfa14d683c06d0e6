"""What answers a lab for a scenario: in the scenario's own process (arkmesh_child.py), or in the caller's (running.py).
A message is its length (4 bytes), its kind (1 byte) and its content; numbers are little-endian. python_scenario.cpp is the
other end."""
import ast
import difflib
import hashlib
import importlib.util
import inspect
import json
import linecache
import os
import pathlib
import platform
import random
import re
import socket
import struct
import sys
import sysconfig
import textwrap
import traceback
import warnings

import numpy

from .lab_facade import HEARD, Lab
from .scenario import Scenario, check_every

HEAD, TIME, COUNT = struct.Struct("<IB"), struct.Struct("<qI"), struct.Struct("<I")
ENCODER = json.JSONEncoder(check_circular=False, separators=(",", ":"))
# What a robot's program, ARGoS and others call it.
OTHERS_WORDS = {"setup": "begin", "start": "begin", "init": "begin", "loop": "frame", "step": "frame", "update": "frame", "poses": "frame", "boundary": "period"}
U4, F8, U1, I8 = numpy.dtype("<u4"), numpy.dtype("<f8"), numpy.dtype("u1"), numpy.dtype("<i8")  # as every machine that arkmesh runs on has them
POSE = numpy.dtype([("x", "<f8"), ("y", "<f8"), ("heading", "<f8")])
NO_OBJECTS, NONE_HEARD, NOTHING = numpy.zeros(0, POSE), numpy.zeros(0, HEARD), bytes(COUNT.size)
PACKAGE = pathlib.Path(__file__).resolve().parent
# Whose code none of the user's is.
NOT_USERS = {PACKAGE, pathlib.Path(sysconfig.get_path("stdlib")), pathlib.Path(sysconfig.get_path("platstdlib"))}


class Wrong(Exception):
    """A sentence about the user's file."""


class Gone(Exception):
    """The lab has closed its end."""


class Line:
    """The end of a socket pair that a lab has the other end of."""

    def __init__(self, fileno):
        self.socket, self.kind = socket.socket(fileno=fileno), None  # of the message received last
        self.came = bytearray()  # and is not yet received: a lab whose time goes on may send two messages

    def computing(self, is_computing):
        """Called as the user's code begins to compute an answer, and as it ends."""

    def read(self, least):
        while len(self.came) < least:
            try:
                more = self.socket.recv(1 << 16)
            except ConnectionError:
                more = b""
            if not more:
                raise Gone
            self.came += more

    def receive(self):
        self.read(HEAD.size)
        size, kind = HEAD.unpack_from(self.came)
        end = HEAD.size + size
        if len(self.came) < end:
            self.read(end)
        self.kind, content = chr(kind), self.came[HEAD.size:end]
        del self.came[:end]
        self.computing(True)
        return self.kind, content

    def send(self, kind, content):
        self.computing(False)
        try:
            self.socket.sendall(HEAD.pack(len(content), ord(kind)) + content)
        except ConnectionError as error:
            raise Gone from error

    def ask_setting(self, setting):
        self.send("V", json.dumps(setting).encode())
        return json.loads(self.receive()[1])

    def answer(self, lab, more=None):
        words, said = lab._take()
        if more:
            said.update(more)
        self.send("A", COUNT.pack(len(words)) + words + (ENCODER.encode(said).encode() if said else b"") if words or said else NOTHING)

    def fail(self, sentence):
        self.send("E", sentence[:1000].encode())


class Reader:
    """Arrays lie in the message, which nobody else holds."""

    def __init__(self, data):
        self.data = data
        (self.now_us, self.period), self.at = TIME.unpack_from(data), TIME.size

    def count(self):
        value, = COUNT.unpack_from(self.data, self.at)
        self.at += COUNT.size
        return value

    def array(self, dtype, n):
        found = numpy.ndarray(n, dtype, self.data, self.at)
        self.at += n * dtype.itemsize
        return found if found.flags.aligned else found.copy()

    def robots(self):
        self.at += (COUNT.size - self.at) % 8  # so that numbers begin at a multiple of 8
        n, data = self.count(), self.data
        at = self.at
        self.at += 45 * n
        return {"ids": numpy.ndarray(n, U4, data, at + 40 * n), "xy": numpy.ndarray((n, 2), F8, data, at), "heading": numpy.ndarray(n, F8, data, at + 32 * n),
                "shared_xy": numpy.ndarray((n, 2), F8, data, at + 16 * n), "led": numpy.ndarray(n, U1, data, at + 44 * n)}

    def text(self):
        n = self.data[self.at]
        self.at += 1 + n
        return self.data[self.at - n:self.at].decode()


def see(lab, kind, content):
    """Shows a lab what a message of kind F (a frame) or P (a boundary) holds."""
    reader = Reader(content)
    if kind == "F":
        robots = reader.robots()
        objects = reader.array(POSE, count) if (count := reader.count()) else NO_OBJECTS
        heard = reader.array(HEARD, count) if (count := reader.count()) else NONE_HEARD
        n = len(robots["ids"])
        lab._see(reader.now_us, robots, objects, heard, [reader.array(F8, n * (columns := reader.count())).reshape(n, columns) for _ in lab._pieces])
        return
    states = []
    for name in lab.labs:
        robots = reader.robots()
        fields = {reader.text(): reader.array(I8, reader.count()) for _ in range(reader.count())}
        states.append((name, robots, fields))
    lab._merge(reader.now_us, reader.period, states, [reader.array(F8, reader.count()) for _ in lab._pieces])


def global_state(new=None, facts=None):
    """Of the global generators of `random` and numpy, which a scenario may use; then they are `new`, or seeded for a lab."""
    before = random.getstate(), numpy.random.get_state()
    if facts is not None:
        digest = hashlib.sha256(f"{facts['seed']}/{facts['name']}/global".encode()).digest()
        random.seed(digest)
        numpy.random.seed(numpy.frombuffer(digest, "<u4"))
    elif new is not None:
        random.setstate(new[0])
        numpy.random.set_state(new[1])
    return before


class Answers:
    """One lab's scenario, asked message by message. `make`, given what the lab tells of itself, makes the scenario and says
    which sources there are of it: {path: text}."""

    def __init__(self, line, make):
        self.line, self.make = line, make
        self.scenario = self.lab = None
        self.state = None  # of the global generators, while others use them (session.py)

    def take(self):
        """Receives a message, and answers it. What the user's code raises passes through."""
        kind, content = self.line.receive()
        if kind == "S":
            self.begin(json.loads(content))
            return
        see(self.lab, kind, content)
        if kind == "F":
            self.scenario.frame(self.lab)
            self.line.answer(self.lab)
        else:
            self.scenario.period(self.lab)
            self.line.answer(self.lab, {"finished": True} if self.scenario.finished(self.lab) else None)

    def begin(self, facts):
        global_state(facts=facts)
        self.scenario, sources = self.make(facts)
        check_names(type(self.scenario))
        self.lab = Lab(facts, self.line.ask_setting)
        self.scenario.begin(self.lab)
        self.lab._ask = None
        self.line.answer(self.lab, about(self.scenario.every, sources(), self.lab))


# What a seed does not decide: clocks, and generators that the system seeds.
UNSEEDED = re.compile(r"\b(\w+\.(?:time|monotonic|perf_counter|process_time|now|today|utcnow)(?:_ns)?(?=\()|from time import (?!sleep$).*|(?:os|secrets|uuid)\."
                      r"(?:urandom|getrandom|rand\w+|token\w+|choice|uuid[14])|from (?:secrets|uuid) import .*|SystemRandom"
                      r"|(?:default_rng|RandomState|SeedSequence|Random|seed|PCG64|PCG64DXSM|MT19937|Philox|SFC64)\(\))")


def unseeded_in(sources):
    """Sentences about these in a scenario's sources: the first place of each."""
    found = {}
    for file, text in sources.items():
        for number, line in enumerate(text.splitlines(), 1):
            for what in UNSEEDED.findall(line.partition("#")[0]):
                found.setdefault(what, f"{file}:{number}: {what} may differ between runs of one seed; use lab.now_s and lab.random(purpose)")
    return list(found.values())


def about(every, sources, lab):
    """What the answer to the first message tells of a scenario: `files` that it has read, and what of the kit labs must have alike."""
    return {"about": {"python": platform.python_version(), "numpy": numpy.__version__, "every": check_every(every), "sources": sources, "unseeded": unseeded_in(sources),
                      "files": {name: data.hex() for name, data in lab._files.items()}, "alike": lab._alike, "fingerprint": hashlib.sha256(json.dumps(sources).encode()).hexdigest()[:16]}}


# --- the user's file or class ---
def load(file):
    """A scenario of the class that a file holds."""
    if not file.is_file():
        raise Wrong(f"there is no file {file}; run.scenario is a path from the lab's file (runs of a Loop, and of a scenario typed at a prompt, keep no file)")
    sys.path.insert(0, str(file.parent))
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[file.stem] = module
    warnings.filterwarnings("default", category=DeprecationWarning, module=re.escape(file.stem))
    spec.loader.exec_module(module)
    found = [c for c in vars(module).values() if isinstance(c, type) and issubclass(c, Scenario) and c.__module__ == file.stem]
    if len(found) != 1:
        names = " and ".join(c.__name__ for c in found)
        raise Wrong(f"{file.name}:{inspect.getsourcelines(found[1])[1]}: it holds {len(found)} scenarios, {names}; keep one per file"
                    if found else f"{file.name}:1: it holds no scenario; write a class that derives from arkmesh.Scenario")
    return found[0]()


def check_names(cls):
    """Refuses what is called nearly as a part of the interface, and what none of the user's functions names: `frames`, `on_period`, `evry`."""
    members = {name: value for c in reversed(cls.__mro__) if c not in Scenario.__mro__ for name, value in vars(c).items() if not name.startswith("_")}
    parts = [name for name in vars(Scenario) if not name.startswith("_")]
    codes = [value.__code__ for value in members.values() if inspect.isfunction(value)]
    for code in codes:  # grows by what is defined within
        codes.extend(c for c in code.co_consts if inspect.iscode(c))
    used = {name for code in codes for name in (*code.co_names, *code.co_consts) if isinstance(name, str)}
    for name in members.keys() - used - set(parts):
        near = OTHERS_WORDS.get(name) or "".join(difflib.get_close_matches(re.sub("^(on|do|at|each|handle)_", "", name.lower()), parts, 1, 0.75))
        if near:
            code = getattr(members[name], "__code__", None)
            place = f"{shown_name(code.co_filename)}:{code.co_firstlineno}: " if code else ""
            raise Wrong(f"{place}{cls.__name__}.{name} is never used; did you mean {near}? A scenario has {', '.join(parts)}")


def sources_of_file(file):
    """{path below the scenario's folder: text} of it and of the modules there that have been imported."""
    found = {file.name: file}
    for module in list(sys.modules.values()):
        name = getattr(module, "__file__", None)
        if name and name.endswith(".py") and is_users(os.path.abspath(name)) and file.parent in pathlib.Path(os.path.abspath(name)).parents:
            path = pathlib.Path(os.path.abspath(name))
            found[path.relative_to(file.parent).as_posix()] = path
    return {name: path.read_text() for name, path in sorted(found.items())}


def name_of_class(cls):
    """That of its file without .py; in a notebook, or in the script that runs, LightUp is light_up."""
    if cls.__module__ != "__main__":
        return cls.__module__.rpartition(".")[2]
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", cls.__name__).lower()


def source_of(thing):
    """The text of a function or class, also of a notebook's cell, where inspect finds no classes. Raises OSError."""
    methods = [f.__code__ for f in vars(thing).values() if inspect.isfunction(f)] if inspect.isclass(thing) else []
    for code in methods:
        lines = linecache.getlines(code.co_filename)
        for node in ast.walk(ast.parse("".join(lines))):
            if isinstance(node, ast.ClassDef) and node.name == thing.__name__ and node.lineno <= code.co_firstlineno <= node.end_lineno:
                first = min([node.lineno, *(d.lineno for d in node.decorator_list)])
                return textwrap.dedent("".join(lines[first - 1:node.end_lineno]))
    return textwrap.dedent(inspect.getsource(thing))


def file_of(cls):
    try:
        return pathlib.Path(inspect.getfile(cls))
    except TypeError:  # its module was loaded by importlib, and has no place in sys.modules
        return next((pathlib.Path(f.__code__.co_filename) for f in vars(cls).values() if inspect.isfunction(f)), pathlib.Path())


def sources_of_class(cls):
    """Of its file; in a notebook or script its own source, and that of what it names there, as far as there is one."""
    name = name_of_class(cls)
    if cls.__module__ != "__main__":
        file = file_of(cls)
        return sources_of_file(file) if file.suffix == ".py" else {}
    around = vars(sys.modules["__main__"])
    parts, seen = [], {}

    def add(thing):
        text = source_of(thing)
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Name) and node.id in around and node.id not in seen:
                seen[node.id] = around[node.id]
                define(node.id, around[node.id])
        parts.append(text)

    def define(as_name, value):
        home = getattr(value, "__module__", None)
        if inspect.ismodule(value):
            parts.append(f"import {value.__name__} as {as_name}\n")
        elif (inspect.isclass(value) or inspect.isroutine(value)) and home == "__main__":
            if value is not cls:
                add(value)
        elif inspect.isclass(value) or inspect.isroutine(value):
            parts.append(f"from {home} import {value.__qualname__} as {as_name}\n")
        elif isinstance(value, (bool, int, float, str, tuple, list, dict)):
            parts.append(f"{as_name} = {value!r}\n")

    try:
        add(cls)
    except (OSError, TypeError, SyntaxError):  # typed at a prompt: nobody has it
        return {}
    return {name + ".py": "\n".join(parts)}


# --- what goes wrong in the user's code ---
def is_users(filename):
    path = pathlib.Path(filename)
    return not (filename.startswith("<frozen") or {"site-packages", "dist-packages"} & set(path.parts) or NOT_USERS & set(path.parents)
                or path == PACKAGE.parent / "arkmesh_child.py")


def shown_name(filename):
    """A file's name, or `In[5]` of a cell of a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    cell = getattr(getattr(shell, "compile", None), "_filename_map", {}).get(filename)
    return pathlib.Path(filename).name if cell is None else f"In[{cell}]"


def place_of(error):
    """`light_up.py:12: ` of the user's line that a traceback ends in, if there is one."""
    if isinstance(error, SyntaxError) and error.filename:
        return f"{shown_name(error.filename)}:{error.lineno}: "
    inside = [f for f in traceback.extract_tb(error.__traceback__) if is_users(f.filename)]
    return f"{shown_name(inside[-1].filename)}:{inside[-1].lineno}: " if inside else ""


def sentence_of(error, name):
    """One line about what the user's code has raised; `name`: whose, when no line of it is at fault."""
    if isinstance(error, Wrong):
        return str(error)
    words = "".join(c if c.isprintable() else "?" for c in " ".join(str(error).split()))  # a terminal would obey some
    return f"{place_of(error) or name + ': '}{type(error).__name__}: {words}"
