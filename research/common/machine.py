"""The machine of a measurement, in facts and in words."""

from __future__ import annotations

import datetime
import multiprocessing
import os
import platform
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any


def processors() -> int:
    """Number of logical processors that this process may use."""
    return len(os.sched_getaffinity(0))


def processor() -> str:
    """Name of the processor."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def processor_seconds() -> float:
    """Processor time of this process, its threads and its living children so far [s]."""
    ticks = 0
    for child in multiprocessing.active_children():
        after_name = Path(f"/proc/{child.pid}/stat").read_text().rpartition(")")[2].split()
        ticks += int(after_name[11]) + int(after_name[12])  # utime, stime
    return time.process_time() + ticks / os.sysconf("SC_CLK_TCK")


def machine() -> dict[str, Any]:
    """Facts about the machine."""
    system = f"{platform.system()} {platform.machine()}"
    return {"processor": processor(), "cores": processors(), "system": system}


def facts() -> dict[str, Any]:
    """machine() with date, load and versions: where speed counts."""
    import skybody

    return machine() | {
        "date": datetime.date.today().isoformat(),
        "load": os.getloadavg(),
        "versions": skybody.versions() | {"python": platform.python_version()},
    }


def machine_line(found: dict[str, Any]) -> str:
    """machine() or facts() in words."""
    line = f"{found['processor']}, {found['cores']} cores, {found['system']}"
    if "load" not in found:
        return line
    versions = found["versions"]
    asserts = " with asserts" if versions["simbody asserts"] == "on" else ""
    return (
        f"{line} ({versions['instruction set']}), {found['date']}; Skybody {versions['git']}, "
        f"Simbody {versions['simbody']}{asserts}, {versions['compiler']}, "
        f"Python {versions['python']}; load {found['load'][0]:.1f} when it began"
    )


def versions_line(configs: Sequence[dict[str, Any]]) -> str:
    """Versions of all runs; a package with several versions is listed with all of them."""
    found: dict[str, set[str]] = {}
    for config in configs:
        for name, version in config["versions"].items():
            if not name.startswith("plugin "):
                found.setdefault(name, set()).add(version)
    return "; ".join(f"{name} {' and '.join(sorted(all_of))}" for name, all_of in found.items())
