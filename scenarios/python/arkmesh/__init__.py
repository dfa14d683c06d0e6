"""Scenarios of arkmesh in Python: docs/writing-a-scenario.md. Needs Python 3.9 and numpy, nothing else."""
from .lab import Lab, Others, Scenario
from .places import within

__all__ = ["Lab", "Others", "Scenario", "within"]
