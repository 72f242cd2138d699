"""send, recv, reset and state of a pool, and its errors on wrong arguments."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
import skybody
from conftest import begin
from skybody._native import CompiledScenario, Pool, Simulation

SEED = 5


@pytest.fixture
def pool(hover: CompiledScenario) -> Pool:
    return Pool(hover, 4, num_threads=2, seed=SEED, keep_hash=True)


def test_reset_rows_are_marked_and_come_in_order(pool: Pool) -> None:
    pool.send_reset()
    assert pool.in_flight == 4
    batch = pool.recv()
    assert pool.in_flight == 0
    assert len(batch) == 4
    assert batch.env_id.tolist() == [0, 1, 2, 3]
    assert batch.was_reset.all()
    assert not batch.terminated.any() and not batch.truncated.any() and not batch.fault.any()
    assert (batch.reward == 0).all()
    assert (batch.episode_step == 0).all()


def test_goals_of_an_environment_are_those_of_its_simulation() -> None:
    formation = CompiledScenario("formation_2")
    envs = Pool(formation, 3, num_threads=1, seed=SEED)
    with pytest.raises(ValueError, match=r"goals\(\) of environment 1, which has not begun"):
        envs.goals(1)
    envs.send_reset()
    with pytest.raises(skybody.Error, match=r"goals\(\) while 3 environments are in flight"):
        envs.goals(1)
    envs.recv()
    one = Simulation(formation, SEED, 1)
    one.reset()
    assert envs.goals(1).shape == (2, 4)
    np.testing.assert_array_equal(envs.goals(1).ravel(), one.goals)
    with pytest.raises(ValueError, match="3"):
        envs.goals(3)


def test_step_is_send_and_recv_in_one_call(pool: Pool, hover: CompiledScenario) -> None:
    twin = Pool(hover, 4, num_threads=1, seed=SEED, keep_hash=True)
    actions = begin(pool)
    begin(twin)
    batch = pool.step(actions)
    twin.send(actions)
    np.testing.assert_array_equal(batch.observation, twin.recv().observation)
    assert (pool.hash(), pool.in_flight) == (twin.hash(), 0)


def test_a_step_upon_transitions_under_way_is_refused_and_sends_nothing(pool: Pool) -> None:
    actions = begin(pool)
    pool.send(actions[:2], np.arange(2, dtype=np.int32))
    for call in (lambda: pool.step(actions), pool.refuse_interrupted):
        with pytest.raises(skybody.Error, match=r"interrupted and 2 environments .* reset\(\)"):
            call()
    assert len(pool.recv()) == 2
    pool.refuse_interrupted()


def test_dtypes_and_shapes_of_a_batch(pool: Pool, hover: CompiledScenario) -> None:
    pool.send(begin(pool))
    batch = pool.recv()
    expected = {
        "observation": ((4, hover.observation_size), np.float32),
        "reward": ((4,), np.float32),
        "agent_reward": ((4, 1), np.float32),
        "info": ((4, hover.info_size), np.float32),
        "status": ((4,), np.uint64),
        "terminated": ((4,), np.bool_),
        "truncated": ((4,), np.bool_),
        "fault": ((4,), np.bool_),
        "was_reset": ((4,), np.bool_),
        "env_id": ((4,), np.int32),
        "episode_step": ((4,), np.int32),
    }
    for name, (shape, dtype) in expected.items():
        array = getattr(batch, name)
        assert (array.shape, array.dtype) == (shape, dtype), name


def test_each_environment_does_what_a_simulation_of_its_key_does(
    pool: Pool, hover: CompiledScenario
) -> None:
    pool.send_reset()
    pool.recv()
    simulations = [Simulation(hover, SEED, env) for env in range(4)]
    for simulation in simulations:
        simulation.reset()
    for step in range(20):
        actions = np.full((4, 4), 0.2 + 0.01 * step, np.float32)
        pool.send(actions)
        batch = pool.recv()
        for env, simulation in enumerate(simulations):
            simulation.step(actions[env])
            np.testing.assert_array_equal(batch.observation[env], simulation.observation)
            assert batch.reward[env] == simulation.reward


def test_send_copies_its_rows(hover: CompiledScenario) -> None:
    pools = [Pool(hover, 4, seed=SEED) for _ in range(2)]
    batches = []
    for overwrite, pool in enumerate(pools):
        actions = begin(pool) + np.float32(0.3)
        pool.send(actions)
        if overwrite:
            actions[:] = np.nan
        batches.append(pool.recv())
    np.testing.assert_array_equal(batches[0].observation, batches[1].observation)
    assert not batches[1].fault.any()


def test_rows_that_are_not_contiguous_are_accepted(hover: CompiledScenario) -> None:
    rng = np.random.default_rng(1)
    plain = rng.uniform(-1, 1, (4, 4)).astype(np.float32)
    wide = np.zeros((4, 8), np.float32)
    wide[:, ::2] = plain
    observations = []
    for actions in (plain, wide[:, ::2], np.asfortranarray(plain), plain[::-1][::-1]):
        pool = Pool(hover, 4, seed=SEED)
        begin(pool)
        pool.send(actions)
        observations.append(pool.recv().observation)
    for other in observations[1:]:
        np.testing.assert_array_equal(observations[0], other)


def test_some_environments_can_be_sent_alone(pool: Pool) -> None:
    actions = begin(pool)
    pool.send(actions[:2], np.array([3, 1], np.int32))
    batch = pool.recv()
    assert sorted(batch.env_id.tolist()) == [1, 3]
    assert len(batch) == 2


def test_a_mask_resets_the_marked_environments(pool: Pool) -> None:
    begin(pool)
    for mask in (np.array([False, True, False, True]), np.array([0, 1, 0, 1], np.uint8)):
        pool.send_reset(mask)
        batch = pool.recv()
        assert sorted(batch.env_id.tolist()) == [1, 3]
        assert batch.was_reset.all()


def test_a_seed_begins_everything_again(pool: Pool, hover: CompiledScenario) -> None:
    actions = begin(pool)
    pool.send(actions)
    pool.recv()
    pool.send_reset(seed=99)
    again = pool.recv().observation
    fresh = Pool(hover, 4, seed=99)
    fresh.send_reset()
    np.testing.assert_array_equal(again, fresh.recv().observation)


@pytest.mark.parametrize(
    ("actions", "env_ids", "error", "text"),
    [
        (np.zeros((4, 4)), None, TypeError, "actions has dtype float64; expected float32"),
        (np.zeros((4, 4), np.int32), None, TypeError, "actions has dtype int32; expected float32"),
        ([[0.0] * 4] * 4, None, TypeError, "actions is of type list; expected an array of float32"),
        (None, None, TypeError, "actions is of type NoneType"),
        (np.zeros((3, 4), np.float32), None, ValueError, r"shape \(3, 4\); expected \(4, 4\)"),
        (np.zeros((4, 5), np.float32), None, ValueError, r"shape \(4, 5\); expected \(4, 4\)"),
        (np.zeros(16, np.float32), None, ValueError, r"shape \(16,\); expected \(4, 4\)"),
        (np.zeros((1, 4), np.float32), [0, 1], ValueError, r"shape \(1, 4\); expected \(2, 4\)"),
        (np.zeros((1, 4), np.float32), [[0]], ValueError, r"shape \(1, 1\); expected \(n,\)"),
        (np.zeros((1, 4), np.float32), [4], ValueError, "no environment 4; allowed: 0 ... 3"),
        (np.zeros((1, 4), np.float32), [-1], ValueError, "no environment -1"),
        (np.zeros((2, 4), np.float32), [1, 1], ValueError, "twice"),
    ],
)
def test_wrong_rows_are_refused_and_nothing_is_sent(
    pool: Pool,
    actions: object,
    env_ids: list[int] | None,
    error: type[Exception],
    text: str,
) -> None:
    begin(pool)
    ids = None if env_ids is None else np.array(env_ids, np.int32)
    with pytest.raises(error, match=text):
        pool.send(actions, ids)  # type: ignore[arg-type]
    assert pool.in_flight == 0


def test_env_ids_of_another_dtype_are_refused(pool: Pool) -> None:
    actions = begin(pool)
    with pytest.raises(TypeError, match="env_ids has dtype int64; expected int32"):
        pool.send(actions, np.arange(4))  # type: ignore[arg-type]


def test_no_ids_send_nothing(pool: Pool) -> None:
    begin(pool)
    pool.send(np.zeros((0, 4), np.float32), np.zeros(0, np.int32))
    assert pool.in_flight == 0


def test_sending_an_environment_twice_is_refused(pool: Pool) -> None:
    actions = begin(pool)
    pool.send(actions)
    with pytest.raises(ValueError, match="still in flight"):
        pool.send(actions)
    assert len(pool.recv()) == 4


def test_actions_before_the_first_reset_are_refused(pool: Pool) -> None:
    with pytest.raises(ValueError, match="reset it first"):
        pool.send(np.zeros((4, 4), np.float32))


def test_recv_without_send_is_refused(pool: Pool) -> None:
    with pytest.raises(ValueError, match="nothing is in flight"):
        pool.recv()


def test_a_mask_of_another_shape_or_dtype_is_refused(pool: Pool) -> None:
    with pytest.raises(ValueError, match=r"mask has shape \(3,\); expected \(4,\)"):
        pool.send_reset(np.ones(3, np.bool_))
    with pytest.raises(TypeError, match="mask has dtype float64; expected bool"):
        pool.send_reset(np.ones(4))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="a mask or a seed"):
        pool.send_reset(np.ones(4, np.bool_), 3)


@pytest.mark.parametrize(
    "options",
    [
        {"num_envs": 0},
        {"num_envs": -1},
        {"num_envs": 4, "batch_size": 5},
        {"num_envs": 4, "batch_size": -1},
        {"num_envs": 4, "num_threads": -1},
        {"num_envs": 4, "order": "random"},
        {"num_envs": 4, "autoreset": "sometimes"},
    ],
)
def test_options_out_of_range_are_refused(hover: CompiledScenario, options: dict[str, int]) -> None:
    with pytest.raises(ValueError, match="allowed"):
        Pool(hover, **options)  # type: ignore[arg-type]


def test_a_row_that_is_not_finite_faults_that_environment_alone(pool: Pool) -> None:
    actions = begin(pool)
    actions[2, 1] = np.nan
    pool.send(actions)
    batch = pool.recv()
    assert batch.fault.tolist() == [False, False, True, False]
    assert batch.truncated.tolist() == [False, False, True, False]
    assert np.isfinite(batch.observation).all() and np.isfinite(batch.reward).all()
    assert pool.faults == 1


def test_same_step_keeps_the_row_before_the_reset() -> None:
    compiled = CompiledScenario("hover", ["stepping.horizon=3"])
    pool = Pool(compiled, 2, autoreset="same_step", seed=SEED)
    actions = begin(pool)
    for _ in range(3):
        pool.send(actions)
        batch = pool.recv()
    assert batch.truncated.all()
    assert batch.final_observation.shape == batch.observation.shape
    assert (batch.final_observation != batch.observation).any()


def test_other_modes_keep_no_row_from_before_a_reset(pool: Pool) -> None:
    pool.send_reset()
    batch = pool.recv()
    with pytest.raises(skybody.Error, match="same_step"):
        _ = batch.final_observation


def test_saved_state_has_the_same_future(pool: Pool) -> None:
    actions = begin(pool)
    saved = pool.save()
    futures = []
    for _ in range(2):
        pool.restore(saved)
        for _ in range(5):
            pool.send(actions)
            batch = pool.recv()
        futures.append((batch.observation.copy(), pool.hash(), pool.hash(2)))
    np.testing.assert_array_equal(futures[0][0], futures[1][0])
    assert futures[0][1:] == futures[1][1:]


def test_a_saved_state_that_does_not_fit_is_refused(pool: Pool, hover: CompiledScenario) -> None:
    begin(pool)
    saved = pool.save()
    for wrong in (b"", saved[:-8], saved[:-3], b"12345678"):
        with pytest.raises(ValueError, match="saved state"):
            pool.restore(wrong)
    with pytest.raises(ValueError, match="state is of"):
        Pool(hover, 3).restore(saved)


def test_save_with_environments_in_flight_is_refused(pool: Pool) -> None:
    pool.send_reset()
    with pytest.raises(skybody.Error, match="in flight"):
        pool.save()
    pool.recv()


def test_forked_environments_are_copies(pool: Pool) -> None:
    begin(pool)
    pool.fork(0, np.array([1, 3], np.int32))
    rows = pool.observations()
    np.testing.assert_array_equal(rows[0], rows[1])
    np.testing.assert_array_equal(rows[0], rows[3])
    assert (rows[0] != rows[2]).any()
    with pytest.raises(ValueError, match="9"):
        pool.fork(9, np.array([1], np.int32))


def test_parameters_are_read_and_set_per_environment(pool: Pool) -> None:
    begin(pool)
    path = "robots.quad.links.base_link.mass"
    before = pool.param(0, path)
    pool.set_param(1, path, before * 1.5)
    assert pool.param(0, path) == before
    assert pool.param(1, path) == before * 1.5
    with pytest.raises(ValueError, match="outside"):
        pool.set_param(0, path, -1.0)
    with pytest.raises(ValueError, match=r"`no\.such`"):
        pool.param(0, "no.such")


def test_without_keep_hash_there_is_none(hover: CompiledScenario) -> None:
    with pytest.raises(skybody.Error, match="keep_hash"):
        Pool(hover, 2).hash()


def test_a_closed_pool_refuses_every_call(pool: Pool) -> None:
    actions = begin(pool)
    batch = pool.send(actions) or pool.recv()
    pool.close()
    pool.close()
    assert pool.closed
    assert "closed" in repr(pool)
    for call in (
        pool.recv,
        pool.send_reset,
        lambda: pool.send(actions),
        pool.save,
        pool.observations,
        lambda: pool.in_flight,
    ):
        with pytest.raises(RuntimeError, match="closed"):
            call()
    assert np.isfinite(batch.observation).all()  # batches outlive it


def test_a_pool_closes_at_the_end_of_with(hover: CompiledScenario) -> None:
    with Pool(hover, 2) as pool:
        assert not pool.closed
    assert pool.closed


def test_closing_with_environments_in_flight_does_not_hang(pool: Pool) -> None:
    pool.send_reset()
    pool.close()
    assert pool.closed


def test_pickling_and_copying_are_refused_with_a_remedy(
    pool: Pool, hover: CompiledScenario
) -> None:
    for refused in (pool, Simulation(hover)):
        for attempt in (pickle.dumps, copy.copy, copy.deepcopy):
            with pytest.raises(TypeError, match=r"[Mm]ake one anew"):
                attempt(refused)
