"""ULog, the log of PX4."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

import numpy as np
import pyulog

from skybody import InputError
from skybody.look.flight import Array

from .channels import Channels
from .map_file import Map

MICRO = 1e-6


def read(path: Path, used: Map) -> Channels:
    """Reads all topics: `TOPIC.FIELD`, and of further instances `TOPIC:1.FIELD`.

    Raises:
        InputError: the file is no ULog, or has no messages.
    """
    if used.time is not None:
        raise InputError(f"{used.file}: time: is not for this log, which has own times")
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # pyulog prints its findings
            log = pyulog.ULog(str(path))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except Exception as error:  # pyulog's own, and those of damaged bytes
        raise InputError(f"{path}: cannot be read as a ULog ({error})") from None
    notes = [f"{path}: is damaged; its readable part is used"] if log.file_corruption else []
    columns: dict[str, Array] = {}
    times: dict[str, Array] = {}
    for topic in log.data_list:
        head = topic.name if topic.multi_id == 0 else f"{topic.name}:{topic.multi_id}"
        seconds = topic.data["timestamp"] * MICRO
        for name, values in topic.data.items():
            if name != "timestamp":
                columns[f"{head}.{name}"] = np.asarray(values, dtype=np.float64)
                times[f"{head}.{name}"] = seconds
    if not columns:
        raise InputError(f"{path}: has no messages; it may be cut short")
    return Channels(path, columns, times, notes=notes)
