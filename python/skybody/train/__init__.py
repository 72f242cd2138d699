"""Training: `python -P -m skybody.train`, with checkpoints that resume bit for bit.

docs/training.md describes the run folder, the hyper-parameters and the promises about determinism.
This package does not import PyTorch before a learner is made, so that evaluation processes
start quickly.
"""

from __future__ import annotations

from skybody.train.hashing import parameter_hash

__all__ = ["parameter_hash"]
