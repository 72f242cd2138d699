"""Recordings made from Python, run again by the program `skybody replay`."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import skybody
from hash_chain import rehash
from numpy.typing import NDArray
from reference import actions, short_hover

DAMAGED = (
    "this replay is damaged: the values of burst 1 are not those that were recorded; "
    "take another copy"
)
PROGRAM = Path(__file__).resolve().parents[2] / "build/release/bin/skybody"
NUM_ENVS = 6
SEND = 2  # kind of an event, docs/replay.md

Finished = subprocess.CompletedProcess[str]


def replay(file: Path, *options: str) -> Finished:
    command = [str(PROGRAM), "replay", str(file), *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def mask(*envs: int) -> NDArray[np.bool_]:
    chosen = np.zeros(NUM_ENVS, np.bool_)
    chosen[list(envs)] = True
    return chosen


def fly(envs: skybody.vector.SkybodyVectorEnv, first: int, steps: int) -> None:
    for step in range(first, first + steps):
        envs.step(actions(step, NUM_ENVS))


def record_everything(envs: skybody.vector.SkybodyVectorEnv) -> None:
    """A recording with one event of every kind, and with episodes that end by themselves."""
    envs.reset()
    fly(envs, 0, 10)
    envs.reset(options={"reset_mask": mask(1, 4)})
    given = actions(10, NUM_ENVS)
    given[2, 0] = np.nan
    envs.step(given)
    assert envs.faults == 1
    saved = envs.save()
    fly(envs, 11, 5)
    envs.fork(0, [3, 5])
    envs.fork(1, [4], rekey=True)
    envs.set_param(3, "robots.quad.links.base_link.mass", 1.7)
    fly(envs, 16, 50)
    envs.restore(saved)
    fly(envs, 66, 5)
    envs.reset(seed=11)
    fly(envs, 71, 5)


@pytest.mark.parametrize("states", [False, True])
@pytest.mark.parametrize("autoreset", ["next_step", "same_step"])
def test_all_that_can_be_done_to_environments_replays_identical_on_other_threads(
    tmp_path: Path, autoreset: str, states: bool
):
    file = tmp_path / "run.h5"
    with_file = {"num_threads": 1, "seed": 3, "autoreset": autoreset}
    envs = skybody.make_vec(short_hover(), NUM_ENVS, **with_file)
    envs.reset()
    fly(envs, 0, 3)  # the recording starts in mid-episode
    envs.record(file, states=states)
    record_everything(envs)
    envs.stop_recording()
    transitions = (1 + 10 + 1 + 5 + 50 + 5 + 1 + 5) * NUM_ENVS + 2
    for threads in ("2", "4"):
        done = replay(file, "--threads", threads)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith(f"identical: {transitions} transitions")


def test_partial_batches_in_order_of_arrival_replay_identical(tmp_path: Path):
    file = tmp_path / "run.h5"
    with skybody.make_pool(short_hover(), NUM_ENVS, batch_size=2, num_threads=4) as pool:
        pool.record(file)
        pool.async_reset()
        for step in range(100):
            ids = pool.recv()[-1]["env_id"]
            pool.send(actions(step, NUM_ENVS)[ids], ids)
        while pool.in_flight:
            pool.recv()
    done = replay(file, "--threads", "1")
    assert (done.returncode, done.stdout.split(":")[0]) == (0, "identical"), done.stderr


def test_recordings_of_other_threads_are_the_same(tmp_path: Path):
    for threads in (1, 4):
        envs = skybody.make_vec(short_hover(), NUM_ENVS, num_threads=threads, seed=3)
        envs.record(tmp_path / f"{threads}.h5")
        record_everything(envs)
        envs.close()
    done = replay(tmp_path / "1.h5", "--against", str(tmp_path / "4.h5"))
    assert (done.returncode, done.stdout.split(":")[0]) == (0, "identical"), done.stderr


def test_a_changed_byte_of_an_action_is_reported_where_the_runs_part(tmp_path: Path):
    file = tmp_path / "run.h5"
    envs = skybody.make_vec(short_hover(), NUM_ENVS, seed=3)
    envs.record(file, states=True)
    envs.reset()
    fly(envs, 0, 20)
    envs.close()
    with h5py.File(file, "r+") as changed:
        events = changed["events"]
        assert np.all(events["kind"][-20:] == SEND)
        row = 7 * NUM_ENVS + 4  # the eighth step of environment 4: its ninth transition
        bits = events["action"][row].view(np.uint8)
        bits[2] ^= 0x01  # of the first value's mantissa
        events["action"][row] = bits.view(np.float32)
    done = replay(file)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"{file}: error: {DAMAGED}\n"
    rehash(file)
    done = replay(file)
    assert done.returncode == 1
    assert done.stdout.startswith(
        "first difference: environment 4, transition 9 (episode 1, step 8); "
        "1 of 6 environments differ"
    )
    assert re.search(r"^  state u quad\.base_link\[\d\] +\S+ +\S+$", done.stdout, re.MULTILINE)


@pytest.mark.parametrize("name", ["observation", "reward", "episode_step", "status"])
def test_rows_that_were_changed_beside_their_hashes_are_not_identical(tmp_path: Path, name: str):
    file, changed = tmp_path / "run.h5", tmp_path / "changed.h5"
    envs = skybody.make_vec(short_hover(), NUM_ENVS, seed=3)
    envs.record(file)
    envs.reset()
    fly(envs, 0, 30)
    envs.close()
    changed.write_bytes(file.read_bytes())
    with h5py.File(changed, "r+") as recording:
        values = recording[f"transitions/{name}"]
        values[7 * NUM_ENVS + 2] += 1  # the eighth transition of environment 2
    assert replay(changed).stderr == f"{changed}: error: {DAMAGED}\n"
    rehash(changed)
    for result in (replay(changed), replay(file, "--against", str(changed))):
        assert result.returncode == 1, result.stdout + result.stderr
        assert "the hashes are the same, but not the rows beside them" in result.stdout
        assert "first difference: environment 2, transition 8 " in result.stdout


@pytest.mark.parametrize("end", ["stop_recording", "close", "__exit__", "__del__"])
def test_the_file_is_whole_however_the_recording_ends(tmp_path: Path, end: str):
    file = tmp_path / "run.h5"
    pool = skybody.make_pool("hover", 2)
    pool.record(str(file))
    pool.reset()
    pool.send(np.zeros((2, 4), np.float32))  # in flight at the end: not recorded
    if end == "__del__":
        del pool
    elif end == "__exit__":
        with pool:
            pass
    else:
        getattr(pool, end)()
    done = replay(file)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("identical: 2 transitions")


def test_a_program_that_ends_with_a_recorded_pool_leaves_a_whole_file(
    tmp_path: Path, python: Callable[[str], Finished]
):
    file = tmp_path / "run.h5"
    done = python(f"""
        import numpy as np, skybody
        envs = skybody.make_vec("hover", 2)
        envs.record({str(file)!r})
        envs.reset()
        envs.step(np.zeros((2, 4), np.float32))
    """)
    assert (done.returncode, done.stderr) == (0, "")
    assert replay(file).stdout.startswith("identical: 4 transitions")


def test_a_forked_child_that_ends_leaves_the_file_to_the_parent(
    tmp_path: Path, python: Callable[[str], Finished]
):
    file = tmp_path / "run.h5"
    done = python(f"""
        import os, sys
        import numpy as np, skybody
        envs = skybody.make_vec("hover", 64, num_threads=1)
        envs.record({str(file)!r}, states=True)
        envs.reset()
        waits, begins = os.pipe()
        child = os.fork()
        if child == 0:
            os.read(waits, 1)
            sys.exit(0)  # with all that the C library does at exit
        for _ in range(150):  # 9,600 transitions of 1.3 kB: three bursts reach the file
            envs.step(np.zeros((64, 4), np.float32))
        os.write(begins, b"x")
        os.waitpid(child, 0)
        os._exit(0)  # without another word to the file
    """)
    assert (done.returncode, done.stderr) == (0, "")
    again = replay(file)
    assert (again.returncode, again.stdout.split(":")[0]) == (0, "identical"), again.stderr
    assert int(again.stdout.split()[1]) >= 6000


def test_after_stop_recording_nothing_is_added_and_another_may_begin(tmp_path: Path):
    pool = skybody.make_pool("hover", 2)
    pool.record(tmp_path / "first.h5")
    pool.reset()
    pool.stop_recording()
    pool.reset()
    pool.record(tmp_path / "second.h5")
    pool.step(np.zeros((2, 4), np.float32))
    pool.stop_recording()
    for name in ("first.h5", "second.h5"):
        assert replay(tmp_path / name).stdout.startswith("identical: 2 transitions")


def test_hashes_are_kept_while_recording_also_without_keep_hash(tmp_path: Path):
    pool = skybody.make_pool("hover", 2)
    pool.record(tmp_path / "run.h5")
    pool.reset()
    assert pool.hash() != 0
    pool.stop_recording()
    with pytest.raises(skybody.Error, match="keep_hash"):
        pool.hash()


def test_recording_while_in_flight_is_an_error_that_leaves_the_file_alone(tmp_path: Path):
    file = tmp_path / "run.h5"
    file.write_text("precious")
    pool = skybody.make_pool("hover", 2)
    pool.async_reset()
    with pytest.raises(skybody.Error, match=r"2 environments are in flight: recv\(\) them first"):
        pool.record(file)
    assert file.read_text() == "precious"
    pool.recv()
    pool.record(file)


def test_a_second_recording_and_a_stop_without_one_are_errors(tmp_path: Path):
    pool = skybody.make_pool("hover", 2)
    with pytest.raises(skybody.Error, match="not being recorded"):
        pool.stop_recording()
    pool.record(tmp_path / "run.h5")
    with pytest.raises(skybody.Error, match=r"recorded to .*run\.h5: stop_recording\(\) first"):
        pool.record(tmp_path / "other.h5")
    assert not (tmp_path / "other.h5").exists()


def test_a_file_that_cannot_be_written_is_named_and_the_pool_goes_on(tmp_path: Path):
    pool = skybody.make_pool("hover", 2)
    with pytest.raises(skybody.Error, match=r"nowhere/run\.h5"):
        pool.record(tmp_path / "nowhere/run.h5")
    pool.record(tmp_path / "run.h5")
    pool.reset()
    pool.close()
    assert replay(tmp_path / "run.h5").stdout.startswith("identical: 2 transitions")


def test_a_closed_pool_cannot_be_recorded(tmp_path: Path):
    pool = skybody.make_pool("hover", 2)
    pool.close()
    with pytest.raises(skybody.Error, match="closed"):
        pool.record(tmp_path / "run.h5")
