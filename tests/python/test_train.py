"""Training: one seed, the same bits, also after kill -9; files that say what they are."""

from __future__ import annotations

import dataclasses
import json
import math
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest
import torch
from skybody._native import Environment
from skybody.train import evaluate, parameter_hash
from skybody.train.__main__ import main
from skybody.train.checkpoint import checkpoint_folders, read_checkpoint, read_meta
from skybody.train.lean_ppo import LeanPpo, RunningMoments
from skybody.train.policy_file import read_policy, write_policy
from skybody.train.presets import Hyperparameters, UsageError, preset, with_settings
from skybody.train.run_folder import read_table
from skybody.train.sb3_ppo import Sb3Ppo

SCENARIO = "hover_learn"
HORIZON = "stepping.horizon=40"  # so that episodes are truncated within a rollout
SMALL = Hyperparameters(envs=6, rollout_steps=50, minibatch=100, epochs=2, hidden=(8, 8))
LEARNERS: dict[str, Callable[..., Any]] = {"ppo": Sb3Ppo, "lean-ppo": LeanPpo}
ROLLOUTS = 30

both = pytest.mark.parametrize("algorithm", LEARNERS)
pytestmark = pytest.mark.timeout(120)


@pytest.fixture(scope="module")
def environment() -> Environment:
    return Environment(SCENARIO, [HORIZON])


@contextmanager
def learner_of(
    algorithm: str,
    environment: Environment,
    seed: int = 1,
    threads: int = 1,
    hyper: Hyperparameters = SMALL,
) -> Iterator[Any]:
    made = LEARNERS[algorithm](environment, hyper, seed, threads, 10_000)
    try:
        yield made
    finally:
        made.close()


def arguments(algorithm: str, out: Path) -> list[str]:
    """A run of ROLLOUTS rollouts with a checkpoint after each second one."""
    command = [
        SCENARIO,
        "--algo",
        algorithm,
        "--seed",
        "3",
        "--out",
        str(out),
        "--override",
        HORIZON,
    ]
    command += ["--total-steps", str(300 * ROLLOUTS), "--checkpoint-every", "600"]
    command += ["--eval-episodes", "0", "--threads", "1", "--envs", "6"]
    for setting in ("rollout_steps=50", "minibatch=100", "epochs=2", "hidden=8,8"):
        command += ["--set", setting]
    return command


@pytest.fixture(scope="module")
def whole_run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """A run of an algorithm that was not interrupted, made once."""
    made: dict[str, Path] = {}

    def run_of(algorithm: str) -> Path:
        if algorithm not in made:
            made[algorithm] = tmp_path_factory.mktemp("whole") / algorithm
            assert main(arguments(algorithm, made[algorithm])) == 0
        return made[algorithm]

    return run_of


def final_hash(run: Path) -> str:
    newest = read_meta(checkpoint_folders(run)[-1])
    assert newest["steps"] == 300 * ROLLOUTS
    return str(newest["parameter_hash"])


# --- the same bits ------------------------------------------------------------------------------


@both
def test_one_seed_gives_the_same_parameters_for_any_number_of_threads(
    algorithm: str, environment: Environment
) -> None:
    hashes = []
    for seed, threads in ((1, 1), (1, 2), (2, 1)):
        with learner_of(algorithm, environment, seed, threads) as learner:
            for _ in range(3):
                learner.iterate()
            hashes.append(parameter_hash(learner.parameters()))
    assert hashes[0] == hashes[1]
    assert hashes[0] != hashes[2]


@both
def test_training_changes_every_parameter(algorithm: str, environment: Environment) -> None:
    with learner_of(algorithm, environment) as learner:
        before = {name: value.clone() for name, value in learner.parameters().items()}
        learner.iterate()
        assert learner.steps == 300
        for name, value in learner.parameters().items():
            assert not torch.equal(value, before[name]), name


def test_parameter_hash_sees_every_bit_and_no_order() -> None:
    a, b = torch.tensor([1.0, 2.0]), torch.tensor([[0.5]])
    assert parameter_hash({"a": a, "b": b}) == parameter_hash({"b": b, "a": a.clone()})
    nearly = torch.tensor([1.0, math.nextafter(2.0, 3.0)], dtype=torch.float64).float()
    nearly[1] = torch.nextafter(torch.tensor(2.0), torch.tensor(3.0))
    assert parameter_hash({"a": a, "b": b}) != parameter_hash({"a": nearly, "b": b})


@both
def test_a_run_killed_at_a_random_moment_ends_with_the_bits_of_one_that_was_not(
    algorithm: str, whole_run: Callable[[str], Path], tmp_path: Path
) -> None:
    whole, killed = whole_run(algorithm), tmp_path / "killed"
    moment = random.Random()
    wanted, pause = moment.randint(1, ROLLOUTS // 4), moment.uniform(0.0, 0.02)
    print(f"killed {pause:.4f} s after checkpoint {wanted}")
    command = [sys.executable, "-m", "skybody.train", *arguments(algorithm, killed)]
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
    whole_run: Callable[[str], Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    stopped = tmp_path / "stopped"
    iterate = LeanPpo.iterate

    def interrupted(self: LeanPpo) -> Any:
        if self.steps == 300 * 4:
            signal.raise_signal(signal.SIGINT)
        return iterate(self)

    with monkeypatch.context() as patch:
        patch.setattr(LeanPpo, "iterate", interrupted)
        assert main(arguments("lean-ppo", stopped)) == 130
    assert "stopping after this rollout" in capsys.readouterr().err
    assert read_meta(checkpoint_folders(stopped)[-1])["steps"] == 300 * 5
    assert main(["--resume", "--out", str(stopped)]) == 0
    assert final_hash(stopped) == final_hash(whole_run("lean-ppo"))


# --- learning from the right things -------------------------------------------------------------


class ScriptedPool:
    """Three environments whose episodes end in the first step: terminated, truncated, faulted."""

    def __init__(self, observations: int) -> None:
        self.step = 0
        self.observation = np.zeros((3, observations), np.float32)

    def send(self, actions: np.ndarray) -> None:
        assert actions.flags.c_contiguous and actions.dtype == np.float32

    def recv(self) -> SimpleNamespace:
        first, self.step = self.step == 0, self.step + 1
        return SimpleNamespace(
            observation=self.observation,
            final_observation=self.observation + 1.0,
            info=np.zeros((3, 1), np.float32),
            reward=np.array([1.0, 1.0, 0.0], np.float32),
            terminated=np.array([first, False, False]),
            truncated=np.array([False, first, first]),
            fault=np.array([False, False, first]),
        )

    def close(self) -> None:
        pass


def test_lean_ppo_bootstraps_truncations_from_the_last_observation_and_nothing_else(
    environment: Environment,
) -> None:
    hyper = dataclasses.replace(
        SMALL, envs=3, rollout_steps=1, minibatch=3, normalize_rewards=False, discount=0.5
    )
    with learner_of("lean-ppo", environment, hyper=hyper) as learner:
        learner.pool.close()
        learner.pool = ScriptedPool(environment.observation_size)
        learner.observation = learner.pool.observation
        # the value of an observation: 2 plus its first entry
        learner.critic = torch.nn.Sequential(torch.nn.Linear(environment.observation_size, 1))
        with torch.no_grad():
            learner.critic[0].weight.zero_()
            learner.critic[0].weight[0, 0] = 1.0
            learner.critic[0].bias.fill_(2.0)
        learner.mean, learner.scale = learner.moments.mean, torch.ones_like(learner.moments.mean)
        with torch.no_grad():
            truncations = learner._collect(
                SimpleNamespace(episode_returns=[], faults=0, environment_seconds=0.0)
            )
        _, returns = learner._advantages(truncations)
        # terminated: the reward; truncated: reward + 0.5 * (2 + 1); fault: nothing
        assert returns.tolist() == [[1.0, 2.5, 0.0]]


class Recorded:
    """A pool whose send_reset() is another function."""

    def __init__(self, pool: Any, send_reset: Callable[[Any], Any]) -> None:
        self._pool, self.send_reset = pool, send_reset

    def __getattr__(self, name: str) -> Any:
        return getattr(self._pool, name)


class Poisoned:
    """A pool to which environment 5's actions come as NaN."""

    def __init__(self, pool: Any) -> None:
        self._pool = pool

    def __getattr__(self, name: str) -> Any:
        return getattr(self._pool, name)

    def send(self, actions: np.ndarray, *others: Any) -> None:
        poisoned = actions.copy()
        poisoned[5] = math.nan
        self._pool.send(poisoned, *others)


@both
def test_an_environment_of_64_that_faults_in_every_step_leaves_the_weights_finite(
    algorithm: str, environment: Environment
) -> None:
    hyper = dataclasses.replace(SMALL, envs=64, rollout_steps=16, minibatch=256)
    with learner_of(algorithm, environment, hyper=hyper) as learner:
        owner = learner if algorithm == "lean-ppo" else learner.vec_env
        owner.pool = Poisoned(owner.pool)
        for _ in range(3):
            assert learner.iterate().faults == 16
        for name, value in learner.parameters().items():
            assert bool(value.isfinite().all()), name


def test_lean_ppo_spreads_episodes_over_the_horizon(environment: Environment) -> None:
    hyper = dataclasses.replace(SMALL, envs=8, rollout_steps=10, minibatch=40)
    with learner_of("lean-ppo", environment, hyper=hyper) as learner:
        starts = []
        send_reset = learner.pool.send_reset
        learner.pool = Recorded(learner.pool, lambda mask: (starts.append(mask), send_reset(mask)))
        for _ in range(8):
            learner.iterate()
        # horizon 40: groups of 2 environments begin at 0 (all do), 10, 20 and 30 steps
        assert [np.flatnonzero(mask).tolist() for mask in starts] == [[2, 3], [4, 5], [6, 7]]


def test_running_moments_are_those_of_all_rows() -> None:
    rows = torch.from_numpy(np.random.default_rng(0).normal(3.0, 2.0, (500, 4)))
    moments = RunningMoments(4)
    for part in rows.split(120):
        moments.update(part)
    # float64 sums of 500 terms: some 500 rounding errors of 1e-16, relative
    torch.testing.assert_close(moments.mean, rows.mean(0), rtol=1e-12, atol=0)
    torch.testing.assert_close(moments.var, rows.var(0, correction=0), rtol=1e-12, atol=0)


# --- files --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run with evaluations."""
    out = tmp_path_factory.mktemp("train") / "run"
    command = arguments("lean-ppo", out)
    command[command.index("--total-steps") + 1] = "1200"
    command[command.index("--eval-episodes") + 1] = "3"
    assert main(command) == 0
    return out


def test_checkpoints_are_stamped_with_scenario_versions_and_seed(
    run: Path, environment: Environment
) -> None:
    expected_hash = f"{environment.scenario_hash:016x}"
    folders = checkpoint_folders(run)
    assert [folder.name for folder in folders] == ["step_000000000600", "step_000000001200"]
    for folder in folders:
        meta = read_meta(folder)
        assert (meta["seed"], meta["scenario_name"], meta["algorithm"]) == (3, SCENARIO, "lean-ppo")
        assert meta["scenario_hash"] == expected_hash
        assert {"skybody", "torch", "numpy", "python"} <= meta["versions"].keys()
        state = read_checkpoint(folder).state["learner"]
        assert meta["parameter_hash"] == parameter_hash(state["parameters"])
        with h5py.File(folder / "policy.h5") as file:
            assert file.attrs["scenario_hash"] == expected_hash
            assert (file.attrs["seed"], file.attrs["steps"]) == (3, meta["steps"])
            assert (file.attrs["observation_size"], file.attrs["action_size"]) == (22, 4)
    config = json.loads((run / "config.json").read_text())
    assert config["scenario_text"] == environment.scenario_text
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


@both
def test_policy_files_give_the_actions_of_the_network(
    algorithm: str, environment: Environment, tmp_path: Path
) -> None:
    with learner_of(algorithm, environment) as learner:
        for _ in range(3):
            learner.iterate()
        write_policy(tmp_path / "policy.h5", learner.policy())
        observation = np.random.default_rng(0).normal(0.0, 2.0, (200, 22)).astype(np.float32)
        with torch.no_grad():
            if algorithm == "ppo":
                rows = learner.normalize.normalize_obs(observation)
                expected, _ = learner.model.predict(rows, deterministic=True)
            else:
                learner.mean, learner.scale = learner.moments.mean, learner.moments.scale()
                rows = learner._normalized(torch.from_numpy(observation))
                expected = learner.actor(rows).clamp(-1.0, 1.0).numpy()
    actions = read_policy(tmp_path / "policy.h5")(observation)
    # float32 against float64 on the same float32 weights and inputs
    np.testing.assert_allclose(actions, expected, rtol=0, atol=1e-6)


def test_evaluations_repeat_and_an_episode_is_the_same_among_more(
    run: Path, environment: Environment
) -> None:
    policy = read_policy(checkpoint_folders(run)[-1] / "policy.h5")
    few = evaluate.evaluate(environment, policy, 3, seed=9, threads=1)
    many = evaluate.evaluate(environment, policy, 8, seed=9, threads=2)
    other = evaluate.evaluate(environment, policy, 3, seed=10, threads=1)
    assert many["returns"][:3] == few["returns"]
    assert many["position_errors"][:3] == few["position_errors"]
    assert other["returns"] != few["returns"]


def test_the_median_position_error_is_that_of_the_last_second() -> None:
    result = evaluate.summarize(
        np.array([10.0, 20.0, 30.0]),
        np.array([0.1, 0.3, 0.2]),
        np.array([5, 5, 5]),
        np.array([False, True, False]),
    )
    assert result["return_mean"] == 20.0
    assert result["return_cv"] == pytest.approx(math.sqrt(200.0 / 3.0) / 20.0)
    assert result["position_error_median"] == 0.2
    assert result["success_share"] == pytest.approx(2.0 / 3.0)


# --- bad input ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (["--set", "rate=3"], "no hyper-parameter `rate`"),
        (["--set", "epochs=many"], "`many` is not an integer"),
        (["--set", "hidden=a"], "`a` is not sizes as 64,64"),
        (["--set", "epochs"], "write KEY=VALUE"),
        (["--set", "discount=1.5"], "hyper-parameter discount = 1.5: allowed is 0 to 1"),
        (["--envs", "0"], "hyper-parameter envs = 0: allowed is at least 1"),
        (["--total-steps", "0"], "--total-steps 0: at least 1"),
        (["--seed", str(2**32)], "--seed 4294967296: at most 4294967295"),
    ],
)
def test_wrong_options_are_one_clear_message(
    changes: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*arguments("lean-ppo", tmp_path / "run"), *changes]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_an_unknown_scenario_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["no_such_scenario", "--out", str(tmp_path / "run")]) == 2
    assert "no_such_scenario" in capsys.readouterr().err


def test_a_folder_that_holds_something_is_not_overwritten(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments("lean-ppo", run)) == 2
    assert "not empty" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--seed", "4"], "begun with seed 3, not 4"),
        (["--algo", "ppo"], "begun with algorithm lean-ppo, not ppo"),
        (["--set", "epochs=3"], "leave --set and --envs out"),
    ],
)
def test_a_run_is_resumed_with_its_own_options(
    options: list[str], message: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--resume", "--out", str(run), *options]) == 2
    assert message in capsys.readouterr().err


def test_there_must_be_a_run_to_resume(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--resume", "--out", str(tmp_path)]) == 2
    assert "no run to go on with" in capsys.readouterr().err


def test_a_damaged_checkpoint_is_named(run: Path) -> None:
    folder = checkpoint_folders(run)[0]
    path = folder / "environments.bin"
    whole = path.read_bytes()
    try:
        path.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
        with pytest.raises(ValueError, match=r"environments\.bin is damaged"):
            read_checkpoint(folder)
    finally:
        path.write_bytes(whole)


def test_presets_are_consistent() -> None:
    for algorithm in LEARNERS:
        preset(SCENARIO, algorithm).check()
    with pytest.raises(UsageError, match="minibatch"):
        with_settings(preset(SCENARIO, "ppo"), ["minibatch=1"]).check()
