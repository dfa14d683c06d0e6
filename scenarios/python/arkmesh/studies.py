"""Grids of settings and seeds, and a check of a scenario, both as runs of running.py."""
from __future__ import annotations

import json
import os
import pathlib
import tempfile
from typing import Any, Iterable, Mapping, Optional, Type, Union

from . import answering, running
from .batches import Batch
from .recorded import Run
from .scenario import Scenario
from .session import Failed

# Two labs of which the second has half the size: what depends on a lab's own metres shows itself.
LABS = """lab.name = "{name}"
run.duration_s = 10
gate.period_s = 0.5
shared = {{labs = ["a", "b"], owner = "a", projection.b.scale = 2}}
arena = {{robots = {robots}, width_m = {width}, height_m = {width}, ode.controller = "arkmesh:experiments/light_up/light_up.c"}}
"""


def sweep(scenario: Union[Type[Scenario], str, os.PathLike], *labs: Union[str, os.PathLike], settings: Mapping[str, Any], seeds: Iterable[int], jobs: int = 1,
          seconds: Optional[float] = None, out: Union[str, os.PathLike, None] = None, progress: bool = True) -> Batch:
    """Runs labs once for each combination of settings and each seed.

    Parameters
    ----------
    scenario, labs, seconds, out
        As in `run()`. The sweep itself is saved as `out`.sweep.toml.
    settings
        Values by key. A list is swept, any other value applies to all runs. A key without a dot is a setting of the scenario.
    seeds
        Seeds of each combination, whole numbers from 0.
    jobs
        Number of parallel runs. With a class as scenario they share this process.
    progress
        Show a progress bar on the standard error.

    Returns
    -------
    Batch
        One row per run, including failed ones, with the swept settings and the counts of all labs.

    Raises
    ------
    Failed
        If no run starts.
    FileExistsError
        If `out` holds another sweep.
    """
    *_, cls = running.arguments_of(scenario, labs, None, {}, out or tempfile.gettempdir())
    name = answering.name_of_class(cls) if cls else pathlib.Path(str(scenario)).stem
    keys = {key if "." in key else f"scenario.{name}.{key}": value for key, value in settings.items()}
    swept = {key: list(value) for key, value in keys.items() if not isinstance(value, str) and hasattr(value, "__iter__")}
    fixed: dict[str, Any] = {"recorder.log": True, **{key: value for key, value in keys.items() if key not in swept}}
    if seconds is not None:
        fixed["run.duration_s"] = seconds
    (_, *arguments), folder, cls = running.arguments_of(scenario, labs, None, fixed, out)
    experiment = folder.with_name(folder.name + ".sweep.toml")
    text = f"labs = {json.dumps([os.path.abspath(lab) for lab in labs])}\nseeds = {json.dumps([int(seed) for seed in seeds])}\n[sweep]\n"
    text += "".join(f"{json.dumps(key)} = {json.dumps(values, default=running.plain)}\n" for key, values in swept.items())
    if experiment.exists() and experiment.read_text() != text:
        raise FileExistsError(f"{experiment} belongs to another sweep; choose another `out`")
    experiment.write_text(text)
    return running.batched([str(experiment), *arguments[len(labs):], "--jobs", str(jobs)], folder, cls, progress)


def check(scenario: Union[Type[Scenario], str, os.PathLike], *, robots: int = 6, seconds: float = 10.0, settings: Optional[Mapping[str, Any]] = None) -> list[str]:
    """Tries a scenario on two small simulated labs and reports its faults.

    It runs twice with one seed, which must give equal results, and once with a single robot per lab.

    Parameters
    ----------
    scenario, settings
        As in `run()`.
    robots
        Number of robots per lab.
    seconds
        Lab time of each run in seconds.

    Returns
    -------
    list of str
        A sentence for each fault, with file and line if known; empty if there is none.
    """
    found: list[str] = []
    with tempfile.TemporaryDirectory(prefix="arkmesh-check-") as place:
        files = [pathlib.Path(place) / f"{name}.toml" for name in "ab"]

        def tried(folder: str, count: int) -> Optional[Run]:
            for file, width in zip(files, (0.6, 0.3)):
                file.write_text(LABS.format(name=file.stem, robots=count, width=width))
            try:
                return running.run(scenario, *files, seconds=seconds, seed=1, settings=settings, out=pathlib.Path(place) / folder)
            except Failed as failed:
                found.append(str(failed).partition("; the run's folder is")[0])
                return None

        runs = [tried(f"run{i}", robots) for i in range(2)]
        if runs[0] and runs[1]:
            if runs[0].hash != runs[1].hash or runs[0].counts != runs[1].counts:
                found.append("two runs with the same seed differ: the scenario depends on something that the seed does not determine; use lab.random(purpose) for chance, and lab.now_s for time")
            told = runs[0].labs["a"].result.get("scenario_in_python", {})
            found += told.get("unseeded", [])
            if not (runs[0].counts or any(runs[0].labs[name].rows for name in "ab")):
                found.append("it counts nothing: lab.count(name) and lab.row(table, ...) fill a run's result and tables")
            tried("one", 1)
    return list(dict.fromkeys(found))

