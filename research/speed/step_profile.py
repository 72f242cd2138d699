"""Where the time of a step goes, kernel by kernel.

nanoseconds of each kernel, by `perf` on `skybody bench`.

    python -m research run step_profile [--quick] [--out DIR]

Needs Linux `perf` (Debian: linux-perf). One thread; samples are taken at equal intervals of CPU
time, so that a kernel's share of the samples is its share of the time.
"""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import markdown_table, write_page
from research.common.places import PROGRAM
from research.common.programs import RunError, output_of

PAGE = "step_profile"

SAMPLES_A_SECOND = 4000
LEAST_SHARE = 0.02  # of the samples: smaller kernels are in the row `other`


@dataclass(frozen=True)
class Profiled:
    """One measured flight."""

    title: str
    words: str  # of `skybody bench`
    goal: str = ""  # of the page goals.md


FLIGHTS = (
    Profiled("hover, K = 1", "hover --envs 1024", "half of the limit"),
    Profiled("hover, K = 10", "hover --envs 1024 --set stepping.action_repeat=10", "half of it"),
    Profiled("hover, 16,384 environments", "hover --envs 16384", "0.95 of 1,024's rate"),
    Profiled(
        "all on the ground",
        "hover --envs 1024 --actions zero"
        " --set randomization[0].parameters.position_min=[-5,-5,0.06]"
        " --set randomization[0].parameters.position_max=[5,5,0.061]",
        "0.35 of the limit",
    ),
    Profiled("payload as shipped", "payload --envs 1024", "0.3 of the limit"),
    Profiled(
        "formation of 2", "formation_2 --envs 32 --set stepping.horizon=1000", "half of the limit"
    ),
    Profiled(
        "formation of 20", "formation_20 --envs 32 --set stepping.horizon=1000", "half of the limit"
    ),
)


def profile(flight: Profiled, seconds: float) -> dict[str, Any]:
    """Time of an environment step [ns], and the shares of its kernels."""
    with tempfile.TemporaryDirectory() as folder:
        samples = Path(folder) / "perf.data"
        command = [
            *("perf", "record", "-q", "-e", "cpu-clock", "-F", str(SAMPLES_A_SECOND)),
            *("-o", str(samples), "--", str(PROGRAM), "bench", *flight.words.split()),
            *("--threads", "1", "--seconds", str(seconds), "--json"),
        ]
        step = 1e9 / json.loads(output_of(command))["env_steps_per_second"]
        options = ["--stdio", "--no-children", "-g", "none", "--sort", "symbol"]
        report = output_of(["perf", "report", "-q", "-i", samples, *options])
    shares: dict[str, float] = {}
    for line in report.splitlines():
        if match := re.match(r"\s*([\d.]+)%\s+\[.\]\s+(.*)", line):
            name = short_name(match[2])
            shares[name] = shares.get(name, 0.0) + float(match[1]) / 100
    return {"title": flight.title, "goal": flight.goal, "ns": step, "shares": shares}


def short_name(symbol: str) -> str:
    """A symbol without namespaces and arguments: the kernel's or the function's name."""
    symbol = re.sub(r"\s+-\s+-\s*$", "", symbol).strip()  # empty columns of perf
    if kernel := re.search(r"Kernel<(.*)", symbol):
        symbol = kernel[1].replace("(anonymous namespace)::", "")
        found = re.match(
            r"(?:skybody::)?(?:plugin_export::)?(\w+)(?:<(?:skybody::)?(\w+))?", symbol
        )
        if found is None:
            return symbol
        inner = found[2] if found[2] and not found[2].startswith("IntegratorChoice") else ""
        return f"{found[1]} ({inner})" if inner else found[1]
    return re.split(
        r"[(<]", symbol.replace("skybody::", "").replace("(anonymous namespace)::", "")
    )[0]


def rows_of(found: dict[str, Any]) -> list[list[str]]:
    """The kernels of a flight, the most expensive first."""
    large = {k: v for k, v in found["shares"].items() if v >= LEAST_SHARE}
    rows = [
        [k, f"{v * found['ns']:.1f}", f"{100 * v:.0f} %"]
        for k, v in sorted(large.items(), key=lambda item: -item[1])
    ]
    rest = 1.0 - sum(large.values())
    return [*rows, ["other", f"{rest * found['ns']:.1f}", f"{100 * rest:.0f} %"]]


def page(found: dict[str, Any]) -> str:
    """The page in Markdown."""
    parts = [
        f"""# Profile of a step

{machine_line(found["facts"])}

    .venv/bin/python -m research run step_profile

Nanoseconds of one environment step on one thread (`skybody bench`; actions are the baseline's, and
zero on the ground), by kernel. [goals.md](goals.md) has the limits, loops written by hand for the
same work; the goal of each flight is in its heading."""
    ]
    for flight in found["flights"]:
        table = [["kernel", "ns", "share"], *rows_of(flight)]
        parts.append(
            f"## {flight['title']}: {flight['ns']:,.0f} ns (goal: {flight['goal']})\n\n"
            f"{markdown_table(table)}"
        )
    return "\n\n".join(parts) + "\n"


def main() -> int:
    """Measures and writes the page."""
    options = Options(__doc__, __name__).given()
    if shutil.which("perf") is None:
        raise RunError("it needs Linux perf: apt install linux-perf")
    seconds = 0.2 if options.quick else 4.0
    flights = [profile(flight, seconds) for flight in FLIGHTS[: 1 if options.quick else None]]
    found = {"facts": facts(), "flights": flights}
    write_page(options.out, PAGE, page(found), found)
    return 0
