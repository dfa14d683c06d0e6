"""Scenarios of arkmesh in Python: docs/writing-a-scenario.md. Needs Python 3.9 and numpy, nothing else."""
from .places import within
from .scenario import Lab, Others, Scenario

__all__ = ["Lab", "Others", "Scenario", "within"]
