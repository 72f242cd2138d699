"""A fingerprint of a network's parameters."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import torch


def parameter_hash(parameters: Mapping[str, torch.Tensor | NDArray[Any]]) -> str:
    """SHA-256 over names, shapes and values of `parameters` in the order of their sorted names.

    Two networks have the same hash exactly if all parameters are equal in every bit.
    """
    digest = hashlib.sha256()
    for name in sorted(parameters):
        values = _array(parameters[name])
        digest.update(f"{name} {values.dtype} {values.shape}\n".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()


def _array(values: torch.Tensor | NDArray[Any]) -> NDArray[Any]:
    if isinstance(values, np.ndarray):
        return values
    array: NDArray[Any] = values.detach().cpu().contiguous().numpy()
    return array
