"""Arrays of a batch are the engine's memory: no copies, valid for the documented time."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from conftest import begin
from numpy.typing import NDArray
from skybody._native import Batch, CompiledScenario, Pool


def address(array: NDArray[np.float32]) -> int:
    return int(array.__array_interface__["data"][0])


def step(pool: Pool, actions: NDArray[np.float32]) -> Batch:
    pool.send(actions)
    return pool.recv()


def test_every_view_of_a_column_is_the_same_memory(hover: CompiledScenario) -> None:
    pool = Pool(hover, 4)
    pool.send_reset()
    batch = pool.recv()
    for name in ("observation", "reward", "terminated", "env_id", "status", "agent_reward"):
        first, second = getattr(batch, name), getattr(batch, name)
        assert address(first) == address(second), name
        assert not first.flags.owndata and first.flags.writeable, name
    batch.observation[0, 0] = 42.0
    assert batch.observation[0, 0] == 42.0


def test_batches_come_from_few_buffers_in_turn(hover: CompiledScenario) -> None:
    # A copy would have a new address each time; three buffers in rotation show that there is none.
    pool = Pool(hover, 4)
    actions = begin(pool)
    addresses = [address(step(pool, actions).observation) for _ in range(9)]
    assert len(set(addresses)) == 3
    assert addresses[:3] * 3 == addresses
    assert all(a % 64 == 0 for a in addresses)  # the engine's cache-line alignment
    assert pool.fresh_buffers == 0


def test_rows_keep_their_values_until_the_second_next_recv(hover: CompiledScenario) -> None:
    pool = Pool(hover, 4)
    actions = begin(pool)
    batch = step(pool, actions)
    where, values = address(batch.observation), batch.observation.copy()
    view = np.lib.stride_tricks.as_strided(
        batch.observation
    )  # only the view keeps the memory alive
    del batch
    step(pool, actions)
    assert address(view) == where
    np.testing.assert_array_equal(view, values)


def test_a_held_view_keeps_its_values_for_ever_and_is_counted(hover: CompiledScenario) -> None:
    pool = Pool(hover, 4)
    actions = begin(pool)
    view = step(pool, actions).observation
    values = view.copy()
    for _ in range(7):
        step(pool, actions)
    np.testing.assert_array_equal(view, values)
    assert pool.fresh_buffers == 1


def test_a_view_outlives_batch_and_pool(hover: CompiledScenario) -> None:
    pool = Pool(hover, 64)
    pool.send_reset()
    view = pool.recv().observation
    values = view.copy()
    pool.close()
    del pool
    gc.collect()
    others = [np.full_like(values, 7.0) for _ in range(8)]  # would reuse freed memory
    np.testing.assert_array_equal(view, values)
    assert len(others) == 8


def test_debug_mode_refuses_to_reuse_a_held_buffer(hover: CompiledScenario) -> None:
    pool = Pool(hover, 4, debug=True)
    actions = begin(pool)
    held = step(pool, actions).observation
    values = held.copy()
    with pytest.raises(BufferError, match="copy what you keep"):
        for _ in range(3):
            step(pool, actions)
    np.testing.assert_array_equal(held, values)


def test_debug_mode_goes_on_once_the_buffer_is_free(hover: CompiledScenario) -> None:
    pool = Pool(hover, 4, debug=True)
    actions = begin(pool)
    held = step(pool, actions)
    step(pool, actions)
    step(pool, actions)
    with pytest.raises(BufferError):
        step(pool, actions)
    del held
    batch = pool.recv() if pool.in_flight else step(pool, actions)
    assert len(batch) == 4
    assert batch.episode_step.tolist() == [4, 4, 4, 4]  # no step was lost or done twice


def test_debug_mode_fills_reused_buffers_with_nan(hover: CompiledScenario) -> None:
    pool = Pool(hover, 4, debug=True)
    actions = begin(pool)
    batch = step(pool, actions)
    where = address(batch.observation)
    # Breaks the rules on purpose: a pointer to the memory that does not keep it alive.
    stale = np.ctypeslib.as_array(
        (np.ctypeslib.ctypes.c_float * batch.observation.size).from_address(where)
    )
    assert np.isfinite(stale).all()
    del batch
    ids = np.arange(2, dtype=np.int32)
    step(pool, actions)
    step(pool, actions)
    pool.send(actions[:2], ids)
    short = pool.recv()  # two rows into the buffer of four
    assert address(short.observation) == where
    assert np.isfinite(short.observation).all()
    assert np.isnan(stale[short.observation.size :]).all()


def test_observations_are_a_fresh_array(hover: CompiledScenario) -> None:
    pool = Pool(hover, 4)
    begin(pool)
    first, second = pool.observations(), pool.observations()
    assert address(first) != address(second)
    np.testing.assert_array_equal(first, second)
