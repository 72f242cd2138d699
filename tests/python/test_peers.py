"""research/peers: tables, goals and the command line; no peer is installed or run."""

from __future__ import annotations

import importlib
import json
import pathlib
import re
import sys
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import pytest
from measurements import run

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "research" / "peers"
MODULES = ("environments", "goals", "peers", "picture", "report", "results")
PROGRAMS = ("measure", "vehicle")  # of the peers, beside their programs


@pytest.fixture
def bench() -> Iterator[dict[str, ModuleType]]:
    """The runner's modules; their plain names are restored afterwards."""
    before = {name: sys.modules.pop(name) for name in PROGRAMS if name in sys.modules}
    sys.path.insert(0, str(FOLDER))
    try:
        found = {name: importlib.import_module(name) for name in PROGRAMS}
        yield found | {name: importlib.import_module(f"research.peers.{name}") for name in MODULES}
    finally:
        sys.path.remove(str(FOLDER))
        for name in PROGRAMS:
            sys.modules.pop(name, None)
        sys.modules.update(before)


def line(**changes: Any) -> dict[str, Any]:
    facts = {
        "peer": "mjbatch",
        "version": "1",
        "engine": "MuJoCo",
        "task": "hover",
        "envs": 1024,
        "robots": 1,
        "substeps": 1,
        "cores": 2,
        "rate": 1e6,
        "unit": "physics steps/s",
        "differs": "no lag",
        "mode": "Batch.step, 2 threads",
    }
    return facts | changes


def own(**changes: Any) -> dict[str, Any]:
    return line(peer="Skybody", mode="make_vec, 2 threads", rate=60e6) | changes


def figure(figures: list[Any], what: str) -> Any:
    return next(found for found in figures if found.what == what)


def test_goals_are_met_and_missed(bench: dict[str, ModuleType]) -> None:
    read, figures = bench["results"].read, bench["goals"].figures
    rows = [
        read(facts)
        for facts in (
            own(),
            own(mode="make_vec, 1 thread, rk4", cores=1, rate=16e6),
            own(mode="C++, skybody bench, 1 thread", cores=1, rate=30e6),
            line(rate=2e6),
            line(envs=8192, rate=2.5e6),
            line(peer="L2F", cores=1, rate=6e6, mode="step"),
            line(peer="mujoco_cpp", envs=1, cores=1, rate=1e6, mode="mj_step in C"),
        )
    ]
    found = figures(rows)
    mjbatch = figure(found, "mjbatch, hover, one step a call")
    assert mjbatch.ratio == pytest.approx(60.0 / 2.5)
    assert mjbatch.verdict == "missed"
    l2f = figure(found, "L2F, RK4 against RK4, by core")
    assert l2f.ratio == pytest.approx(16.0 / 6.0)
    assert l2f.verdict == "missed"
    assert figure(found, "C++ step, 1 robot: MuJoCo's mj_step, by core").verdict == "met"
    assert figure(found, "RotorPy, hover, one step a call").verdict == "not measured"


def test_formation_stands_against_the_papers_workstation(bench: dict[str, ModuleType]) -> None:
    rows = [bench["results"].read(own(task="robots", envs=32, robots=20, rate=0.5e6))]
    found = figure(
        bench["goals"].figures(rows),
        "formation, 20 robots, from Python: the paper's workstation (24 cores)",
    )
    assert found.ratio == pytest.approx(0.5e6 / 3180.0)
    assert found.verdict == "met"


def test_cost_of_a_robot_is_flat_only_from_all_sizes(bench: dict[str, ModuleType]) -> None:
    def flat(rates: dict[int, float]) -> Any:
        mode = "C++, skybody bench, 1 thread, no joint observation"
        rows = [
            bench["results"].read(own(task="robots", robots=r, cores=1, rate=rate, mode=mode))
            for r, rate in rates.items()
        ]
        return bench["goals"].figures(rows)[-1]

    even = {robots: 10e6 / robots for robots in (2, 5, 10, 20)}
    assert flat(even).ratio == pytest.approx(1.0)
    assert flat(even | {20: 0.5e6 / 1.5}).verdict == "missed"
    assert flat({2: 5e6, 20: 0.5e6}).verdict == "not measured"


def test_the_quicker_of_two_sittings_counts(bench: dict[str, ModuleType]) -> None:
    results = bench["results"]
    rows = results.best_of_sittings(results.read(line(rate=rate)) for rate in (1e6, 3e6, 2e6))
    assert [row.rate for row in rows] == [3e6]


def test_rows_of_one_environment_stand_against_one(bench: dict[str, ModuleType]) -> None:
    results = bench["results"]
    rows = [results.read(facts) for facts in (own(), own(envs=1, cores=1, rate=1e6))]
    alone = results.counterpart(results.read(line(envs=1, cores=1)), rows)
    assert alone is rows[1]
    assert results.counterpart(results.read(line(envs=8192)), rows) is rows[0]
    assert results.counterpart(results.read(line(task="payload")), rows) is None


def test_the_table_says_ratio_version_and_what_differs(
    bench: dict[str, ModuleType], tmp_path: pathlib.Path
) -> None:
    results, report = bench["results"], bench["report"]
    rows = [results.read(facts) for facts in (own(), line())]
    machine = {"machine": "m", "processor": "p", "processors": 2, "skybody_version": "0"}
    machine |= {"date": "2026-01-01", "load": [0.0], "quick": True}
    whole = report.Report(machine, rows, ["skipped: l2f: why"], bench["goals"].figures(rows))
    shown = next(row for row in whole.text().splitlines() if row.split()[1:2] == ["mjbatch"])
    assert shown.split()[5:9] == ["1", "0.5", "60", "1"]
    assert shown.endswith("no lag")
    assert "skipped: l2f: why" in whole.text()
    page = whole.markdown(pathlib.Path("docs/results/images/peers.png"))
    assert "![Steps per second](images/peers.png)" in page
    assert json.loads(json.dumps(whole.facts()))["goals"][3]["verdict"] == "met"
    bench["picture"].draw(whole, tmp_path / "peers.png")
    assert (tmp_path / "peers.png").stat().st_size > 10_000


def test_a_row_without_a_rate_is_refused(bench: dict[str, ModuleType]) -> None:
    facts = line()
    del facts["rate"]
    with pytest.raises(ValueError, match="a row without rate"):
        bench["results"].read(facts)


@pytest.mark.parametrize("printed", ['{"peer": "x"}', "{no JSON", json.dumps(line(rate=0.0))])
def test_a_line_that_is_no_row_is_skipped(bench: dict[str, ModuleType], printed: str) -> None:
    found = bench["peers"].Results(quick=True)
    found.take("\n".join(["chatter", printed, json.dumps(line())]), "mjbatch")
    assert len(found.rows) == 1
    assert next(iter(found.skipped)).startswith("skipped: mjbatch: printed what is no row")


def test_a_late_script_ends_with_all_that_it_started(bench: dict[str, ModuleType]) -> None:
    # The child keeps the pipe open, so the output would not end before the child.
    command = ["sh", "-c", "echo begun; sleep 60 & wait"]
    done, late = bench["peers"].run_group(command, 0.2)
    assert late
    assert done.stdout == "begun\n"


def test_what_cannot_be_installed_is_tried_once(
    bench: dict[str, ModuleType], monkeypatch: pytest.MonkeyPatch
) -> None:
    environments, tries = bench["environments"], []

    def installed(name: str) -> None:
        tries.append(name)
        raise environments.Skipped("not installed: why")

    monkeypatch.setattr(environments, "installed", installed)
    for _ in range(2):
        with pytest.raises(environments.Skipped, match="not installed: why"):
            environments.python_of("l2f")
    assert tries == ["l2f"]


def test_an_adaptive_rk45_is_no_rk4(bench: dict[str, ModuleType]) -> None:
    read = bench["results"].read
    assert not read(line(differs="adaptive RK45")).is_rk4
    rows = [
        read(facts)
        for facts in (
            own(mode="make_vec, 2 threads, rk4", rate=30e6),
            line(peer="RotorPy", envs=1, cores=1, rate=9e5, differs="adaptive RK45"),
            line(peer="RotorPy", rate=1e5, differs="no contact; RK4"),
        )
    ]
    found = figure(bench["goals"].figures(rows), "RotorPy, RK4 against RK4")
    assert found.ratio == pytest.approx(300.0)
    assert "no goal of its own" in found.of


def test_reasons_name_no_address_and_no_path(bench: dict[str, ModuleType]) -> None:
    text = bench["environments"].plain("no x==1 at https://host/simple, see /root/log and a/b")
    assert text == "no x==1 at ... see ... and a/b"
    pool = "HTTPSConnectionPool(host='some.host', port=443): Failed to resolve 'some.host' (a==1.2)"
    text = bench["environments"].plain(pool + " by 10.0.0.1:80 or some.host.org")
    assert text == "HTTPSConnectionPool(..., ...): Failed to resolve ... (a==1.2) by ... or ..."


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "gazebo"], "no peer 'gazebo'"),
        (["--gym-pybullet-drones", "nowhere"], "has no folder gym_pybullet_drones"),
        (["--slow"], "unrecognized arguments"),
    ],
)
def test_bad_command_lines_exit_2(arguments: list[str], message: str) -> None:
    done = run("peers", *arguments)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_best_rate_counts_steps(bench: dict[str, ModuleType]) -> None:
    calls: list[int] = []
    effort = bench["measure"].Effort(0.01, 2, quick=True)
    rate = bench["measure"].best_rate(lambda: calls.append(1), 10, effort)
    assert 0 < rate < 10 * len(calls) / 0.01


def test_the_vehicle_is_the_shipped_one(bench: dict[str, ModuleType]) -> None:
    vehicle = bench["vehicle"].qdrone2()
    assert vehicle.base.mass == pytest.approx(1.54)
    assert vehicle.base.inertia == pytest.approx((0.014730, 0.016787, 0.029334), rel=1e-4)
    assert vehicle.hover_speed() == pytest.approx(1391.0, abs=1.0)
    assert bench["vehicle"].payload().mass == pytest.approx(0.217)
    assert bench["vehicle"].mjcf(2, with_payload=True).count('type="ball"') == 4


def test_the_programs_vehicle_is_the_same(bench: dict[str, ModuleType]) -> None:
    """The C++ programs contain the model's numbers as text, about its centre of mass."""
    text = (FOLDER / "step_bench.h").read_text()
    struct = text[text.index("struct Quadrotor {") : text.index("inline constexpr Quadrotor")]

    def numbers(name: str) -> list[float]:
        found = re.search(rf"\b{name}(?:\[\d\])* = ([^;]+?)[,;]\s*(?:\w+ =|//|double|int)", struct)
        assert found, name
        return [float(part) for part in re.findall(r"-?\d[\d.]*(?:e[-+]?\d+)?", found[1])]

    shared, vehicle = bench["vehicle"], bench["vehicle"].qdrone2()
    x, y, _ = vehicle.base.center
    hubs = [
        value
        for rotor in vehicle.rotors
        for value in (rotor.position[0] - x, rotor.position[1] - y)
    ]
    moment, thrust = numbers("moment_ratio")
    assert numbers("dt") == [shared.DT]
    assert numbers("g") == [shared.GRAVITY]
    assert numbers("mass") == pytest.approx([vehicle.base.mass])
    assert numbers("inertia") == pytest.approx(vehicle.base.inertia, rel=1e-9)
    assert numbers("hub") == pytest.approx(hubs)
    assert numbers("direction") == [rotor.direction for rotor in vehicle.rotors]
    assert moment / thrust == pytest.approx(vehicle.moment_ratio)
    assert numbers("height") == [shared.place(0)[2]]
    assert numbers("spacing") == pytest.approx([shared.place(1)[0]])
