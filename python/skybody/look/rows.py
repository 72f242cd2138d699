"""Rows of a dataset, read by parts: the memory is bounded however long a flight is."""

from __future__ import annotations

import threading
from collections import OrderedDict
from typing import Any

import numpy as np
from numpy.typing import NDArray

WHOLE = 64 << 20  # datasets up to this size are kept in memory [bytes]
BLOCK = 1 << 20  # least size of a block of a larger one [bytes]
KEPT = 64  # blocks


class Rows:
    """A dataset of which some rows are wanted at a time. Threads may read at the same time."""

    def __init__(self, dataset: Any) -> None:
        """Reads nothing yet.

        Args:
            dataset: an h5py.Dataset of numbers, or an array.
        """
        self._dataset = dataset
        row = max(1, dataset.nbytes // max(len(dataset), 1))
        chunk = (dataset.chunks or (1,))[0] if hasattr(dataset, "chunks") else 1
        height = -(-max(BLOCK // row, 1) // chunk) * chunk
        self._height = height if dataset.nbytes > WHOLE else max(len(dataset), 1)
        self._blocks: OrderedDict[int, NDArray[Any]] = OrderedDict()
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return len(self._dataset)

    def __getitem__(self, rows: NDArray[np.intp] | list[int]) -> NDArray[np.float64]:
        """A copy of some rows, in their order."""
        numbers = np.asarray(rows, np.intp)
        found = np.empty((len(numbers), *self._dataset.shape[1:]))
        of = numbers // self._height
        for block in np.unique(of):
            mine = of == block
            found[mine] = self._block(int(block))[numbers[mine] - block * self._height]
        return found

    def _block(self, number: int) -> NDArray[Any]:
        with self._lock:
            if number not in self._blocks:
                first = number * self._height
                self._blocks[number] = np.asarray(self._dataset[first : first + self._height])
                if len(self._blocks) > KEPT:
                    self._blocks.popitem(last=False)
            self._blocks.move_to_end(number)
            return self._blocks[number]
