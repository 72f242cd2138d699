"""skybody.ray on a local cluster of two nodes; skipped if Ray is not installed."""

from __future__ import annotations

import csv
import importlib.util
import math
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ray = pytest.importorskip("ray", reason="`pip install '.[ray]'`")

from skybody._native import CompiledScenario  # noqa: E402
from skybody.program import module_command  # noqa: E402
from skybody.ray import sweep  # noqa: E402
from skybody.ray.cluster import ClusterError, cluster  # noqa: E402
from skybody.ray.slices import RaySlices, Setup  # noqa: E402
from skybody.train import __main__ as train  # noqa: E402
from skybody.train.checkpoint import checkpoint_folders, read_meta  # noqa: E402
from skybody.train.hyperparameters import with_settings  # noqa: E402
from skybody.train.native_learners import FastPpo  # noqa: E402
from skybody.train.presets import preset  # noqa: E402

HORIZON = "stepping.horizon=40"  # so that episodes end within a rollout
HYPER = with_settings(
    preset("hover_learn", "fast-ppo").hyper, ["envs=20", "rollout_steps=16", "minibatch=100"]
)
TOTAL, ITERATIONS = 100_000, 5


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A cluster with two nodes of two processors each, for all tests."""
    from ray.cluster_utils import Cluster

    os.environ["RAY_AUTH_MODE"] = "disabled"
    nodes = Cluster(initialize_head=True, head_node_args={"num_cpus": 2})
    nodes.add_node(num_cpus=2)
    try:
        yield nodes.address
    finally:
        nodes.shutdown()


@pytest.fixture(scope="module")
def compiled() -> CompiledScenario:
    return CompiledScenario("hover_learn", [HORIZON])


@pytest.fixture(scope="module")
def connected(address: str) -> Iterator[Any]:
    with cluster(address) as connection:
        yield connection


def hash_after(learner: FastPpo, iterations: int = ITERATIONS) -> int:
    for _ in range(iterations):
        learner.iterate()
    return learner.native_hash


def learner_on(connection: Any, compiled: CompiledScenario, workers: int) -> tuple[Any, FastPpo]:
    setup = Setup(
        "hover_learn",
        [HORIZON],
        [],
        f"{compiled.scenario_hash:016x}",
        dict(vars(HYPER)),
        1,
        TOTAL,
    )
    slices = RaySlices(connection, setup, 8, workers, 1)
    return slices, FastPpo(compiled, HYPER, 1, 1, TOTAL, slices)


@pytest.fixture(scope="module")
def hash_of_one_process(compiled: CompiledScenario) -> int:
    return hash_after(FastPpo(compiled, HYPER, 1, 1, TOTAL))


def end(slices: Any) -> None:
    for worker in slices.workers:
        ray.kill(worker)


@pytest.mark.parametrize("workers", [1, 2, 4])
def test_any_number_of_workers_gives_the_bits_of_one_process(
    connected: Any, compiled: CompiledScenario, hash_of_one_process: int, workers: int
) -> None:
    slices, learner = learner_on(connected, compiled, workers)
    assert hash_after(learner) == hash_of_one_process
    end(slices)


def test_a_worker_that_dies_is_replaced_and_the_bits_are_the_same(
    connected: Any, compiled: CompiledScenario, hash_of_one_process: int
) -> None:
    slices, learner = learner_on(connected, compiled, 2)
    hash_after(learner, 2)
    ray.kill(slices.workers[1])
    assert hash_after(learner, ITERATIONS - 2) == hash_of_one_process
    assert slices.replaced == 1
    end(slices)


def test_runs_move_between_a_cluster_and_one_process_with_the_same_bits(
    connected: Any, address: str, tmp_path: Path
) -> None:
    settings = ["envs=20", "rollout_steps=16", "minibatch=100"]
    words = ["hover_learn", "--override", HORIZON, "--seed", "1", "--eval-episodes", "0"]
    words += [word for setting in settings for word in ("--set", setting)]
    on_cluster = ["--ray", address, "--workers", "2"]
    home, away = tmp_path / "home", tmp_path / "away"
    begin, go_on = [*words, "--total-steps", "640"], ["--resume", "--total-steps", "1280"]
    assert train.main([*begin, "--out", str(home)]) == 0
    assert train.main([*begin, "--out", str(away), *on_cluster]) == 0
    assert train.main([*go_on, "--out", str(home), *on_cluster]) == 0
    assert train.main([*go_on, "--out", str(away)]) == 0
    found = [
        [read_meta(folder)["parameter_hash"] for folder in checkpoint_folders(run)]
        for run in (home, away)
    ]
    assert found[0] == found[1]
    assert len(found[0]) > 2


def test_workers_with_another_instruction_set_are_refused(address: str, tmp_path: Path) -> None:
    words = ["hover_learn", "--ray", address, "--workers", "1", "--out", str(tmp_path / "run")]
    done = subprocess.run(
        module_command("skybody.train", *words),
        env={**os.environ, "SKYBODY_ISA": "v2"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert "a worker's machine has instruction set v3 or v4, this one v2" in done.stderr
    assert not (tmp_path / "run").exists()


def test_rllib_learns_with_environments_of_ours(connected: Any) -> None:
    path = Path(__file__).resolve().parents[2] / "examples/rllib_ppo.py"
    spec = importlib.util.spec_from_file_location("rllib_ppo", path)
    assert spec is not None and spec.loader is not None
    rllib_ppo = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(rllib_ppo)
    algorithm = rllib_ppo.config("hover_learn", envs=8, runners=0).build_algo()
    first = rllib_ppo.summary(algorithm.train())
    second = rllib_ppo.summary(algorithm.train())
    assert 0 < first["steps"] < second["steps"]
    assert math.isfinite(second["return"])
    algorithm.stop()


@pytest.mark.parametrize("answer", [b"HTTP/1.1 400 Bad Request\r\n\r\n", b"SSH-2.0-x\r\n", b""])
def test_a_port_where_something_else_answers_is_no_cluster(answer: bytes) -> None:
    def answer_one(server: socket.socket) -> None:
        connection, _ = server.accept()
        with connection:
            connection.recv(100)
            connection.sendall(answer)

    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=answer_one, args=(server,), daemon=True).start()
        address = f"127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(ClusterError, match="something else answers"), cluster(address):
            pass


def test_a_sweep_trains_all_combinations_and_goes_on_with_new_seeds(
    connected: Any, address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["hover_learn", "--algo", "fast-ppo", "--override", HORIZON, "--address", address]
    command += ["--total-steps", "640", "--set", "envs=20", "--set", "rollout_steps=16"]
    command += ["--set", "minibatch=100,160", "--eval-episodes", "0", "--out", str(tmp_path)]
    assert sweep.main([*command, "--seeds", "1"]) == 0
    assert "2 trials to train" in capsys.readouterr().out
    assert sweep.main([*command, "--seeds", "1,2"]) == 0
    assert "2 trials to train" in capsys.readouterr().out
    with (tmp_path / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["state"] for row in rows] == ["done"] * 4
    assert len({row["parameter_hash"] for row in rows}) == 4


def test_a_sweep_of_files_that_are_named_from_its_own_folder_trains_them(
    connected: Any, address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine.yaml").write_text("include: hover_learn\n")
    (tmp_path / "plugins").mkdir()
    monkeypatch.chdir(tmp_path)
    command = ["mine.yaml", "--plugin-path", "plugins", "--out", "sweep", "--address", address]
    command += ["--total-steps", "640", "--set", "envs=20", "--set", "rollout_steps=16"]
    command += ["--set", "minibatch=100", "--eval-episodes", "0"]
    assert sweep.main(command) == 0
    assert list(tmp_path.glob("sweep/mine-*/checkpoints/*/policy.h5"))


@pytest.mark.parametrize(
    ("program", "options", "said"),
    [
        (train, ["--ray", "local", "--workers", "9"], "--workers: 9 is out of range"),
        (train, ["--ray", "127.0.0.1:1"], "--ray 127.0.0.1:1: no Ray cluster there"),
        (train, ["--ray", "here"], "--ray here: write HOST:PORT"),
        (train, ["--ray", "local", "--set", "lerning_rate=1"], "did you mean `learning_rate`"),
        (train, ["--ray", "local", "--algo", "ppo"], "with --ray there is fast-ppo alone"),
        (sweep, ["--algo", "lean-ppo"], "the learner `lean-ppo` has gone: `fast-ppo`"),
        (sweep, ["--set", "lerning_rate=1,2"], "did you mean `learning_rate`"),
        (sweep, ["--set", "envs=16,16"], "two trials of this sweep are the same"),
        (sweep, ["--address", "127.0.0.1:1"], "no Ray cluster there"),
    ],
)
def test_a_wrong_option_is_one_message_and_leaves_nothing(
    program: Any,
    options: list[str],
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    out = tmp_path / "run"
    try:
        status = program.main(["hover_learn", "--out", str(out), *options])
    except SystemExit as end:  # of the command line
        status = end.code
    assert status == 2
    message = capsys.readouterr().err.splitlines()
    assert len(message) == 1 and said in message[0]
    assert not out.exists()


LOCAL = """
import os, subprocess, sys
from skybody.ray.cluster import cluster

JOIN = "import ray, sys; ray.init(sys.argv[1], logging_level='ERROR'); print('joined')"

def joins(address, **token):
    rest = {name: value for name, value in os.environ.items() if not name.startswith("RAY_")}
    command = [sys.executable, "-P", "-c", JOIN, address]
    done = subprocess.run(command, env={**rest, **token}, capture_output=True, text=True)
    return done.stdout == "joined\\n"

def where():
    import numpy
    return numpy.__version__

with cluster("local", cpus=1) as ray:
    print(ray.get(ray.remote(where).remote()))
    address = ray.get_runtime_context().gcs_address
    print(joins(address, RAY_AUTH_MODE="disabled"))
    print(joins(address, RAY_AUTH_MODE="token", RAY_AUTH_TOKEN="0" * 64))
    own = {name: os.environ[name] for name in ("RAY_AUTH_MODE", "RAY_AUTH_TOKEN")}
    print(joins(address, **own))
"""


@pytest.mark.timeout(300)  # each attempt to join takes Ray some tens of seconds
def test_a_local_cluster_is_its_owners_and_runs_no_files_of_the_working_folder(
    tmp_path: Path,
) -> None:
    (tmp_path / "numpy.py").write_text("raise SystemExit(3)")
    own = {name: value for name, value in os.environ.items() if not name.startswith("RAY_")}
    done = subprocess.run(
        [sys.executable, "-P", "-c", LOCAL],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**own, "HOME": str(tmp_path)},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [np.__version__, "False", "False", "True"]
    assert not (tmp_path / ".ray").exists()  # no token for other clusters
