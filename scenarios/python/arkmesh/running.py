"""Runs from a script or notebook. The labs run as `arkmesh run`, a child process; where the scenario is a class of the
caller's, or a loop, the labs' scenario processes hand their lines over to this one (arkmesh_child.py), which answers."""
from __future__ import annotations

import datetime
import itertools
import json
import operator
import os
import pathlib
from typing import Any, Iterable, Mapping, Optional, Type, Union

from . import answering
from .batches import Batch
from .lab_facade import Lab
from .recorded import Run
from .scenario import Scenario
from .session import Failed, Session, fail, serve


def arguments_of(scenario, labs, seconds, settings, out, seed=None):
    """What `arkmesh run` is given, the folder, and a class if the scenario is one."""
    if not isinstance(scenario, type) and str(scenario).endswith(".toml"):
        scenario, labs = None, (scenario, *labs)
    cls = scenario if isinstance(scenario, type) else None
    if cls is not None and not issubclass(cls, Scenario):
        raise TypeError(f"{cls.__name__} is not a scenario; derive it from arkmesh.Scenario")
    if cls is None and scenario is not None and not isinstance(scenario, (str, os.PathLike)):
        what = type(scenario).__name__
        raise TypeError(f"give the class, as arkmesh.run({what}, ...), not an instance of it" if isinstance(scenario, Scenario)
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
    if seed is not None:
        sets += ["--seed", str(seed)]
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
    """Runs labs in one shared world.

    Parameters
    ----------
    scenario
        A class derived from Scenario, run in this process; a Python file; or a lab's file, if the labs' files name their scenario.
    labs
        The labs' files (.toml).
    seconds
        Lab time of the run in seconds; by default run.duration_s of the files.
    seed
        Seed of the run, a whole number from 0; by default that of the files.
    settings
        Keys of the labs' files; for one lab as "LAB:KEY": {"gate.period_s": 1, "b:arena.robots": 5}.
    out
        Folder of the run; by default a new one in runs/.

    Returns
    -------
    Run
        The recorded run.

    Raises
    ------
    Failed
        If the run fails, or the labs' files are invalid; the message gives the reason.
    TypeError
        If no lab is named, or the scenario is neither a class nor a file.
    """
    arguments, folder, cls = arguments_of(scenario, labs, seconds, settings, out, seed)
    session = Session(arguments, cls is not None)
    session.check(folder, serve(session, maker(cls)))
    return Run(folder)


def batch(scenario: Union[Type[Scenario], str, os.PathLike], *labs: Union[str, os.PathLike], seeds: Iterable[int], jobs: int = 1,
          seconds: Optional[float] = None, settings: Optional[Mapping[str, Any]] = None, out: Union[str, os.PathLike, None] = None) -> Batch:
    """Runs labs once for each seed.

    Parameters
    ----------
    scenario, labs, seconds, settings, out
        As in `run()`.
    seeds
        Whole numbers from 0.
    jobs
        Number of parallel runs. With a class as scenario they share this process.

    Returns
    -------
    Batch
        One row per run; a failed run has its reason in the column `why`.

    Raises
    ------
    Failed
        If no run starts.
    """
    settings = {"recorder.log": True, **(settings or {}), **({} if seconds is None else {"run.duration_s": seconds})}
    (_, *arguments), folder, cls = arguments_of(scenario, labs, None, settings, out)
    return batched([*arguments, "--seeds", ",".join(str(operator.index(seed)) for seed in seeds), "--jobs", str(jobs)], folder, cls)


def batched(arguments, folder, cls, progress=False):
    """The batch that `arkmesh batch` makes of these arguments."""
    session = Session(["batch", *arguments], cls is not None, progress)
    first = serve(session, maker(cls))
    if not (folder / "runs.csv").is_file():
        session.check(folder, first)
    return Batch(folder)


class lab:  # pylint: disable=invalid-name
    """One lab as a loop: `with arkmesh.lab("a.toml", seconds=60) as lab: for frame in lab: ...`. Both are a Loop.

    Before the loop `lab` is in the state of a scenario's begin(). Leaving the loop ends the run as finished, an exception in the block as failed. Afterwards
    `lab.run` is the Run.

    Parameters
    ----------
    file
        The lab's file (.toml).
    seconds, seed, settings, out
        As in `run()`.
    every
        Iterate over each k-th frame: a whole number from 1.
    name
        Name of the table of settings, [scenario.NAME].

    Raises
    ------
    Failed
        If the lab ends before it starts, or the run fails.
    """

    def __init__(self, file, seconds=None, seed=None, settings=None, out=None, every=1, name="loop"):
        self.given = {**(settings or {}), "run.scenario": name + ".py"}, every
        self.file, self.seconds, self.seed, self.out = file, seconds, seed, out
        self.session = self.loop = None

    def __enter__(self):
        settings, every = self.given
        arguments, self.folder, _ = arguments_of(self.file, (), self.seconds, settings, self.out, self.seed)
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
    """A Lab that can be iterated over, once per frame; `arkmesh.lab` creates it.

    Attributes
    ----------
    run : Run
        The recorded run, after the `with` block; None before.
    """

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
        """Ends the run at the next boundary, and waits for its end."""
        while self._answer({"finished": True}) and self._see_next():
            self._owed = {}
