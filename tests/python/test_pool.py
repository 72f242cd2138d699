"""The asynchronous pool: rows returned, their order, and their content."""

from __future__ import annotations

import numpy as np
import pytest
import skybody
from reference import SEED, Rollout, actions, short_hover
from skybody import Pool, make_pool

NUM_ENVS = 9


def play(pool: Pool, batches: int) -> dict[int, list[np.ndarray]]:
    """Sends every received environment its next action; rows by environment, in order of time."""
    rows: dict[int, list[np.ndarray]] = {i: [] for i in range(pool.num_envs)}
    pool.async_reset()
    for _ in range(batches):
        observation, _, _, _, info = pool.recv()
        ids = info["env_id"]
        given = np.stack([actions(len(rows[i]), pool.num_envs)[i] for i in ids])
        for i, row in zip(ids, observation, strict=True):
            rows[i].append(row.copy())
        pool.send(given, ids)
    return rows


@pytest.mark.parametrize("order", ["fixed", "arrival"])
@pytest.mark.parametrize("batch_size", [1, 3, NUM_ENVS])
@pytest.mark.parametrize("num_threads", [1, 2])
def test_trajectories_do_not_depend_on_order_batch_or_threads(
    order: str, batch_size: int, num_threads: int
):
    options = {"order": order, "batch_size": batch_size, "num_threads": num_threads}
    with make_pool(short_hover(), NUM_ENVS, seed=SEED, **options) as pool:
        rows = play(pool, 60 * NUM_ENVS // batch_size)
    whole = make_pool(short_hover(), NUM_ENVS, seed=SEED, order="fixed", num_threads=1)
    expected = play(whole, 200)
    for i in range(NUM_ENVS):
        count = min(len(rows[i]), len(expected[i]))
        assert count > (0 if order == "arrival" else 50)
        np.testing.assert_array_equal(rows[i][:count], expected[i][:count])


def test_fixed_order_gives_ids_cyclically():
    pool = make_pool(short_hover(), 7, batch_size=3, order="fixed")
    pool.async_reset()
    received = []
    for _ in range(14):
        ids = pool.recv()[4]["env_id"].copy()
        received += ids.tolist()
        pool.send(actions(0, len(ids)), ids)
    assert received == [i % 7 for i in range(42)]


def test_was_reset_marks_the_rows_that_begin_an_episode():
    pool = make_pool(short_hover(), NUM_ENVS, seed=SEED, order="fixed")
    compiled = short_hover()
    worlds = [Rollout(compiled, i) for i in range(NUM_ENVS)]
    observation, info = pool.reset()
    assert info["was_reset"].all()
    pending: list[np.ndarray | None] = [None] * NUM_ENVS
    for step in range(90):
        given = actions(step, NUM_ENVS)
        observation, reward, _, _, info = pool.step(given)
        for i, world in enumerate(worlds):
            assert info["was_reset"][i] == (pending[i] is not None)
            if pending[i] is not None:
                np.testing.assert_array_equal(observation[i], pending[i])
                assert reward[i] == 0.0
                pending[i] = None
            else:
                pending[i] = world.step(given[i]).first_of_next


def test_same_step_has_the_final_rows_of_ended_episodes():
    pool = make_pool(short_hover(), NUM_ENVS, seed=SEED, order="fixed", autoreset="same_step")
    compiled = short_hover()
    worlds = [Rollout(compiled, i) for i in range(NUM_ENVS)]
    pool.reset()
    ends = 0
    for step in range(90):
        given = actions(step, NUM_ENVS)
        _, _, terminated, truncated, info = pool.step(given)
        for i, world in enumerate(worlds):
            row = world.step(given[i])
            if terminated[i] or truncated[i]:
                np.testing.assert_array_equal(info["final_obs"][i], row.observation)
                ends += 1
    assert ends > NUM_ENVS


def test_without_infos_rows_are_the_same_and_the_tasks_values_are_left_out():
    with (
        make_pool("hover", 8, num_threads=1) as whole,
        make_pool("hover", 8, num_threads=1, infos=False) as without,
    ):
        for pool in (whole, without):
            pool.async_reset()
        for _ in range(20):
            observation, reward, _, _, info = whole.recv()
            other = without.recv()
            np.testing.assert_array_equal(observation, other[0])
            np.testing.assert_array_equal(reward, other[1])
            assert set(info) - set(other[4]) >= {"position_error", "yaw_error"}
            assert set(other[4]) == {"env_id", "was_reset", "fault", "agent_reward"}
            for pool in (whole, without):
                pool.send(np.full((8, 4), 0.2, np.float32), info["env_id"])


def test_send_copies_its_rows_before_it_returns():
    pool, careful = (make_pool(short_hover(), NUM_ENVS, seed=SEED, order="fixed") for _ in "ab")
    given = actions(0, NUM_ENVS)
    pool.reset()
    careful.reset()
    pool.send(given)
    given[:] = np.nan
    careful.send(actions(0, NUM_ENVS))
    np.testing.assert_array_equal(pool.recv()[0], careful.recv()[0])
    assert pool.faults == 0


def test_recv_gives_fewer_rows_where_fewer_are_in_flight():
    pool = make_pool(short_hover(), NUM_ENVS)
    pool.reset()
    pool.send(actions(0, 2), [4, 1])
    assert pool.in_flight == 2
    info = pool.recv()[4]
    assert sorted(info["env_id"].tolist()) == [1, 4]
    assert pool.in_flight == 0


def test_a_masked_reset_touches_no_other_environment():
    pool = make_pool(short_hover(), NUM_ENVS, order="fixed")
    before = pool.reset()[0].copy()
    mask = np.zeros(NUM_ENVS, np.bool_)
    mask[[2, 5]] = True
    observation, info = pool.reset(mask=mask)
    assert info["env_id"].tolist() == [2, 5]
    assert not np.array_equal(observation, before[mask])
    np.testing.assert_array_equal(pool.observations()[~mask], before[~mask])


def test_a_fault_is_marked_and_counted():
    pool = make_pool(short_hover(), NUM_ENVS, order="fixed")
    pool.reset()
    given = actions(0, NUM_ENVS)
    given[4] = -np.inf
    observation, reward, terminated, truncated, info = pool.step(given)
    assert np.flatnonzero(info["fault"]).tolist() == [4]
    assert truncated[4]
    assert not terminated[4]
    assert reward[4] == 0.0
    assert np.isfinite(observation).all()
    assert pool.faults == 1


def test_misuse_is_refused_with_nothing_sent():
    pool = make_pool(short_hover(), NUM_ENVS)
    with pytest.raises(ValueError, match="nothing is in flight"):
        pool.recv()
    with pytest.raises(ValueError, match="reset"):
        pool.send(actions(0, NUM_ENVS))
    pool.reset()
    for ids, error in (([NUM_ENVS], ValueError), ([-1], ValueError), ([0.5], TypeError)):
        with pytest.raises(error):
            pool.send(actions(0, 1), ids)
    with pytest.raises(ValueError):
        pool.send(actions(0, 2), [3, 3])
    with pytest.raises(ValueError):
        pool.send(actions(0, 2), [3])
    with pytest.raises(TypeError, match="float32"):
        pool.send(np.zeros((NUM_ENVS, 4)))
    assert pool.in_flight == 0
    pool.send(actions(0, 1), [3])
    with pytest.raises(ValueError, match="flight"):
        pool.send(actions(0, 1), [3])
    with pytest.raises(ValueError):
        pool.reset(mask=np.ones(NUM_ENVS, np.bool_), seed=1)
    with pytest.raises(skybody.Error):
        pool.save()


@pytest.mark.parametrize(
    "options",
    [
        {"batch_size": NUM_ENVS + 1},
        {"batch_size": -1},
        {"num_threads": -1},
        {"order": "random"},
        {"autoreset": "never"},
    ],
)
def test_options_out_of_range_are_refused(options: dict[str, object]):
    with pytest.raises(ValueError):
        make_pool(short_hover(), NUM_ENVS, **options)  # type: ignore[arg-type]


def test_a_closed_pool_refuses_everything_and_its_arrays_live_on():
    with make_pool(short_hover(), NUM_ENVS) as pool:
        observation, _ = pool.reset()
        value = observation.copy()
    with pytest.raises(skybody.Error, match="closed"):
        pool.reset()
    np.testing.assert_array_equal(observation, value)


def test_restore_repeats_the_future_and_its_hash():
    pool = make_pool(short_hover(), NUM_ENVS, order="fixed", keep_hash=True)
    pool.reset()
    saved = pool.save()

    def future() -> tuple[np.ndarray, int]:
        rows = [pool.step(actions(k, NUM_ENVS))[0].copy() for k in range(60)]
        return np.stack(rows), pool.hash()

    first = future()
    pool.restore(saved)
    again = future()
    np.testing.assert_array_equal(first[0], again[0])
    assert first[1] == again[1]
    assert pool.hash(0) != pool.hash(1)


def test_debug_raises_where_held_memory_would_be_recycled():
    pool = make_pool(short_hover(), NUM_ENVS, order="fixed", debug=True)
    held = [pool.reset()[0]]
    with pytest.raises(BufferError):
        for step in range(5):
            held.append(pool.step(actions(step, NUM_ENVS))[0])
