"""The state of a batch by path, for all classes that hold several environments."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
import skybody
from gymnasium.spaces import Box
from skybody.python_task import PythonTask, PythonTaskVectorEnv
from skybody.simulation import Simulation, SimulationPool

N = 37
PATHS = {
    "robots.quad.base.position": (3,),
    "robots.quad.base.rotation": (4,),
    "robots.quad.links.bob.velocity": (3,),
    "robots.quad.links.rotor_front_left.angular_velocity": (3,),
    "robots.quad.joints.rod_joint.position": (4,),
    "robots.quad.joints.rod_joint.velocity": (3,),
    "robots.quad.rotors.speed": (4,),
    "robots.quad.rotors[0].speed": (),
    "robots.quad.links.bob.mass": (),
    "bodies.position": (3, 3),
    "command": (4,),
    "time": (),
    "steps": (),
}


def sims_alone(steps: int) -> list[Simulation]:
    sims = [Simulation("payload", seed=4, env_id=i) for i in range(N)]
    for i, sim in enumerate(sims):
        sim.reset()
        for _ in range(steps):
            sim.step(np.full(4, 0.01 * (i % 7), np.float32))
    return sims


def actions() -> np.ndarray:
    return np.repeat(np.float32(0.01) * (np.arange(N, dtype=np.float32) % 7), 4).reshape(N, 4)


def check(owner, sims: list[Simulation]) -> None:
    for path, shape in PATHS.items():
        values = owner.state(path)
        assert values.shape == (len(sims), *shape)
        assert values.dtype == np.float64
        assert owner.state_paths()[path].shape == shape
        np.testing.assert_array_equal(values, [sim.state(path) for sim in sims])


def test_a_vector_environment_gives_the_state_of_each_environment_alone():
    with_threads = [skybody.make_vec("payload", N, seed=4, num_threads=k) for k in (1, 2)]
    sims = [Simulation("payload", seed=4, env_id=i) for i in range(N)]
    for sim in sims:
        sim.reset()
    rows = actions()
    for envs in with_threads:
        envs.reset()
    for _ in range(6):
        for envs in with_threads:
            envs.step(rows)
        for sim, row in zip(sims, rows, strict=True):
            sim.step(row)
    for envs in with_threads:
        check(envs, sims)
        envs.close()


def test_the_values_of_a_simulation_are_those_it_has_names_for():
    sim = sims_alone(5)[3]
    base = sim.base()
    np.testing.assert_array_equal(sim.state("robots.quad.base.position"), base.position)
    np.testing.assert_array_equal(sim.state("robots.quad.base.rotation"), base.rotation)
    np.testing.assert_array_equal(
        sim.state("robots.quad.links.bob.position"), sim.body("bob").position
    )
    np.testing.assert_array_equal(sim.state("robots.quad.rotors.speed"), sim.rotor_speeds)
    assert sim.state("time").shape == ()
    assert sim.state("time") == sim.time
    for path in sim.compiled.param_paths:
        assert sim.state(path) == sim.param(path)


def test_a_pool_gives_it_at_rest_and_refuses_it_in_flight():
    pool = skybody.make_pool("payload", 6, batch_size=2, seed=4)
    with pytest.raises(ValueError, match="environment 0, which has not begun an episode"):
        pool.state("time")
    pool.async_reset()
    with pytest.raises(skybody.Error, match="6 environments are in flight: recv"):
        pool.state("time")
    for _ in range(3):
        pool.recv()
    assert pool.state("robots.quad.base.position").shape == (6, 3)
    assert (pool.state("episode") == 1).all()
    pool.close()


def test_an_ended_episode_shows_its_last_state_until_the_reset():
    envs = skybody.make_vec("hover", 2, overrides=["stepping.horizon=3"])
    envs.reset()
    for _ in range(3):
        *_, truncated, _ = envs.step(np.zeros((2, 4), np.float32))
    assert truncated.all()
    assert (envs.state("steps") == 3).all()
    envs.step(np.zeros((2, 4), np.float32))
    assert (envs.state("steps") == 0).all()
    envs.close()


def test_sensors_and_contacts_are_there_where_the_scenario_has_them():
    envs = skybody.make_vec("hover", 3, overrides=["sensors=[{plugin: imu}]"])
    envs.reset()
    envs.step(np.zeros((3, 4), np.float32))
    rates = envs.state("sensors.imu.angular_rate")
    assert rates.shape == (3, 3)
    assert envs.state_paths()["sensors.imu.angular_rate"].unit == "rad/s"
    assert not any(".contact." in path for path in envs.state_paths())
    envs.close()


class Watch(PythonTask):
    control = "ctbr"
    physics_steps = 5
    observation_space = Box(-np.inf, np.inf, (1,), np.float32)
    action_space = Box(-1, 1, (1,), np.float32)

    def setup(self, pool: SimulationPool) -> None:
        self.pool = pool

    def command(self, actions, states):
        return np.pad(15 * (1 + actions), ((0, 0), (0, 3)))

    def observation(self, states):
        return self.pool.state("robots.quad.base.position")[:, 2:]

    def reward(self, states, actions):
        return self.pool.state("robots.quad.rotors[1].speed")


def test_python_tasks_and_their_pool_give_it():
    envs = PythonTaskVectorEnv(Watch(), "hover", 4, seed=2)
    observation, _ = envs.reset()
    observation, reward, *_ = envs.step(np.full((4, 1), 0.1, np.float32))
    heights = envs.state("robots.quad.base.position")[:, 2]
    np.testing.assert_array_equal(observation[:, 0], heights.astype(np.float32))
    np.testing.assert_array_equal(reward, envs.state("rotor_speed")[:, 1].astype(np.float32))
    np.testing.assert_array_equal(
        envs.pool.state("robots.quad.base.position", [2, 0])[:, 2], heights[[2, 0]]
    )
    assert envs.state_paths().keys() == envs.pool.state_paths().keys()
    envs.close()


@pytest.mark.parametrize("path", ["robots.quad.base.positon", "robots.quad.bse.position"])
def test_a_wrong_path_is_one_error_with_the_nearest_names(path):
    envs = skybody.make_vec("hover", 2)
    envs.reset()
    for owner in (envs, Simulation("hover"), SimulationPool("hover", 2)):
        with pytest.raises(
            ValueError, match=r"did you mean `robots\.quad\.base\.position`\?.* has"
        ):
            owner.state(path)
    envs.close()


def test_every_path_has_a_unit_a_frame_and_a_shape_that_hold():
    for scenario in ("hover", "payload", "formation"):
        envs = skybody.make_vec(scenario, 2)
        envs.reset()
        for path, value in envs.state_paths().items():
            assert value.path == path
            assert value.frame in ("", "W", "B", "W from B")
            assert envs.state(path).shape == (2, *value.shape)
        envs.close()


def test_the_gymnasium_id_gives_it_too():
    envs = gymnasium.make_vec("skybody/Hover-v0", num_envs=3)
    envs.reset()
    assert envs.unwrapped.state("robots.quad.base.position").shape == (3, 3)
    envs.close()


def test_rotors_and_joints_have_a_second_path_and_a_slip_in_it_is_mended():
    sim = sims_alone(5)[1]
    for path, alias in (
        ("robots.quad.rotors[0].speed", "robots.quad.rotors.front_left.speed"),
        ("robots.quad.rotors[0].thrust_constant", "robots.quad.rotors.front_left.thrust_constant"),
    ):
        np.testing.assert_array_equal(sim.state(alias), sim.state(path))
    with pytest.raises(ValueError, match=r"did you mean `robots\.quad\.rotors\.front_left\.speed`"):
        sim.state("robots.quad.rotors.front_lft.speed")
    with pytest.raises(ValueError, match="has time, episode"):
        sim.state("nonsense")
