"""Tasks written in Python, as a Gymnasium vector environment and for Stable-Baselines3."""

from __future__ import annotations

import re

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box
from numpy.typing import NDArray
from skybody.python_task import PythonTask, PythonTaskVectorEnv
from skybody.simulation import EnvStates, Simulation, SimulationPool

N = 4


class Climb(PythonTask):
    """Observation and reward are the height; episodes end above 3 m."""

    control = "ctbr"
    physics_steps = 20
    horizon = 30
    observation_space = Box(-np.inf, np.inf, (2,), np.float32)
    action_space = Box(-1, 1, (1,), np.float32)

    def setup(self, pool: SimulationPool) -> None:
        self.begun: list[list[int]] = []

    def begin(
        self, pool: SimulationPool, envs: NDArray[np.int32], rng: np.random.Generator
    ) -> None:
        self.begun.append(envs.tolist())
        for world in envs.tolist():
            pool.teleport(world, position=[0, 0, rng.uniform(1, 2.5)], rotation=[1, 0, 0, 0])

    def command(self, actions: NDArray[np.float32], states: EnvStates) -> NDArray[np.float64]:
        return np.pad(15 * (1 + actions), ((0, 0), (0, 3)))

    def observation(self, states: EnvStates) -> NDArray[np.float64]:
        return np.stack([states.positions[:, 0, 2], states.velocities[:, 0, 2]], axis=1)

    def reward(self, states: EnvStates, actions: NDArray[np.float32]) -> NDArray[np.float64]:
        return states.positions[:, 0, 2]

    def terminated(self, states: EnvStates) -> NDArray[np.bool_]:
        return states.positions[:, 0, 2] > 3


def climb(task: PythonTask | None = None, **options: object) -> PythonTaskVectorEnv:
    return PythonTaskVectorEnv(task or Climb(), "hover", N, seed=5, **options)  # type: ignore[arg-type]


def up(value: float = 1.0) -> NDArray[np.float32]:
    return np.full((N, 1), value, np.float32)


def test_a_step_is_the_command_held_for_the_physics_steps():
    envs = climb()
    first, _ = envs.reset()
    snapshots = [envs.pool.save(i) for i in range(N)]
    observation, reward, terminated, truncated, info = envs.step(up(0.2))
    world = Simulation("hover", "ctbr")
    for i in range(N):
        world.restore(snapshots[i])
        assert first[i, 0] == np.float32(world.base().position[2])
        world.command([15 * np.float32(1.2), 0, 0, 0])
        world.advance(20)
        assert observation[i, 0] == np.float32(world.base().position[2])
        assert reward[i] == np.float32(world.base().position[2])
    assert not (terminated | truncated | info["fault"]).any()
    envs.close()


def test_next_step_resets_ended_environments_instead_of_stepping_them():
    envs = climb()
    envs.reset()
    ended = np.zeros(N, np.bool_)
    for _ in range(90):
        observation, reward, terminated, truncated, _ = envs.step(up())
        assert (reward[ended] == 0).all()
        assert (envs.pool.states().times[ended] == 0).all()
        assert not (terminated | truncated)[ended].any()
        assert (observation[ended, 1] == 0).all()  # at rest
        ended = terminated | truncated
    assert len(envs.task.begun) > 3
    envs.close()


def test_the_horizon_truncates_and_the_end_terminates():
    envs = climb()
    envs.reset()
    for step in range(1, 31):
        _, _, terminated, truncated, _ = envs.step(up(-1.0))  # falls
        assert not terminated.any()
        assert truncated.all() == (step == 30)
    envs.reset()
    for _ in range(29):
        _, _, terminated, truncated, _ = envs.step(up())
        assert not truncated.any()
        if terminated.any():
            break
    assert terminated.any()
    envs.close()


def test_same_step_gives_the_last_observation_apart():
    envs = climb(autoreset="same_step")
    envs.reset()
    seen = 0
    for _ in range(60):
        observation, _, terminated, truncated, info = envs.step(up())
        ended = terminated | truncated
        for i in np.flatnonzero(ended):
            assert info["final_obs"][i][1] > 1  # still climbing
            assert observation[i, 1] == 0  # the next episode, at rest
            seen += 1
        if ended.any():
            np.testing.assert_array_equal(info["_final_obs"], ended)
    assert seen > 0
    envs.close()


def test_same_step_tells_infos_of_the_end_apart_from_those_of_the_next_episode():
    class Tells(Climb):
        def info(self, states: EnvStates) -> dict[str, NDArray[np.float64]]:
            return {"speed": states.velocities[:, 0, 2]}

    envs = climb(Tells(), autoreset="same_step")
    envs.reset()
    ended = np.zeros(N, np.bool_)
    while not ended.any():
        observation, _, terminated, truncated, info = envs.step(up())
        ended = terminated | truncated
    last = info["final_info"]
    np.testing.assert_array_equal(last["_speed"], ended)
    for i in np.flatnonzero(ended):
        assert last["speed"][i] == pytest.approx(info["final_obs"][i][1])  # still climbing
        assert info["speed"][i] == observation[i, 1] == 0
    envs.close()


def test_disabled_wants_a_reset_by_mask():
    envs = climb(autoreset="disabled")
    envs.reset()
    for _ in range(30):
        _, _, terminated, truncated, _ = envs.step(up())
        ended = terminated | truncated
        if ended.any():
            break
    with pytest.raises(ValueError, match="reset_mask"):
        envs.step(up())
    before = envs.pool.states().positions
    envs.reset(options={"reset_mask": ended})
    np.testing.assert_array_equal(envs.pool.states().positions[~ended], before[~ended])
    envs.step(up())
    with pytest.raises(ValueError, match="reset_mask"):
        envs.reset(options={"reset_mask": np.ones(N + 1, np.bool_)})
    with pytest.raises(ValueError, match="unknown reset option `mask`"):
        envs.reset(options={"mask": ended})
    envs.close()


def test_seeds_repeat_bit_for_bit():
    def play(envs: PythonTaskVectorEnv, seed: int | None) -> NDArray[np.float32]:
        rows = [envs.reset(seed=seed)[0]]
        rows += [envs.step(up(0.5))[0] for _ in range(80)]
        return np.stack(rows)

    envs, other = climb(), climb()
    first = play(envs, 11)
    np.testing.assert_array_equal(play(envs, 11), first)
    np.testing.assert_array_equal(play(other, 11), first)
    assert not np.array_equal(play(other, 12), first)
    envs.close()
    other.close()


def test_a_non_finite_action_or_outcome_faults_its_world_only():
    class Breaks(Climb):
        broken = False

        def observation(self, states: EnvStates) -> NDArray[np.float64]:
            rows = super().observation(states)
            if self.broken:
                rows[2] = np.inf
            return rows

    task = Breaks()
    envs = climb(task)
    envs.reset()
    actions = up(0.1)
    actions[0] = np.nan
    observation, reward, terminated, truncated, info = envs.step(actions)
    assert info["fault"].tolist() == truncated.tolist() == [True, False, False, False]
    assert reward[0] == 0
    assert np.isfinite(observation).all()
    task.broken = True
    observation, reward, terminated, truncated, info = envs.step(up(0.1))
    assert info["fault"].tolist() == [False, False, True, False]
    assert np.isfinite(observation).all()
    assert not terminated.any()
    envs.close()


@pytest.mark.parametrize("method", ["begin", "command", "observation", "reward", "terminated"])
def test_an_exception_in_the_task_reaches_the_caller_and_the_pool_can_be_closed(method: str):
    class Fails(Climb):
        fails = False

    def fail(self: Fails, *arguments: object) -> object:
        if self.fails:
            raise ZeroDivisionError(f"in {method}")
        return getattr(Climb, method)(self, *arguments)

    setattr(Fails, method, fail)
    task = Fails()
    envs = climb(task, autoreset="same_step")
    envs.reset()
    task.fails = True
    with pytest.raises(ZeroDivisionError, match=method):
        for _ in range(60):
            envs.step(up())
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(up())
    task.fails = False
    envs.reset()  # after the repair it continues
    envs.step(up())
    task.fails = True
    with pytest.raises(ZeroDivisionError):
        for _ in range(60):
            envs.step(up())
    envs.close()
    assert envs.pool.closed


def test_an_exception_in_setup_closes_the_pool():
    class Fails(Climb):
        def setup(self, pool: SimulationPool) -> None:
            self.pool = pool
            raise KeyError("mass")

    task = Fails()
    with pytest.raises(KeyError):
        climb(task)
    assert task.pool.closed


def test_arrays_of_another_shape_are_refused_by_name():
    class Wrong(Climb):
        def reward(self, states: EnvStates, actions: NDArray[np.float32]) -> float:
            return 1.0

    envs = climb(Wrong())
    envs.reset()
    with pytest.raises(ValueError, match=r"reward\(\) has shape \(\); expected \("):
        envs.step(up())
    envs.reset()
    with pytest.raises(ValueError, match=r"actions has shape \("):
        envs.step(np.zeros(N, np.float32))
    envs.close()
    with pytest.raises(gymnasium.error.ResetNeeded):
        climb().step(up())
    with pytest.raises(ValueError, match="autoreset is 'never'"):
        climb(autoreset="never")


@pytest.mark.parametrize("shape", [(N, 3), (N,), (), (1, 4)])
def test_a_command_of_another_shape_is_refused_by_name(shape: tuple[int, ...]):
    class Wrong(Climb):
        def command(self, actions: NDArray[np.float32], states: EnvStates) -> NDArray[np.float64]:
            return np.zeros(shape)

    envs = climb(Wrong())
    envs.reset()
    found = re.escape(f"command() has shape {shape}; expected ({N}, 4)")
    with pytest.raises(ValueError, match=found):
        envs.step(up())
    envs.close()


def test_commands_of_several_robots_are_refused_with_their_names():
    class Stays(Climb):
        def begin(self, *_: object) -> None:
            pass

    envs = PythonTaskVectorEnv(Stays(), "collision", N)
    envs.reset()
    with pytest.raises(ValueError, match="left, right"):
        envs.step(up())
    envs.close()


def test_stable_baselines_gets_terminal_observations_and_trains():
    pytest.importorskip("stable_baselines3")
    from skybody.sb3_adapter import VectorEnvForSb3
    from stable_baselines3 import PPO

    with pytest.raises(ValueError, match="same_step"):
        VectorEnvForSb3(climb())
    envs = VectorEnvForSb3(climb(autoreset="same_step"))
    envs.reset()
    seen = {True: 0, False: 0}
    for step in range(70):
        _, reward, dones, infos = envs.step(up(1.0 if step < 35 else -1.0))
        assert reward.dtype == np.float32
        for done, info in zip(dones, infos, strict=True):
            assert done == ("terminal_observation" in info)
            if done:
                seen[info["TimeLimit.truncated"]] += 1
    assert seen[True] > 0  # fell until the horizon
    assert seen[False] > 0  # left at the top
    model = PPO("MlpPolicy", envs, n_steps=32, batch_size=64, seed=1, device="cpu")
    model.learn(256)
    envs.close()


def test_actions_and_rewards_are_float32_and_nothing_is_converted_silently():
    envs = climb()
    envs.reset()
    with pytest.raises(TypeError, match="actions has dtype float64; expected float32: convert"):
        envs.step(np.zeros((N, 1)))
    with pytest.raises(TypeError, match="expected float32"):
        envs.step([[0.0]] * N)  # type: ignore[arg-type]
    _, reward, *_ = envs.step(up(0.1))  # and no transition was lost
    assert reward.dtype == np.float32
    envs.close()


def test_a_reward_that_float32_cannot_hold_is_a_fault():
    class Huge(Climb):
        def reward(self, states: EnvStates, actions: NDArray[np.float32]) -> NDArray[np.float64]:
            return np.array([1e300, 1, 1, 1])

    envs = climb(Huge())
    envs.reset()
    _, reward, _, _, info = envs.step(up(0.1))
    assert info["fault"].tolist() == [True, False, False, False]
    assert reward.tolist() == [0, 1, 1, 1]
    envs.close()


def test_a_class_or_another_object_is_no_task():
    with pytest.raises(TypeError, match=r"task is the class Climb; give an object: Climb\(\)"):
        PythonTaskVectorEnv(Climb, "hover", N)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="task is a int; it must be an object of a class that"):
        PythonTaskVectorEnv(3, "hover", N)  # type: ignore[arg-type]


@pytest.mark.parametrize("method", ["command", "observation", "reward"])
def test_a_method_that_a_task_lacks_is_named_with_its_class(method: str):
    class Lacks(Climb):
        pass

    setattr(Lacks, method, getattr(PythonTask, method))
    envs = climb(Lacks())
    with pytest.raises(NotImplementedError, match=f"Lacks has no method `{method}`: define Lacks"):
        envs.reset()
        envs.step(up())
    envs.close()


@pytest.mark.parametrize("space", ["observation_space", "action_space"])
def test_a_space_that_a_task_lacks_is_named_with_its_class(space: str):
    class Spaceless(PythonTask):
        observation_space = Climb.observation_space
        action_space = Climb.action_space

    delattr(Spaceless, space)
    with pytest.raises(TypeError, match=f"Spaceless has no `{space}`"):
        climb(Spaceless())


class Blind(Climb):
    """Observes NaN once an episode has ended."""

    blind = False

    def observation(self, states: EnvStates) -> NDArray[np.float64]:
        return np.where(self.blind, np.nan, super().observation(states))


@pytest.mark.parametrize("autoreset", ["next_step", "same_step"])
def test_an_episode_does_not_begin_with_an_observation_that_is_not_finite(autoreset: str):
    task = Blind()
    envs = climb(task, autoreset=autoreset)
    envs.reset()
    with pytest.raises(ValueError, match="the first observation of environment 0 is not finite"):
        for _ in range(3):  # a NaN observation ends the episode as a fault
            task.blind = True
            envs.step(up(0.2))
    task.blind = False
    assert np.isfinite(envs.reset()[0]).all()
    envs.close()
