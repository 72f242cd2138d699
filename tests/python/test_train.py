"""Training: one seed gives the same bits, also after kill -9; files describe their content."""

from __future__ import annotations

import dataclasses
import json
import math
import random
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import torch
from skybody._native import CompiledScenario, Network
from skybody.program import module_command
from skybody.train import evaluate, parameter_hash
from skybody.train.__main__ import main
from skybody.train.checkpoint import checkpoint_folders, read_checkpoint, read_meta
from skybody.train.native_learners import PARAMETERS
from skybody.train.policy_file import read_policy, write_policy
from skybody.train.run_folder import read_table
from skybody.train.sb3_ppo import Sb3Ppo
from training import HORIZON, ROLLOUTS, SCENARIO, arguments, both, finished_run, learner_of

pytestmark = pytest.mark.timeout(120)


@pytest.fixture(scope="module")
def compiled() -> CompiledScenario:
    return CompiledScenario(SCENARIO, [HORIZON])


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An uninterrupted run of `ppo`; test_train_command.py has those in C++."""
    run = tmp_path_factory.mktemp("whole") / "ppo"
    assert main(arguments("ppo", run)) == 0
    return run


def final_hash(run: Path) -> str:
    newest = read_meta(checkpoint_folders(run)[-1])
    assert newest["steps"] == 300 * ROLLOUTS
    return str(newest["parameter_hash"])


# --- the same bits ------------------------------------------------------------------------------


@both
def test_one_seed_gives_the_same_parameters_for_any_number_of_threads(
    algorithm: str, compiled: CompiledScenario
) -> None:
    hashes = []
    for seed, threads in ((1, 1), (1, 2), (2, 1)):
        with learner_of(algorithm, compiled, seed, threads) as learner:
            for _ in range(3):
                learner.iterate()
            hashes.append(parameter_hash(learner.parameters()))
    assert hashes[0] == hashes[1]
    assert hashes[0] != hashes[2]


@both
def test_training_changes_every_parameter(algorithm: str, compiled: CompiledScenario) -> None:
    with learner_of(algorithm, compiled) as learner:
        before = {name: np.asarray(value).copy() for name, value in learner.parameters().items()}
        learner.iterate()
        assert learner.steps == 300
        for name, value in learner.parameters().items():
            assert (np.asarray(value) != before[name]).any(), name


def test_parameter_hash_sees_every_bit_and_no_order() -> None:
    a, b = torch.tensor([1.0, 2.0]), torch.tensor([[0.5]])
    assert parameter_hash({"a": a, "b": b}) == parameter_hash({"b": b, "a": a.clone()})
    nearly = torch.tensor([1.0, math.nextafter(2.0, 3.0)], dtype=torch.float64).float()
    nearly[1] = torch.nextafter(torch.tensor(2.0), torch.tensor(3.0))
    assert parameter_hash({"a": a, "b": b}) != parameter_hash({"a": nearly, "b": b})


def test_a_run_killed_at_a_random_moment_ends_with_the_bits_of_one_that_was_not(
    whole: Path, tmp_path: Path
) -> None:
    killed = tmp_path / "killed"
    moment = random.Random()
    wanted, pause = moment.randint(1, ROLLOUTS // 4), moment.uniform(0.0, 0.02)
    print(f"killed {pause:.4f} s after checkpoint {wanted}")
    command = module_command("skybody.train", *arguments("ppo", killed))
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        while len(checkpoint_folders(killed)) < wanted and process.poll() is None:
            time.sleep(0.002)
        time.sleep(pause)
    finally:
        process.kill()
    assert process.wait() == -signal.SIGKILL
    reached = read_meta(checkpoint_folders(killed)[-1])["steps"]
    assert reached < 300 * ROLLOUTS

    assert main(["--resume", "--threads", "2", "--out", str(killed)]) == 0
    assert final_hash(killed) == final_hash(whole)
    for run in (whole, killed):
        steps = [int(row["steps"]) for row in read_table(run / "progress.csv")]
        assert steps == list(range(300, 300 * ROLLOUTS + 1, 300))


def test_an_interrupt_writes_a_checkpoint_that_goes_on_with_the_same_bits(
    whole: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    stopped = tmp_path / "stopped"
    iterate = Sb3Ppo.iterate

    def interrupted(self: Sb3Ppo) -> Any:
        if self.steps == 300 * 4:
            signal.raise_signal(signal.SIGINT)
        return iterate(self)

    with monkeypatch.context() as patch:
        patch.setattr(Sb3Ppo, "iterate", interrupted)
        assert main(arguments("ppo", stopped)) == 130
    assert "stopping after this rollout" in capsys.readouterr().err
    assert read_meta(checkpoint_folders(stopped)[-1])["steps"] == 300 * 5
    assert main(["--resume", "--out", str(stopped)]) == 0
    assert final_hash(stopped) == final_hash(whole)


def test_an_interrupt_while_the_curve_is_drawn_is_one_line_and_leaves_checkpoints_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(runs: list[Path], out: Path) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("skybody.train.curve.draw_curve", interrupted)
        command = arguments("fast-ppo", tmp_path)
        command[command.index("--total-steps") + 1] = "600"
        assert main(command) == 130
    said = capsys.readouterr().err
    assert said == "interrupted; --resume goes on from the newest checkpoint\n"
    for folder in checkpoint_folders(tmp_path):
        read_checkpoint(folder)
    assert main(["--resume", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "curve.png").exists()


# --- files --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run with evaluations."""
    return finished_run(tmp_path_factory.mktemp("train") / "run")


def test_checkpoints_are_stamped_with_scenario_versions_and_seed(
    run: Path, compiled: CompiledScenario
) -> None:
    expected_hash = f"{compiled.scenario_hash:016x}"
    folders = checkpoint_folders(run)
    assert [folder.name for folder in folders] == ["step_000000000600", "step_000000001200"]
    for folder in folders:
        meta = read_meta(folder)
        assert (meta["seed"], meta["scenario_name"], meta["algorithm"]) == (3, SCENARIO, "fast-ppo")
        assert meta["scenario_hash"] == expected_hash
        assert {"skybody", "python", "compiler"} <= meta["versions"].keys()
        state = read_checkpoint(folder).state["learner"]
        assert meta["parameter_hash"] == parameter_hash({name: state[name] for name in PARAMETERS})
        with h5py.File(folder / "policy.h5") as file:
            assert file.attrs["scenario_hash"].decode() == expected_hash
            assert (file.attrs["seed"], file.attrs["steps"]) == (3, meta["steps"])
            assert (file.attrs["observation_size"], file.attrs["action_size"]) == (22, 4)
    config = json.loads((run / "config.json").read_text())
    assert config["scenario_text"] == compiled.scenario_text
    assert config["hyper"]["hidden"] == [8, 8]


def test_a_run_has_its_tables_its_picture_and_an_evaluation_of_each_checkpoint(run: Path) -> None:
    progress = read_table(run / "progress.csv")
    assert [int(row["steps"]) for row in progress] == [300, 600, 900, 1200]
    shares = [
        float(progress[0][f"{part}_share"]) for part in ("environment", "inference", "update")
    ]
    assert sum(shares) == pytest.approx(1.0, abs=2e-4)  # three numbers with four decimals
    evaluations = read_table(run / "evaluation.csv")
    assert [int(row["steps"]) for row in evaluations] == [600, 1200]
    assert evaluations[0]["episodes"] == "3"
    assert (run / "curve.png").read_bytes().startswith(b"\x89PNG")
    assert list(run.glob("events.out.tfevents.*"))


def network_actions(learner: Any, observation: np.ndarray) -> np.ndarray:
    """The learner's own output, in single precision."""
    if isinstance(learner, Sb3Ppo):
        rows = learner.normalize.normalize_obs(observation)
        actions, _ = learner.model.predict(rows, deterministic=True)
        return actions
    state, bounded = learner.save().state, learner.policy().layers[-1].activation == "tanh"
    mean, variance = (state[f"moments.{name}"].view(np.float64) for name in ("mean", "variance"))
    rows = ((observation - mean) / np.sqrt(variance + 1e-8)).clip(-10.0, 10.0)
    network = Network(observation.shape[1], [8, 8], 4)
    weights = state["policy"].view(np.float32)[: network.parameter_count]
    actions = network.forward(weights, rows.astype(np.float32))
    return np.tanh(actions) if bounded else actions.clip(-1.0, 1.0)


@both
@pytest.mark.parametrize("bounded_mean", [False, True])
def test_policy_files_give_the_actions_of_the_network(
    algorithm: str, bounded_mean: bool, compiled: CompiledScenario, tmp_path: Path
) -> None:
    with learner_of(algorithm, compiled, bounded_mean=bounded_mean) as learner:
        for _ in range(3):
            learner.iterate()
        attributes = {"scenario": "", "scenario_hash": "", "algorithm": algorithm, "steps": 300}
        policy = dataclasses.replace(learner.policy(), attributes=attributes)
        write_policy(tmp_path / "policy.h5", policy)
        observation = np.random.default_rng(0).normal(0.0, 2.0, (200, 22)).astype(np.float32)
        expected = network_actions(learner, observation)
    actions = read_policy(tmp_path / "policy.h5")(observation)
    # float32 against float64 on the same float32 weights and inputs
    np.testing.assert_allclose(actions, expected, rtol=0, atol=1e-6)


def test_evaluations_repeat_and_an_episode_is_the_same_among_more(
    run: Path, compiled: CompiledScenario
) -> None:
    policy = read_policy(checkpoint_folders(run)[-1] / "policy.h5")
    few = evaluate.evaluate(compiled, policy, 3, seed=9, threads=1)
    many = evaluate.evaluate(compiled, policy, 8, seed=9, threads=2)
    other = evaluate.evaluate(compiled, policy, 3, seed=10, threads=1)
    assert many["returns"][:3] == few["returns"]
    assert many["position_errors"][:3] == few["position_errors"]
    assert other["returns"] != few["returns"]


def test_the_median_position_error_is_that_of_the_last_second() -> None:
    flights = evaluate.Flights(
        returns=np.array([10.0, 20.0, 30.0]),
        errors=np.array([0.1, 0.3, 0.2]),
        lengths=np.array([5, 5, 5]),
        failed=np.array([False, True, False]),
        info_names=["speed", "success"],
        info_sums=np.array([[5.0, 0.0], [10.0, 1.0], [15.0, 5.0]]),
        info_ends=np.array([[1.0, 0.0], [2.0, 1.0], [4.5, 1.0]]),
    )
    result = evaluate.summarize(flights)
    assert result["return_mean"] == 20.0
    assert result["return_cv"] == pytest.approx(math.sqrt(200.0 / 3.0) / 20.0)
    assert result["position_error_median"] == 0.2
    assert result["success_share"] == pytest.approx(2.0 / 3.0)
    assert result["reached_share"] == pytest.approx(2.0 / 3.0)
    assert result["infos"]["speed"] == {"mean": 2.0, "end": 2.5}
