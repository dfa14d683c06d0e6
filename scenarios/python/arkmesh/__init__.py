"""arkmesh from Python: scenarios, runs, batches and recordings. docs/writing-a-scenario.md. Needs Python 3.9 and numpy; figures need matplotlib."""
from typing import TYPE_CHECKING, Any

from . import renamed
from .batches import Batch, open_run
from .lab_facade import Lab
from .places import within
from .recorded import LabRun, Run
from .running import batch, lab, run
from .scenario import Others, Scenario
from .session import Failed
from .studies import check, sweep

__version__ = "0.1.0"
__all__ = ["Batch", "Failed", "Lab", "LabRun", "Others", "Run", "Scenario", "batch", "check", "lab", "open_run", "run", "sweep", "within"]

if not TYPE_CHECKING:
    def __getattr__(name: str) -> Any:
        """What had another name."""
        if name == "open":
            renamed.warn("arkmesh.open", "arkmesh.open_run", 2)
            return open_run
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
