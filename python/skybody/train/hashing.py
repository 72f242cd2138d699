"""A fingerprint of a network's parameters."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import torch


def parameter_hash(parameters: Mapping[str, torch.Tensor]) -> str:
    """SHA-256 over names, shapes and values of `parameters` in the order of their sorted names.

    Two networks have the same hash exactly where all parameters agree in every bit.
    """
    digest = hashlib.sha256()
    for name in sorted(parameters):
        values = parameters[name].detach().cpu().contiguous().numpy()
        digest.update(f"{name} {values.dtype} {values.shape}\n".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()
