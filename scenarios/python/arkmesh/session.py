"""`arkmesh run` or `batch` as a child process whose labs ask this one, and their answers."""
from __future__ import annotations

import collections
import contextlib
import os
import selectors
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import traceback

from . import answering

KEPT_OUTPUT = 64 << 10
# Ctrl-C is for this process, which passes it on; when this one dies, that one is told to stop (PR_SET_PDEATHSIG). The kernel tells it
# once for each thread of this process, and a second SIGTERM would end it without a result; a second SIGUSR1 does not.
STARTER = ("import ctypes, os, signal, sys\nctypes.CDLL(None).prctl(1, int(signal.SIGUSR1))\n"
           "os.getppid() == int(sys.argv[1]) or sys.exit(1)\nos.execv(sys.argv[2], sys.argv[2:])")


class Failed(RuntimeError):
    """A run that has failed, in one sentence.

    Attributes
    ----------
    folder : pathlib.Path
        The run's folder, with its result.json if it had begun.
    """

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
        if is_computing and self.came:  # a message behind this one, which no selector tells of
            self.session.lines.append(self)
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
            self.lines = collections.deque(other for other in self.lines if other is not line)
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
    answers, first, current = {}, None, None
    before = answering.global_state()
    try:
        while (line := session.next()) is not None:
            try:
                mine = answers.setdefault(line, answering.Answers(line, make))
                if mine is not current:  # each has global generators of its own
                    former = answering.global_state(mine.state)
                    if current:
                        current.state = former
                    current = mine
                mine.take()
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
        answering.global_state(before)
        session.close()
    return first


def fail(line, error):
    try:
        line.fail(answering.sentence_of(error, "the scenario"))
    except answering.Gone:
        pass
