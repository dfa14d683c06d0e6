"""arkmesh from Python: scenarios, runs and recordings. docs/writing-a-scenario.md. Needs Python 3.9 and numpy, nothing else."""
from .places import within
from .recorded import Run
from .recorded import open_run as open  # pylint: disable=redefined-builtin
from .running import Failed, batch, lab, run
from .scenario import Lab, Others, Scenario

__all__ = ["Failed", "Lab", "Others", "Run", "Scenario", "batch", "lab", "run", "within"]
