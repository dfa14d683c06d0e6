"""arkmesh from Python: scenarios, runs, batches and recordings. docs/writing-a-scenario.md. Needs Python 3.9 and numpy; figures need matplotlib."""
import importlib
from typing import TYPE_CHECKING, Any

from . import renamed
from .lab_facade import Lab
from .places import within
from .scenario import Others, Scenario

if TYPE_CHECKING:
    from .batches import Batch, open_run
    from .recorded import LabRun, Run
    from .running import batch, lab, run
    from .session import Failed
    from .studies import check, sweep

__version__ = "0.1.0"
__all__ = ["Batch", "Failed", "Lab", "LabRun", "Others", "Run", "Scenario", "batch", "check", "lab", "open_run", "run", "sweep", "within"]
# Imported when they are named: a lab's process names none of them.
_LATER = {"Batch": "batches", "open_run": "batches", "LabRun": "recorded", "Run": "recorded", "batch": "running", "lab": "running", "run": "running",
          "Failed": "session", "check": "studies", "sweep": "studies"}

if not TYPE_CHECKING:
    def __dir__():
        return sorted({*globals(), *__all__})

    def __getattr__(name: str) -> Any:
        if name in _LATER:
            return getattr(importlib.import_module(f".{_LATER[name]}", __name__), name)
        if name in _LATER.values():
            return importlib.import_module(f".{name}", __name__)
        if name == "open":  # its former name
            renamed.warn("arkmesh.open", "arkmesh.open_run", 2)
            return __getattr__("open_run")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
