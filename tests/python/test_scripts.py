"""Every committed script runs at its smallest size, so that a broken script is noticed.

Each script is listed here with its smallest call, or with the test that runs it. {out} is a folder
of its own. A call writes nothing into the repository and exits with 0; its output is not checked.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("bench", "examples", "experiments", "scripts")
PROGRAMS = ROOT / "build/release/bin"
MAIN = 'if __name__ == "__main__":'
TIMEOUT = 110.0  # s; a call takes a few on two free cores


@dataclass(frozen=True)
class Call:
    """A script's smallest call."""

    arguments: str = ""
    package: str = ""  # a required package; without it the test is skipped
    program: str = ""  # likewise, a program of build/release/bin
    tool: str = ""  # likewise, a program on the path


@dataclass(frozen=True)
class Elsewhere:
    """A script that another test runs; the test must name it."""

    test: str


QUICK = Call("--quick --out {out}")
PEER = Call("--quick --seconds 0.01 --trials 1")
SCRIPTS: dict[str, Call | Elsewhere] = {
    "bench/baselines.py": Call("--quick --counts 2"),
    "bench/goals.py": Call("--trial --json {out}/goals.json", program="bench_goals"),
    "bench/peers/contact_scenes.py": Call("0.01", package="pybullet"),
    "bench/peers/ours.py": PEER,
    "bench/peers/peer_crazyflow.py": replace(PEER, package="crazyflow"),
    "bench/peers/peer_envpool.py": replace(PEER, package="envpool"),
    "bench/peers/peer_gym_pybullet_drones.py": replace(PEER, package="gym_pybullet_drones"),
    "bench/peers/peer_l2f.py": replace(PEER, package="l2f"),
    "bench/peers/peer_mjbatch.py": replace(PEER, package="mjbatch"),
    "bench/peers/peer_mujoco.py": replace(PEER, package="mujoco"),
    "bench/peers/peer_pybullet.py": replace(PEER, package="pybullet"),
    "bench/peers/peer_rotorpy.py": replace(PEER, package="torchdiffeq"),
    "bench/peers/peers.py": Elsewhere("test_peers.py"),
    "bench/peers/vehicle.py": Call(),
    "examples/imu_observation.py": Elsewhere("test_examples.py"),
    "examples/python_task.py": Call("--steps 2048"),
    "examples/quickstart.py": Elsewhere("test_examples.py"),
    "examples/rllib_ppo.py": Call("--iterations 1 --envs 4", package="ray"),
    "experiments/air_speed.py": QUICK,
    "experiments/asymmetric_critic.py": QUICK,
    "experiments/contact_speed.py": QUICK,
    "experiments/control_abstractions.py": Call("--quick --tasks payload --out {out}"),
    "experiments/control_table.py": QUICK,
    "experiments/determinism_matrix.py": Elsewhere("test_determinism_matrix.py"),
    "experiments/disk_full.py": Elsewhere("test_disk_full.py"),
    "experiments/domain_randomization.py": QUICK,
    "experiments/dryden_spectra.py": QUICK,
    "experiments/effect_figures.py": QUICK,
    "experiments/first_flight.py": QUICK,
    "experiments/flight_tables.py": Call("--quick --markdown {out}/flights.md"),
    "experiments/gradient_choices.py": Call("--quick --out {out}", program="bench_gradient"),
    "experiments/ground_flights.py": Call("--quick --docs {out}"),
    "experiments/hard_cases.py": Call("--quick"),
    "experiments/hard_physics.py": QUICK,
    "experiments/hash_run.py": Call("hover --envs 2 --steps 10"),
    "experiments/hover_training.py": QUICK,
    "experiments/integrator_audit.py": Call("--quick --only hover"),
    "experiments/kill_and_resume.py": QUICK,
    "experiments/law_speed.py": Call("--quick --out {out}", program="bench_micro"),
    "experiments/learn_table.py": Call("--quick --algo fast-ppo --out {out}"),
    "experiments/learned_tables.py": Elsewhere("test_learned_tables.py"),
    "experiments/learner_profile.py": Call("--quick --out {out}", program="bench_learn"),
    "experiments/learning.py": Call("--quick --scenarios payload_learn --out {out}"),
    "experiments/memory.py": Elsewhere("test_memory_experiment.py"),
    "experiments/multi_agent.py": QUICK,
    "experiments/nmpc_timing.py": QUICK,
    "experiments/omav.py": QUICK,
    "experiments/paper_protocol.py": Call("hover --quick --algo fast-ppo --out {out}"),
    "experiments/race_lines.py": QUICK,
    "experiments/ray_speed.py": Call("--quick --out {out}", package="ray"),
    "experiments/recurrent_policy.py": Call("--quick --tasks hover --out {out}"),
    "experiments/reference_figures.py": Call("--quick"),
    "experiments/rotorpy_tracking.py": QUICK,
    "experiments/scalability.py": QUICK,
    "experiments/step_profile.py": Call("--quick --out {out}", tool="perf"),
    "experiments/task_speed.py": Call("hover --quick --out {out}"),
    "experiments/training_reproducibility.py": Elsewhere("test_reproducibility.py"),
    "experiments/tune_table.py": QUICK,
    "experiments/vehicle_policy.py": QUICK,
    "experiments/worlds.py": Call("hover --quick --out {out}"),
    "experiments/yardstick/command.py": Call("hover_learn --total-steps 1 --out {out}/run"),
    "scripts/build_times.py": Call("--count 3"),
    "scripts/code_lines.py": Call("scripts"),
    "scripts/control_page.py": Call("--check"),
    "scripts/flight_film.py": Elsewhere("test_flight_film.py"),
    "scripts/hyperparameters.py": Elsewhere("test_hyperparameters.py"),
    "scripts/lock_requirements.sh": Elsewhere("test_requirements.py"),
    "scripts/mark_older_pages.py": Elsewhere("test_result_pages.py"),
    "scripts/plain_words.py": Call("--table"),
    "scripts/plot_flight.py": Elsewhere("test_plot_flight.py"),
    "scripts/plugin_reference.py": Call("--check"),
    "scripts/python_options.py": Elsewhere("test_options.py"),
    "scripts/task_tables.py": Elsewhere("test_task_tables.py"),
    "scripts/update_docs.sh": Elsewhere(
        "test_scripts.py"
    ),  # all scripts that it calls are in this list
}
CALLS = {name: call for name, call in SCRIPTS.items() if isinstance(call, Call)}


def scripts() -> list[str]:
    """Executable files: programs in Python, examples, and shell scripts."""
    found = []
    for folder in FOLDERS:
        for path in (ROOT / folder).rglob("*"):
            is_example = folder == "examples" and path.suffix == ".py"
            is_program = path.suffix == ".py" and MAIN in path.read_text(encoding="utf-8")
            if path.suffix == ".sh" or is_example or is_program:
                found.append(path.relative_to(ROOT).as_posix())
    return sorted(found)


def committed() -> dict[str, int]:
    """Modification times of files that scripts might overwrite by mistake."""
    folders = ("docs", "effects", "tasks", "controllers")
    files = (path for folder in folders for path in (ROOT / folder).rglob("*") if path.is_file())
    return {str(path): path.stat().st_mtime_ns for path in files}


def test_every_script_has_a_row() -> None:
    assert sorted(SCRIPTS) == scripts()


def test_tests_that_run_a_script_name_it() -> None:
    for name, call in SCRIPTS.items():
        if isinstance(call, Elsewhere):
            assert Path(name).stem in (Path(__file__).parent / call.test).read_text(), name


@pytest.mark.parametrize("name", CALLS)
def test_a_script_runs_at_its_smallest_size(name: str, tmp_path: Path) -> None:
    call = CALLS[name]
    if call.package and importlib.util.find_spec(call.package) is None:
        pytest.skip(f"no package {call.package}")
    if call.program and not (PROGRAMS / call.program).is_file():
        pytest.skip(f"no {call.program}: ./dev build release benchmarks makes it")
    if call.tool and shutil.which(call.tool) is None:
        pytest.skip(f"no {call.tool} on the path")
    before = committed()
    command = [sys.executable, str(ROOT / name), *call.arguments.format(out=tmp_path).split()]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        command,
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    assert '"skipped"' not in done.stdout, "a measurement of bench/peers failed"
    assert committed() == before, "it writes into the repository"
