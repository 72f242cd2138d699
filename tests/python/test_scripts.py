"""Every committed script runs at its smallest size, so that a broken script is noticed.

Each script, and each measurement of `python -m research`, is listed here with its smallest call, or
with the test that runs it. {out} is a folder of its own. A call writes nothing into the
repository and exits with 0; its output is not checked.
"""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from measurements import ENVIRONMENT, RUN

from research.registry import measurements

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("examples", "research/peers", "scripts")
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
    "goals": Call("--trial --json {out}/goals.json", program="bench_goals"),
    "research/peers/camera_mujoco.py": Elsewhere("test_camera_peers.py"),
    "research/peers/camera_pybullet.py": Elsewhere("test_camera_peers.py"),
    "research/peers/contact_scenes.py": Call("0.01", package="pybullet"),
    "research/peers/ours.py": PEER,
    "research/peers/peer_crazyflow.py": replace(PEER, package="crazyflow"),
    "research/peers/peer_envpool.py": replace(PEER, package="envpool"),
    "research/peers/peer_gym_pybullet_drones.py": replace(PEER, package="gym_pybullet_drones"),
    "research/peers/peer_l2f.py": replace(PEER, package="l2f"),
    "research/peers/peer_mjbatch.py": replace(PEER, package="mjbatch"),
    "research/peers/peer_mujoco.py": replace(PEER, package="mujoco"),
    "research/peers/peer_pybullet.py": replace(PEER, package="pybullet"),
    "research/peers/peer_rotorpy.py": replace(PEER, package="torchdiffeq"),
    "peers": Elsewhere("test_peers.py"),
    "research/peers/raptor_server.py": Elsewhere("test_raptor.py"),
    "research/peers/vehicle.py": Call(),
    "examples/autograd.py": Call("--iterations 2"),
    "examples/camera.py": Call("--out {out}/cameras.png"),
    "examples/export_policy.py": Call("--out {out}/policy", package="onnxruntime"),
    "examples/imu_observation.py": Elsewhere("test_examples.py"),
    "examples/identify.py": Call("--out {out}/identify"),
    "examples/pettingzoo_formation.py": Call("--episodes 1"),
    "examples/ppo.py": Call("--iterations 2"),
    "examples/ros2_policy.py": Elsewhere("test_ros2.py"),
    "examples/sb3_images.py": Elsewhere("test_examples.py"),
    "examples/python_task.py": Call("--steps 2048"),
    "examples/quickstart.py": Elsewhere("test_examples.py"),
    "examples/skrl_ppo.py": Call("--steps 64", package="skrl"),
    "examples/rllib_ppo.py": Call("--iterations 1 --envs 4", package="ray"),
    "air_speed": QUICK,
    "asymmetric_critic": QUICK,
    "betaflight_hold": Elsewhere("test_sitl_betaflight.py"),
    "betaflight_race": Elsewhere("test_sitl_betaflight_policy.py"),
    "camera_peers": Call("--quick --out {out}", program="bench_render"),
    "camera_speed": Call("--quick --out {out}", program="bench_render"),
    "contact_speed": QUICK,
    "control_abstractions": Call("--quick --tasks payload --out {out}"),
    "control_table": QUICK,
    "determinism_matrix": Elsewhere("test_determinism_matrix.py"),
    "domain_randomization": QUICK,
    "dryden": QUICK,
    "effect_figures": QUICK,
    "effects_against_data": Elsewhere("test_effects_against_data.py"),
    "flights": QUICK,
    "gallery": QUICK,
    "gradient_choices": Call("--quick --out {out}", program="bench_gradient"),
    "hard_physics": QUICK,
    "hash_run": Call("hover --envs 2 --steps 10"),
    "identify_simulated": QUICK,
    "image_speed": Call("--quick --out {out}", package="stable_baselines3"),
    "integrators": Call("--quick --only hover --out {out}"),
    "kill_and_resume": QUICK,
    "law_speed": Call("--quick --out {out}", program="bench_micro"),
    "learning_speed": Call("--quick --algo fast-ppo --out {out}"),
    "learned_tables": Elsewhere("test_learned_tables.py"),
    "learner_profile": Call("--quick --out {out}", program="bench_learn"),
    "learning": Call("--quick --scenarios payload_learn --out {out}"),
    "memory": Elsewhere("test_memory_experiment.py"),
    "multi_agent": QUICK,
    "nmpc": QUICK,
    "onboard_latency": QUICK,
    "paper_protocol": Call("hover --quick --algo fast-ppo --out {out}"),
    "policy_export": Call("--quick --out {out}", package="onnxruntime"),
    "race_lines": QUICK,
    "raptor": QUICK,
    "ray_speed": Call("--quick --out {out}", package="ray"),
    "real_flights": Elsewhere("test_real_flights.py"),
    "recurrent_policy": Call("--quick --tasks hover --out {out}"),
    "reference_figures": QUICK,
    "ros2_speed": Call("--quick --out {out}", package="rclpy"),
    "rotorpy_tracking": QUICK,
    "scalability": QUICK,
    "scenario_index": Elsewhere("test_scenario_folders.py"),
    "sensor_cost": Call("--quick --only imu --out {out}"),
    "soak": Call("--quick"),
    "start_pages": Elsewhere("test_start_pages.py"),
    "step_profile": Call("--quick --out {out}", tool="perf"),
    "synchronization": Call("--quick --out {out} --only"),
    "task_speed": Call("hover --quick --out {out}"),
    "training_reproducibility": Elsewhere("test_reproducibility.py"),
    "transfer": QUICK,
    "tune": QUICK,
    "vision_comparison": Call("--quick --scenarios obstacles_vision --out {out}"),
    "worlds": Call("hover --quick --out {out}"),
    "scripts/build_betaflight.sh": Elsewhere("test_sitl_betaflight.py"),
    "scripts/build_wheels.py": Elsewhere("test_installed.py"),
    "scripts/check_wheels.py": Elsewhere("test_installed.py"),
    "scripts/check_debian.sh": Elsewhere("test_installed.py"),
    "scripts/debian_root.sh": Elsewhere("test_installed.py"),
    "scripts/time_installation.sh": Elsewhere("test_installed.py"),
    "scripts/manual_pages.py": Elsewhere("test_installed.py"),
    "scripts/docs_site/build.py": Elsewhere("test_docs_site.py"),
    "scripts/build_times.py": Call("--count 3"),
    "scripts/code_lines.py": Call("scripts"),
    "control_page": Call("--check"),
    "hyperparameters": Elsewhere("test_hyperparameters.py"),
    "scripts/lock_requirements.sh": Elsewhere("test_requirements.py"),
    "mark_older_pages": Elsewhere("test_result_pages.py"),
    "scripts/code_limits.py": Call(),
    "scripts/plain_words.py": Call("--table"),
    "scripts/plugin_reference.py": Call("--check"),
    "scripts/python_options.py": Elsewhere("test_options.py"),
    "task_tables": Elsewhere("test_task_tables.py"),
    "scripts/update_docs.sh": Elsewhere(
        "test_scripts.py"
    ),  # all scripts that it calls are in this list
}
CALLS = {name: call for name, call in SCRIPTS.items() if isinstance(call, Call)}


def scripts() -> list[str]:
    """Names of measurements; files of other programs in Python, of examples and shell scripts."""
    found = [row.name for row in measurements()]
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
    program = [sys.executable, str(ROOT / name)] if "/" in name else [*RUN, name]
    command = [*program, *call.arguments.format(out=tmp_path).split()]
    environment = {**ENVIRONMENT, "OMP_NUM_THREADS": "1"}
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
    assert '"skipped"' not in done.stdout, "a measurement of research/peers failed"
    assert committed() == before, "it writes into the repository"
