"""Runs from a script or notebook. The labs run as `arkmesh run`, a child process; where the scenario is a class of the
caller's, or a loop, the labs' scenario processes hand their lines over to this one (arkmesh_child.py), which answers."""
from __future__ import annotations

import collections
import contextlib
import datetime
import itertools
import json
import operator
import os
import pathlib
import selectors
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import traceback
from typing import Any, Iterable, Mapping, Optional, Type, Union

from . import answering
from .recorded import Batch, Run
from .scenario import Lab, Scenario

KEPT_OUTPUT = 64 << 10
# Ctrl-C is for this process, which passes it on; when this one dies, that one is told to stop (PR_SET_PDEATHSIG). The kernel tells it
# once for each thread of this process, and a second SIGTERM would end it without a result; a second SIGUSR1 does not.
STARTER = ("import ctypes, os, signal, sys\nctypes.CDLL(None).prctl(1, int(signal.SIGUSR1))\n"
           "os.getppid() == int(sys.argv[1]) or sys.exit(1)\nos.execv(sys.argv[2], sys.argv[2:])")


class Failed(RuntimeError):
    """A run that has failed, in one sentence. `folder` is the run's, with its result.json if it had begun."""

    def __init__(self, sentence, folder):
        super().__init__(sentence)
        self.folder = folder


def program():
    """`arkmesh` of the installation, or of the checkout's build, that this package belongs to; else that of PATH."""
    python = answering.PACKAGE.parent
    for place in (python.parents[2] / "bin/arkmesh", python.parents[1] / "build/release/arkmesh"):
        if place.is_file():
            return str(place)
    found = shutil.which("arkmesh")
    if not found:
        raise FileNotFoundError(f"there is no program arkmesh beside {python}, nor in PATH; scripts/build builds it, and the package arkmesh has it")
    return found


def call(*arguments):
    """Runs the program to its end; what it refuses is raised as its sentence."""
    done = subprocess.run([program(), *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    if done.returncode != 0:
        raise RuntimeError(last_sentence(done.stdout))


def last_sentence(said):
    lines = [line for line in said.splitlines() if line.startswith("arkmesh: ")] or said.splitlines()[-1:] or ["arkmesh ended"]
    return lines[-1].rpartition("arkmesh: ")[2]


class Line(answering.Line):
    def __init__(self, fileno, session):
        super().__init__(fileno)
        self.session = session

    def computing(self, is_computing):
        with self.session.lock:
            self.session.busy = self if is_computing else None

    def answer_nothing(self):
        if self.kind == "S":
            self.fail("it was stopped")
        else:
            self.send("A", bytes(4))


class Session:
    """`arkmesh run`, whose labs ask this process. Closed, none of it is left."""

    def __init__(self, arguments, answers_here, shows=False):
        self.shows = shows  # whether what it prints is shown at once, too
        self.waiting, self.said, self.lines = selectors.DefaultSelector(), b"", collections.deque()
        self.controls, self.busy, self.gave_up, self.lock = {}, None, "", threading.Lock()
        self.thread = threading.current_thread()
        environment = {"ARKMESH_PYTHON": sys.executable, **os.environ}
        self.place = None
        if answers_here:
            # A socket's path has little room.
            root = tempfile.gettempdir()
            self.place = tempfile.mkdtemp(prefix="arkmesh-", dir=root if len(root) < 70 else "/tmp")
            self.listener = socket.socket(socket.AF_UNIX)
            self.listener.bind(self.place + "/answers")
            self.listener.listen(256)
            self.waiting.register(self.listener, selectors.EVENT_READ, self.accept)
            environment["ARKMESH_ANSWERS"] = self.place + "/answers"
        self.process = subprocess.Popen([sys.executable, "-IS", "-c", STARTER, str(os.getpid()), program(), *arguments], env=environment,
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
        self.waiting.register(self.process.stdout, selectors.EVENT_READ, self.listen)

    def accept(self):
        control, _ = self.listener.accept()
        _, lines, _, _ = socket.recv_fds(control, 1, 1, socket.MSG_CMSG_CLOEXEC)
        if not lines:
            control.close()
            return
        line = Line(lines[0], self)
        self.controls[line] = control
        threading.Thread(target=self.watch, args=(line, control), daemon=True).start()
        self.waiting.register(line.socket, selectors.EVENT_READ, lambda: self.lines.append(line))

    def listen(self):
        more = os.read(self.process.stdout.fileno(), 1 << 16)
        self.said = (self.said + more)[-KEPT_OUTPUT:]
        if self.shows:
            sys.stderr.write(more.decode(errors="replace"))
        if not more:
            self.waiting.unregister(self.process.stdout)

    def watch(self, line, control):
        """Says where this process hangs, when the lab asks; ends what hangs, when the lab has gone."""
        while True:
            try:
                asked = control.recv(1)
            except OSError:
                asked = b""
            with self.lock:
                if self.busy is line:
                    self.give_up(control if asked else None)
            if not asked:
                return

    def give_up(self, control):
        """Interrupts the user's code, which nobody waits for any more; `control`: who asks where it is."""
        frames = traceback.extract_stack(sys._current_frames()[self.thread.ident])
        where = [f"{answering.shown_name(f.filename)}:{f.lineno}" for f in frames if answering.is_users(f.filename)][-1:] or ["the scenario"]
        self.gave_up = f"{where[0]}: no answer in time (scenario.answer_s)"
        if control:
            with contextlib.suppress(OSError):
                control.sendall(f"hangs at {where[0]} in this process\n".encode())
        if self.thread is threading.main_thread():
            signal.pthread_kill(self.thread.ident, signal.SIGINT)

    def next(self):
        """The line of a lab that asks; None when all have ended."""
        while not self.lines:
            if self.process.stdout not in self.waiting.get_map():
                self.process.wait()
                return None
            for key, _ in self.waiting.select():
                key.data()
        return self.lines.popleft()

    def drop(self, line):
        """A line is not answered any more."""
        if line in self.controls:
            self.waiting.unregister(line.socket)
            line.socket.close()
            control = self.controls.pop(line)
            with contextlib.suppress(OSError):
                control.shutdown(socket.SHUT_RDWR)  # wakes watch()
            control.close()

    def stop(self):
        """As Ctrl-C at a terminal: the run ends as stopped, with its result. Until then no lab has to wait."""
        self.process.send_signal(signal.SIGINT)
        line = self.busy
        while True:
            try:
                if line:
                    line.answer_nothing()
                line = self.next()
                if line is None:
                    return
                line.receive()
            except answering.Gone:
                self.drop(line)
                line = None

    def close(self):
        with self.lock:
            self.busy = None
        for line in list(self.controls):
            self.drop(line)
        try:
            self.said += self.process.communicate(timeout=20)[0]
        except BaseException as error:  # pylint: disable=broad-except  # another Ctrl-C
            self.process.kill()
            self.process.communicate()
            if not isinstance(error, subprocess.TimeoutExpired):
                raise
        finally:
            if self.place:
                self.listener.close()
                shutil.rmtree(self.place, ignore_errors=True)
            self.waiting.close()

    def check(self, folder, error=None):
        """Raises when the run has failed; `error`: what the user's code has raised."""
        if self.process.returncode in (0, 3):  # 3: stopped at its page
            return
        sentence = answering.sentence_of(error, "the scenario") if error else last_sentence(self.said.decode(errors="replace"))
        if not (folder / "result.json").is_file():  # it was refused
            try:
                folder.rmdir()
            except OSError:
                pass
            raise Failed(sentence, folder) from error
        raise Failed(f"{sentence}; the run's folder is {folder}", folder) from error


def serve(session, make):
    """Answers all labs of a session until they have ended; returns what the user's code has raised first."""
    answers, first = {}, None
    try:
        while (line := session.next()) is not None:
            try:
                answers.setdefault(line, answering.Answers(line, make)).take_beside_others()
            except answering.Gone:
                session.drop(line)
                answers.pop(line, None)
            except KeyboardInterrupt:
                raise
            except BaseException as error:  # pylint: disable=broad-except  # also sys.exit
                first = first or error
                fail(line, error)
    except KeyboardInterrupt:
        if not session.gave_up:
            session.stop()
            raise
        first = first or answering.Wrong(session.gave_up)
        for line in session.controls:
            fail(line, first)
    finally:
        session.close()
    return first


def fail(line, error):
    try:
        line.fail(answering.sentence_of(error, "the scenario"))
    except answering.Gone:
        pass


# --- what users call ---
def arguments_of(scenario, labs, seconds, settings, out):
    """What `arkmesh run` is given, the folder, and a class if the scenario is one."""
    if not isinstance(scenario, type) and str(scenario).endswith(".toml"):
        scenario, labs = None, (scenario, *labs)
    cls = scenario if isinstance(scenario, type) else None
    if cls is not None and not issubclass(cls, Scenario):
        raise TypeError(f"{cls.__name__} is no scenario; derive it from arkmesh.Scenario")
    if cls is None and scenario is not None and not isinstance(scenario, (str, os.PathLike)):
        what = type(scenario).__name__
        raise TypeError(f"give the class, as arkmesh.run({what}, ...), and not an object of it" if isinstance(scenario, Scenario)
                        else f"a scenario is a class derived from arkmesh.Scenario, or a file, and no {what}")
    if not labs:
        raise TypeError("name the labs' files, as arkmesh.run(LightUp, \"a.toml\", \"b.toml\")")
    name = answering.name_of_class(cls) if cls else pathlib.Path(scenario or labs[0]).stem
    settings = dict(settings or {})
    if scenario is not None:
        settings["run.scenario"] = name + ".py" if cls else os.path.abspath(scenario)
    folder = pathlib.Path(out) if out else new_folder(name)
    sets = [word for key, value in settings.items() for word in ("--set", f"{key}={json.dumps(value, default=plain)}")]
    if seconds is not None:
        sets += ["--seconds", str(seconds)]
    return ["run", *map(os.fspath, labs), "--out", str(folder), *sets], folder, cls


def plain(value):
    """A setting of numpy's as Python's, and a path as a text."""
    return os.fspath(value) if isinstance(value, os.PathLike) else value.tolist()


def new_folder(name):
    began = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    for n in itertools.count(1):
        folder = pathlib.Path("runs") / (f"{began}-{name}" + (f"-{n}" if n > 1 else ""))
        try:
            folder.mkdir(parents=True)
            return folder
        except FileExistsError:
            pass


def maker(cls):
    return lambda facts: (cls(), lambda: answering.sources_of_class(cls))


def run(scenario: Union[Type[Scenario], str, os.PathLike], *labs: Union[str, os.PathLike], seconds: Optional[float] = None, seed: Optional[int] = None,
        settings: Optional[Mapping[str, Any]] = None, out: Union[str, os.PathLike, None] = None) -> Run:
    """Runs labs' files in one shared world, and returns the Run. `scenario`: a class derived from Scenario, which this
    process answers with; a file of Python; or left out, and the labs' files name it. `settings`: keys of the labs' files,
    {"gate.period_s": 1, "b:arena.robots": 5}. Raises Failed."""
    arguments, folder, cls = arguments_of(scenario, labs, seconds, settings, out)
    if seed is not None:
        arguments += ["--seed", str(seed)]
    session = Session(arguments, cls is not None)
    session.check(folder, serve(session, maker(cls)))
    return Run(folder)


def batch(scenario: Union[Type[Scenario], str, os.PathLike], *labs: Union[str, os.PathLike], seeds: Iterable[int], jobs: int = 1,
          seconds: Optional[float] = None, settings: Optional[Mapping[str, Any]] = None, out: Union[str, os.PathLike, None] = None) -> Batch:
    """Runs the labs once for each of `seeds`, `jobs` at a time, and returns the Batch. As run(); a run that fails is a row
    that says why, and what fails before any run begins is raised as Failed."""
    settings = {"recorder.log": True, **(settings or {}), **({} if seconds is None else {"run.duration_s": seconds})}
    (_, *arguments), folder, cls = arguments_of(scenario, labs, None, settings, out)
    session = Session(["batch", *arguments, "--seeds", ",".join(str(operator.index(seed)) for seed in seeds), "--jobs", str(jobs)], cls is not None)
    first = serve(session, maker(cls))
    if not (folder / "runs.csv").is_file():
        session.check(folder, first)
    return Batch(folder)


class lab:  # pylint: disable=invalid-name
    """One lab as a loop: `with arkmesh.lab("a.toml", seconds=60) as lab: for frame in lab: ...`. Both are a Lab. Before the
    loop `lab` is as in a scenario's begin(). When the loop is left, the run ends as finished; when the block raises, as
    failed. Then `lab.run` is the Run. `name`: of the table of settings, [scenario.NAME]."""

    def __init__(self, file, seconds=None, seed=None, settings=None, out=None, every=1, name="loop"):
        self.given = {**(settings or {}), "run.scenario": name + ".py"}, every
        self.file, self.seconds, self.seed, self.out = file, seconds, seed, out
        self.session = self.loop = None

    def __enter__(self):
        settings, every = self.given
        arguments, self.folder, _ = arguments_of(self.file, (), self.seconds, settings, self.out)
        if self.seed is not None:
            arguments += ["--seed", str(self.seed)]
        self.session = Session(arguments, True)
        try:
            line = self.session.next()
            if line is not None:
                self.loop = Loop(self.session, line, every)
                return self.loop
        except BaseException:
            self.session.process.terminate()
            self.session.close()
            raise
        self.session.close()
        self.session.check(self.folder)
        raise Failed("the lab ended before it began", self.folder)

    def __exit__(self, kind, error, trace):
        if isinstance(error, KeyboardInterrupt) and self.session.gave_up:
            error = answering.Wrong(self.session.gave_up)
        try:
            if isinstance(error, KeyboardInterrupt):
                self.session.stop()
            elif error is not None:
                fail(self.loop._line, error)
            else:
                self.loop.finish()
        except KeyboardInterrupt:
            self.session.stop()
            raise
        finally:
            answering.global_state(self.loop.before)
            self.session.close()
        if error is None or self.session.gave_up:
            self.session.check(self.folder, error)
        if error is not None:
            return
        self.loop.run = Run(self.folder)


class Loop(Lab):
    """A lab that is iterated over: once for each frame."""

    def __init__(self, session, line, every):
        facts = json.loads(line.receive()[1])
        self.before = answering.global_state(facts=facts)
        super().__init__(facts, line.ask_setting)
        self.session, self._line, self.run = session, line, None
        self._every, self._owed = every, {}  # what goes with the next answer, which is the first

    def __iter__(self):
        while self._answer() and (kind := self._see_next()):
            self._owed = {}
            if kind == "F":
                yield self

    def _answer(self, more=None):
        if self._owed is not None:
            try:
                self._ask = None
                begun = answering.about(self._every, {}, self) if self._every is not None else {}
                self._every = None
                self._line.answer(self, {**begun, **self._owed, **(more or {})})
            except answering.Gone:
                return False
            self._owed = None
        return True

    def _see_next(self):
        """The kind of the lab's next message; None when it has ended."""
        if self.session.next() is None:
            return None
        try:
            kind, content = self._line.receive()
        except answering.Gone:
            self.session.drop(self._line)
            return None
        answering.see(self, kind, content)
        return kind

    def finish(self):
        """Ends the run at the next boundary."""
        while self._answer({"finished": True}) and self._see_next():
            self._owed = {}
