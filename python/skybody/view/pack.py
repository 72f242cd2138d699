"""Arrays as text in a page: 16-bit numbers between each column's extremes, compressed."""

from __future__ import annotations

import base64
import gzip
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

STEPS = 65534  # between a column's extremes; 65535 is NaN


class Packer:
    """Collects arrays into one compressed text; each is described by a small dictionary."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, values: ArrayLike) -> dict[str, Any]:
        """Adds an array of one or two dimensions, rows x columns.

        Values are rounded to 1/65534 of their column's range; infinities become NaN.

        Returns:
            Where it is: `at` [bytes], rows, columns, and each column's `low` and `step`.
        """
        table = np.asarray(values, np.float64)
        table = table.reshape(len(table), -1)
        known = np.isfinite(table)
        low = np.where(known, table, np.inf).min(axis=0, initial=np.inf)
        high = np.where(known, table, -np.inf).max(axis=0, initial=-np.inf)
        low = np.where(np.isfinite(low), low, 0.0)
        high = np.where(np.isfinite(high), high, low)
        step = (high - low) / STEPS
        shares = (table - low) / np.where(step > 0.0, step, 1.0)
        words = np.where(known, np.rint(np.where(known, shares, 0.0)), STEPS + 1)
        at = self._size
        self._append(words.astype(np.uint16).T)
        return {
            "at": at,
            "rows": table.shape[0],
            "columns": table.shape[1],
            "low": rounded(low),
            "step": rounded(step),
        }

    def text(self) -> str:
        """All arrays: gzip in base64."""
        return base64.b64encode(gzip.compress(b"".join(self._parts), 9, mtime=0)).decode()

    def _append(self, columns: NDArray[np.uint16]) -> None:
        """Differences from row to row, the low bytes first: smooth columns compress well."""
        change = np.diff(columns, axis=1, prepend=np.uint16(0))  # modulo 65536
        part = np.concatenate([(change & 0xFF).ravel(), (change >> 8).ravel()]).astype(np.uint8)
        self._parts.append(part.tobytes())
        self._size += part.size


def rounded(values: ArrayLike) -> list[float]:
    """Numbers with 9 significant digits, enough for a picture."""
    return [float(f"{value:.9g}") for value in np.ravel(np.asarray(values, np.float64))]
