"""arkmesh from Python: scenarios, runs, batches and recordings. docs/writing-a-scenario.md. Needs Python 3.9 and numpy; figures need matplotlib."""
from .places import within
from .recorded import Batch, LabRun, Run, open_run
from .recorded import open_run as open  # pylint: disable=redefined-builtin  # as it was called
from .running import batch, lab, run
from .scenario import Lab, Others, Scenario
from .session import Failed
from .studies import check, sweep

__version__ = "0.1.0"
__all__ = ["Batch", "Failed", "Lab", "LabRun", "Others", "Run", "Scenario", "batch", "check", "lab", "open_run", "run", "sweep", "within"]
