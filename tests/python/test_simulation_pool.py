"""Many environments under direct control."""

from __future__ import annotations

import copy
import os
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import skybody
from skybody.simulation import Simulation, SimulationPool

N = 5


@pytest.mark.parametrize("num_threads", [1, 2, 7])
def test_environments_do_what_they_do_alone(num_threads):
    commands = np.random.default_rng(0).uniform(500, 1500, (N, 4))
    options = {"seed": 3, "first_env_id": 7, "num_threads": num_threads}
    with SimulationPool("hover", N, "rotor_speed", **options) as pool:
        assert pool.num_threads == num_threads
        pool.reset()
        pool.command(commands)
        pool.advance(300)
        pool.evaluate(envs=[0, 2])
        states, hashes = pool.states(), [pool.hash(i) for i in range(N)]
        observations, rewards = pool.observations, pool.rewards
    for i in range(N):
        world = Simulation("hover", "rotor_speed", seed=3, env_id=7 + i)
        world.reset()
        world.command(commands[i])
        world.advance(300)
        if i in (0, 2):
            world.evaluate()
        base = world.base()
        np.testing.assert_array_equal(states.positions[i, 0], base.position)
        np.testing.assert_array_equal(states.rotations[i, 0], base.rotation)
        np.testing.assert_array_equal(states.velocities[i, 0], base.velocity)
        np.testing.assert_array_equal(states.angular_velocities[i, 0], base.angular_velocity)
        np.testing.assert_array_equal(states.rotor_speeds[i], world.rotor_speeds)
        np.testing.assert_array_equal(observations[i], world.observation)
        assert rewards[i] == world.reward
        assert states.times[i] == world.time
        assert hashes[i] == world.hash()


def test_arrays_have_a_row_for_every_world_body_and_rotor():
    with SimulationPool("payload", 3) as pool:
        pool.reset()
        bodies = pool.positions.shape[1]
        assert bodies > 1
        states = pool.states()
        assert states.positions.shape == states.velocities.shape == (3, bodies, 3)
        assert states.rotations.shape == (3, bodies, 4)
        assert states.rotor_speeds.shape == (3, 4)
        assert states.times.shape == (3,)
        assert all(values.dtype == np.float64 and values.flags.c_contiguous for values in states)
        np.testing.assert_allclose(np.linalg.norm(states.rotations, axis=2), 1, atol=1e-12)
        kept = states.positions.copy()
        pool.advance(100)
        np.testing.assert_array_equal(states.positions, kept)  # a copy
        assert pool.states([2, 0]).times.shape == (2,)


def test_masks_and_numbers_choose_environments():
    with SimulationPool("hover", N, "ctbr") as pool:
        pool.reset()
        pool.advance(10)
        mask = np.array([True, False, True, False, False])
        pool.reset(mask)
        np.testing.assert_allclose(pool.states().times, np.where(mask, 0, 0.01))
        pool.advance(5, envs=[4])
        assert pool.states([4]).times[0] == pytest.approx(0.015)
        pool.advance(5, envs=np.zeros(N, np.bool_))  # nobody
        pool.command([5, 0, 0, 0], envs=mask)  # one command for all of them
        pool.reset(seed=2)
        assert (pool.states().times == 0).all()


def test_misuse_is_refused_before_anything_is_done():
    with SimulationPool("hover", 3, "ctbr") as pool:
        with pytest.raises(skybody.Error, match=r"^environment 0: .*before reset\(\)"):
            pool.advance()
        pool.reset()
        for envs in ([3], [-1], [1, 1], np.ones(2, np.bool_)):
            with pytest.raises(ValueError):
                pool.advance(1, envs)
        with pytest.raises(TypeError):
            pool.advance(1, [0.5])
        with pytest.raises(TypeError, match=r"physics_steps is 1\.5; it must be an integer"):
            pool.advance(1.5)
        with pytest.raises(TypeError, match="path is 3; it must be a text"):
            pool.state(3)
        with pytest.raises(ValueError, match="shape"):
            pool.command(np.zeros((3, 5)))
        with pytest.raises(ValueError, match="shape"):
            pool.step(np.zeros((2, 4)))
        with pytest.raises(ValueError, match=r"environment 1: .*nan"):
            pool.command([[1, 0, 0, 0], [1, np.nan, 0, 0], [1, 0, 0, 0]])
        with pytest.raises(ValueError, match="-2"):
            pool.advance(-2)
        with pytest.raises(ValueError, match="there is no environment 5; allowed"):
            pool.set_param(5, "x", 1.0)
        assert (pool.states().times == 0).all()
    with pytest.raises(ValueError, match="num_envs is 2147483648; it must be from 1 to 16777216"):
        SimulationPool("hover", 2**31)
    with pytest.raises(ValueError, match="from 1 to 16777216"):
        SimulationPool("hover", 0)
    with pytest.raises(ValueError, match="num_threads is -1; it must be from 0 to 1024"):
        SimulationPool("hover", 2, num_threads=-1)


def test_a_fault_stays_in_its_environment():
    with SimulationPool("hover", 3, "ctbr") as pool:
        pool.reset()
        pool.teleport(1, angular_velocity=[1e200, 1e200, 0])
        pool.advance(20)
        assert pool.faults.tolist() == [False, True, False]
        reasons = pool.fault_reasons
        assert reasons is not None
        assert reasons[0] is None and reasons[2] is None
        assert str(reasons[1]).startswith("the physics gave up or left the finite numbers: ")
        np.testing.assert_allclose(pool.states().times, [0.02, 0, 0.02])
        pool.reset([1])
        pool.advance(1)
        assert not pool.faults.any()
        assert pool.fault_reasons is None


def test_a_non_finite_action_faults_its_world_only():
    with SimulationPool("hover", 3) as pool:
        pool.reset()
        actions = np.zeros((3, 4))
        actions[2, 1] = np.nan
        pool.step(actions)
        assert pool.faults.tolist() == pool.truncated.tolist() == [False, False, True]
        assert not pool.terminated.any()


def test_environments_are_saved_restored_and_set_one_by_one():
    with SimulationPool("hover", 3, "ctbr", seed=1) as pool:
        pool.reset()
        saved = pool.save(0)
        pool.restore(2, saved)
        pool.advance(50)
        states = pool.states()
        np.testing.assert_array_equal(states.positions[0], states.positions[2])
        assert not np.array_equal(states.positions[0], states.positions[1])
        path = "robots.quad.links.base_link.mass"
        pool.set_param(1, path, 9.0)
        assert pool.param(1, path) == 9.0 != pool.param(0, path)


def test_closing_twice_is_harmless_and_everything_else_is_refused():
    pool = SimulationPool("hover", 2)
    pool.reset()
    pool.close()
    pool.close()
    assert pool.closed
    for call in (pool.reset, pool.states, pool.advance):
        with pytest.raises(skybody.Error, match="closed"):
            call()
    with pytest.raises(TypeError, match="pickled"):
        copy.copy(pool)


def test_pools_come_and_go_without_leaving_threads_behind():
    def threads() -> int:
        return len(os.listdir("/proc/self/task"))

    SimulationPool("hover", 4).close()
    before = threads()
    for _ in range(50):
        SimulationPool("hover", 4)  # never closed
    assert threads() <= before


def test_the_gil_is_free_while_environments_advance():
    with SimulationPool("hover", 2, "ctbr") as pool:
        pool.reset()
        counted, stop = [0], threading.Event()

        def count() -> None:
            while not stop.is_set():
                counted[0] += 1
                time.sleep(0)

        thread = threading.Thread(target=count)
        thread.start()
        before = counted[0]
        pool.advance(1_000_000)
        assert (
            counted[0] > before + 100
        )  # a blocked thread would only reach about the number of pieces
        stop.set()
        thread.join(30)


def test_keyboard_interrupt_gets_through_a_long_advance():
    with SimulationPool("hover", 2, "ctbr") as pool:
        pool.reset()
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            pool.advance(10**12)
        pool.reset()  # it can continue
        pool.advance(1)
        assert pool.states().times[0] == 0.001


def test_a_forked_child_is_refused_and_ends():
    pool = SimulationPool("hover", 2)
    child = os.fork()
    if child == 0:
        try:
            pool.reset()
        except skybody.Error as error:
            pool.close()
            os._exit(0 if "fork" in str(error) else 1)
        os._exit(2)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    pool.reset()


def test_a_pool_of_environments_without_rotors_has_speeds_of_none(tmp_path: Path) -> None:
    scenario = tmp_path / "bare.yaml"
    scenario.write_text(
        "robots:\n  - name: quad\n    model: qdrone2\n    rotors: none\n"
        "    pose: {position: [0, 0, 2]}\n"
        "    controllers: [{plugin: wrench, parameters: {max_moment: [1, 1, 1]}}]\n"
        "task: {plugin: hover}\n"
    )
    pool = SimulationPool(str(scenario), 3)
    pool.reset()
    assert pool.rotor_speeds.shape == (3, 0)
    assert pool.states().rotor_speeds.shape == (3, 0)
