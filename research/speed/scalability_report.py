"""Page and picture of scalability.py."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from research.common.machine import machine_line
from research.common.pages import markdown_table, percent, thousands
from research.common.plots import save
from research.speed import paper_tables
from research.speed.paper_tables import Architecture, Peak
from research.speed.throughput_plot import curve, two_panels

Result = dict[str, Any]
LARGEST = max(paper_tables.COUNTS)
BASELINES = {  # ways of research/speed/baselines.py: description, and the paper's counterpart
    "vec": ("`make_vec`", None),
    "pool": ("`SimulationPool`", paper_tables.ASYNC_POOL),
    "processes": ("Python processes", paper_tables.MULTIPROCESSING),
    "threads": ("Python threads", paper_tables.THREADING),
    "loop": ("a Python loop", paper_tables.SERIAL),
}
PEAK_HEAD = ("ours", "peak", "N_E*", "N_B", "CPU [%]")
PAPER_HEAD = ("the paper's", "workstation", "N_E*", "CPU [%]", "laptop", "N_E*", "CPU [%]")

HEAD = """\
# Scalability: the paper's Table III and figure 7

Written by `research/speed/scalability.py`; all trials are in data/scalability.json.
{machine}.

![Throughput and processor use over the number of environments](images/scalability.png)

Hover: one quadrotor, one physics step of 1 ms an action, 22 observations. Rates are thousands of
environment steps a second, mean and 95 % Student's t interval over {trials} trials.

## Peaks (Table III)

The best mean over the numbers of environments; N_E* is where. **The paper's columns are its own
figures, from other computers**: {paper}. Ours are from {processors} cores. The paper's GPU columns
are left out: neither its Gazebo nor Skybody uses one."""

BY_COUNT = """\
## The pool by number of environments (figure 7)

`make_pool("hover", N_E, batch_size=N_B, num_threads=N_T, infos=False)` from Python: `recv`, then
`send` of the same actions to the environments received. N_T = min(N_E, processors), not pinned.
`zero` is the reference's constant action, 68 % of the thrust that hovers: after 0.9 s the vehicle
lies on the ground, and contact is computed for the rest of its 20 s. `hold` is hover speed. CPU is
processor time by wall time and processors; threads that wait spin for a while, which counts."""

MEASURED = """\
### How much was measured

The paper's text says 1,000 environment steps of warm-up and 10,000 measured; the reference's code
counts receives, and 1,000 N_E of them as warm-up. Here it is {warm_up:,} and {receives:,}
receives, or {seconds:g} s of measurement where that is longer. On Simbody warm-up and measurement
end after {simbody:g} s each, whatever the receives: at about 10 us a step, 10,000 receives of 128
would take minutes. Means over the trials, in thousands:"""

NOTES = """\
As in the reference's code, a row that begins an episode counts as a step. Of all rows that is
{zero:.3f} % under `zero` and {hold:.3f} % under `hold` ({share_envs} environments over a horizon).
A reset of the reference takes physics steps of its own; here it is one row."""

BASELINE_HEAD = """\
## The paper's baselines

`research run baselines`: all of them wait for all N worlds in every step, under `zero`. Threads and
processes are one per processor, each with its share of the worlds; so are the threads of
`SimulationPool`, while the paper's AsyncDRLServerPool has one per world. They do not follow the
protocol above: the trials of a row, {seconds:g} s each, step the same worlds, after a fifth of that
as warm-up. CPU [%] in brackets."""


def markdown(content: dict[str, Any]) -> str:
    """The whole page."""
    length = content["length"]
    head = HEAD.format(
        machine=machine_line(content["facts"]),
        trials=length["trials"],
        paper=paper_tables.machines_line(),
        processors=content["facts"]["cores"],
    )
    shares = {action: 100.0 * share for action, share in content["reset_share"].items()}
    parts = [
        head,
        markdown_table(peak_rows(content)),
        _per_core(content),
        BY_COUNT,
        markdown_table(rate_rows(content["pool"])),
        MEASURED.format(simbody=length["simbody_most"], **length),
        markdown_table(measured_rows(content["pool"])),
        NOTES.format(share_envs=content["reset_share_envs"], **shares),
        BASELINE_HEAD.format(seconds=length["seconds"]),
        markdown_table(baseline_rows(content["baselines"])),
    ]
    return "\n\n".join(parts) + "\n"


# --- tables -------------------------------------------------------------------------------------


def peak(results: Sequence[Result], wanted: Callable[[Result], bool]) -> Result:
    """The result with the best mean rate among those wanted."""
    return max((r for r in results if wanted(r)), key=lambda r: float(r["mean"]["rate"]))


def peak_rows(content: dict[str, Any]) -> list[list[str]]:
    """Table III: ours and the paper's."""
    pool, gazebo = content["pool"], paper_tables.GAZEBO_POOL

    def of_pool(dynamics: str, action: str, most: float = LARGEST) -> Result:
        wanted = (dynamics, action)
        return peak(pool, lambda r: (r["dynamics"], r["action"]) == wanted and r["envs"] <= most)

    rows = [
        [*PEAK_HEAD, *PAPER_HEAD],
        _peak_row("`make_pool`, zero", of_pool("tree", "zero"), gazebo),
        _peak_row("`make_pool`, hold", of_pool("tree", "hold"), None),
        _peak_row("`make_pool`, zero, any N_E", of_pool("tree", "zero", float("inf")), None),
        _peak_row("`make_pool`, hold, any N_E", of_pool("tree", "hold", float("inf")), None),
        _peak_row("`make_pool` on Simbody, zero", of_pool("simbody", "zero"), gazebo),
        _peak_row("`make_pool` on Simbody, hold", of_pool("simbody", "hold"), None),
    ]
    for way, (name, paper) in BASELINES.items():
        best = peak(content["baselines"], lambda r, way=way: r["way"] == way)  # type: ignore[misc]
        rows.append(_peak_row(f"{name}, zero", best, paper))
    return rows + [_peak_row("", None, paper) for paper in paper_tables.OTHERS]


def _peak_row(name: str, ours: Result | None, paper: Architecture | None) -> list[str]:
    row = [name] + [""] * (len(PEAK_HEAD) - 1)
    if ours:
        mean = ours["mean"]
        row[1:3] = thousands(mean["rate"], mean["interval"]), f"{ours['envs']:,}"
        row[3:] = f"{ours.get('batch', ours['envs']):,}", percent(mean["cpu_use"])
    if paper is None:
        return row + [""] * len(PAPER_HEAD)
    return [*row, paper.name, *_paper_cells(paper.workstation), *_paper_cells(paper.laptop)]


def _paper_cells(found: Peak) -> list[str]:
    return [f"{found.rate:.2f} ± {found.interval:.2f}", str(found.envs), f"{found.cpu:.1f}"]


def _per_core(content: dict[str, Any]) -> str:
    """Our best rate and the paper's, per core, because the computers differ."""
    most = max(paper_tables.COUNTS)  # as in the paper
    best = peak(
        content["pool"],
        lambda r: (r["dynamics"], r["action"]) == ("tree", "zero") and r["envs"] <= most,
    )
    cores = content["facts"]["cores"]
    ours = best["mean"]["rate"] / cores
    paper = paper_tables.GAZEBO_POOL
    stations = [
        (paper_tables.WORKSTATION, paper.workstation.rate),
        (paper_tables.LAPTOP, paper.laptop.rate),
    ]
    theirs = " and ".join(
        f"{rate / computer.cores:.1f} on the {computer.name}" for computer, rate in stations
    )
    return (
        f"By core, under the paper's action: {thousands(ours)} thousand here, {theirs}. Cores of\n"
        "different makes and years: an order of magnitude, not a ratio."
    )


def rate_rows(pool: Sequence[Result]) -> list[list[str]]:
    """Rate and processor use by N_E and N_B."""
    columns = _columns(pool)
    head = ["N_E", "N_B", "N_T"]
    for dynamics, action in columns:
        head += [f"{dynamics}, {action}", "CPU [%]"]
    rows = [head]
    for (envs, batch), group in _by_size(pool).items():
        row = [f"{envs:,}", f"{batch:,}", str(next(iter(group.values()))["threads"])]
        for column in columns:
            mean = group[column]["mean"] if column in group else None
            row += (
                [thousands(mean["rate"], mean["interval"]), percent(mean["cpu_use"])]
                if mean
                else ["", ""]
            )
        rows.append(row)
    return rows


def measured_rows(pool: Sequence[Result]) -> list[list[str]]:
    """Receives and environment steps of a trial, thousands."""
    columns = _columns(pool)
    head = ["N_E", "N_B"]
    for dynamics, action in columns:
        head += [f"{dynamics}, {action}: receives", "steps"]
    rows = [head]
    for (envs, batch), group in _by_size(pool).items():
        row = [f"{envs:,}", f"{batch:,}"]
        for column in columns:
            mean = group[column]["mean"] if column in group else None
            row += [thousands(mean["receives"]), thousands(mean["steps"])] if mean else ["", ""]
        rows.append(row)
    return rows


def _columns(pool: Sequence[Result]) -> list[tuple[str, str]]:
    return list(dict.fromkeys((r["dynamics"], r["action"]) for r in pool))


def _by_size(pool: Sequence[Result]) -> dict[tuple[int, int], dict[tuple[str, str], Result]]:
    """Results by (N_E, N_B), then by (dynamics, action)."""
    groups: dict[tuple[int, int], dict[tuple[str, str], Result]] = {}
    for r in pool:
        groups.setdefault((r["envs"], r["batch"]), {})[r["dynamics"], r["action"]] = r
    return groups


def baseline_rows(results: Sequence[Result]) -> list[list[str]]:
    """A row per number of worlds, a column per way."""
    rows = [["N", *(name for name, _ in reversed(BASELINES.values()))]]
    for envs in dict.fromkeys(r["envs"] for r in results):
        means = {r["way"]: r["mean"] for r in results if r["envs"] == envs}
        rows.append(
            [str(envs)]
            + [
                f"{thousands(means[way]['rate'], means[way]['interval'])} "
                f"({percent(means[way]['cpu_use'])})"
                for way in reversed(BASELINES)
            ]
        )
    return rows


# --- the picture --------------------------------------------------------------------------------

# Label, color and line of each curve of the pool: dynamics, whether N_B = N_E.
POOL_CURVES = {
    ("tree", False): ("make_pool, N_B = N_E / 3", "C0", "-"),
    ("tree", True): ("make_pool, N_B = N_E", "C0", "--"),
    ("simbody", False): ("make_pool on Simbody, N_B = N_E / 3", "C1", "-"),
    ("simbody", True): ("make_pool on Simbody, N_B = N_E", "C1", "--"),
}
BASELINE_COLORS = {"vec": "C9", "pool": "C2", "processes": "C3", "threads": "C4", "loop": "C5"}
PAPER_MARKS = {"workstation": "*", "laptop": "P"}


def draw(content: dict[str, Any], out: Path) -> None:
    """Throughput above processor use, over the number of environments: figure 7."""
    facts = content["facts"]
    title = f"hover, constant zero action; lines: {facts['cores']} cores of {facts['processor']}; "
    ticks = sorted({r["envs"] for r in content["pool"]})
    figure, axes = two_panels(f"{title}marks: the paper's", "environments N_E", ticks, 2)
    rates, use = axes
    for (dynamics, whole), (label, color, line) in POOL_CURVES.items():
        found = [r for r in content["pool"] if _on_curve(r, dynamics, whole)]
        _curve(axes, found, label, color, line)
    for way, (name, paper) in BASELINES.items():
        found = [r for r in content["baselines"] if r["way"] == way]
        _curve(axes, found, name.strip("`"), BASELINE_COLORS[way], ":")
        if paper:
            _paper_marks(rates, use, paper, BASELINE_COLORS[way])
    _paper_marks(rates, use, paper_tables.GAZEBO_POOL, "black")
    figure.legend(loc="outside lower center", ncols=3, fontsize=8)
    save(figure, out)


def _on_curve(r: Result, dynamics: str, whole: bool) -> bool:
    """Whether a result belongs to a curve; with one environment, N_B = 1 belongs to both."""
    batch = r["envs"] if whole else max(1, r["envs"] // 3)
    return (r["dynamics"], r["action"], r["batch"]) == (dynamics, "zero", batch)


def _curve(axes: Sequence[Axes], found: Sequence[Result], name: str, color: str, line: str) -> None:
    envs, means = [r["envs"] for r in found], [r["mean"] for r in found]
    curve(axes, envs, means, name, color=color, linestyle=line)


def _paper_marks(rates: Axes, use: Axes, paper: Architecture, color: str) -> None:
    for computer, found in (("workstation", paper.workstation), ("laptop", paper.laptop)):
        look: dict[str, Any] = {"color": color, "marker": PAPER_MARKS[computer], "markersize": 10}
        look |= {"linestyle": "none", "markeredgecolor": "white"}
        gazebo = paper is paper_tables.GAZEBO_POOL
        label = f"the paper's peaks, {computer} (black: GazeboPool)" if gazebo else None
        rates.plot([found.envs], [1e3 * found.rate], label=label, **look)
        use.plot([found.envs], [found.cpu], **look)
