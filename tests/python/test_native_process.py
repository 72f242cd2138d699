"""Pools with threads, signals, forks and exits: an exception or a result, never a hang."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import skybody
from conftest import Finished, begin
from skybody._native import CompiledScenario, Pool

# A step long enough that a test's actions during it finish before it ends: half a millisecond for
# each environment on a fast machine, so seconds for some thousands of them.
SLOW = ("hover", ["stepping.action_repeat=10000"])


def test_the_interpreter_exits_quietly_with_live_pools(
    python: Callable[[str], Finished],
) -> None:
    result = python("""
        from skybody._native import CompiledScenario, Pool
        compiled = CompiledScenario("hover")
        idle, busy, halfway = (Pool(compiled, 8, num_threads=2) for _ in range(3))
        busy.send_reset()
        halfway.send_reset()
        batch = halfway.recv()
        view = batch.observation
        cycle = [halfway]
        cycle.append(cycle)
    """)
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")


def test_an_exception_with_a_live_pool_ends_the_program(
    python: Callable[[str], Finished],
) -> None:
    result = python("""
        from skybody._native import CompiledScenario, Pool
        pool = Pool(CompiledScenario("hover"), 8, num_threads=2)
        pool.send_reset()
        raise KeyError("mine")
    """)
    assert result.returncode == 1
    assert result.stderr.rstrip().endswith("KeyError: 'mine'")
    assert "nanobind" not in result.stderr


def test_keyboard_interrupt_gets_out_of_recv() -> None:
    script = f"""
        import signal
        import numpy as np
        from skybody._native import CompiledScenario, Pool
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it
        pool = Pool(CompiledScenario(*{SLOW}), 4000, num_threads=1)
        pool.send_reset()
        pool.recv()
        print("waiting", flush=True)
        try:
            while True:
                pool.send(np.zeros((4000, 4), np.float32))
                pool.recv()
        except KeyboardInterrupt:
            print("interrupted", pool.in_flight > 0, flush=True)  # not after the wait was over
        while pool.in_flight:
            pool.recv()
        pool.close()
        print("closed", flush=True)
    """
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "waiting\n"
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (0, "interrupted True\nclosed\n", "")


def test_the_gil_is_free_while_recv_steps() -> None:
    pool = Pool(CompiledScenario("hover", ["stepping.action_repeat=100000"]), 64, num_threads=1)
    actions = begin(pool)
    counted, stop = [0], threading.Event()

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    pool.send(actions)
    before = counted[0]
    pool.recv()  # tenths of a second on this thread alone
    after = counted[0]
    stop.set()
    thread.join(30)
    assert after > before + 100


def test_a_forked_child_gets_an_error_and_exits(python: Callable[[str], Finished]) -> None:
    # By sys.exit() and by os._exit(): the child's copy of the pool must not wait for its threads.
    result = python("""
        import os, sys
        import numpy as np
        from skybody._native import CompiledScenario, Pool
        pool = Pool(CompiledScenario("hover"), 8, num_threads=2)
        pool.send_reset()
        pool.recv()
        for leave in (sys.exit, os._exit):
            child = os.fork()
            if child == 0:
                calls = [pool.send_reset, pool.recv, pool.save, lambda: pool.in_flight,
                         lambda: pool.send(np.zeros((8, 4), np.float32))]
                refused = 0
                for call in calls:
                    try:
                        call()
                    except RuntimeError as error:
                        refused += "fork" in str(error)
                pool.close()
                own = Pool(pool.compiled, 2, num_threads=2)
                own.send_reset()
                refused += len(own.recv())
                leave(10 * refused + 1)
            print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
        pool.send(np.zeros((8, 4), np.float32))
        print(len(pool.recv()))
    """)
    assert (result.returncode, result.stdout, result.stderr) == (0, "71\n71\n8\n", "")


def test_a_second_thread_in_a_pool_gets_an_error() -> None:
    pool = Pool(CompiledScenario(*SLOW), 400, num_threads=1)
    actions = begin(pool)
    started = threading.Event()
    received: list[int] = []

    def work() -> None:
        pool.send(actions)
        started.set()
        received.append(len(pool.recv()))

    thread = threading.Thread(target=work)
    thread.start()
    started.wait()
    refused = 0
    while thread.is_alive():
        try:
            pool.save()
        except skybody.Error as error:
            assert "in use by another thread" in str(error)
            refused += 1
        time.sleep(0.001)
    thread.join()
    assert received == [400]
    assert refused > 0  # the thread was inside recv() for much longer than a millisecond


def test_threads_that_share_a_pool_get_errors_or_results_and_lose_nothing(
    hover: CompiledScenario,
) -> None:
    pool = Pool(hover, 8, num_threads=2)
    actions = begin(pool)
    unexpected: list[BaseException] = []

    def work() -> None:
        for _ in range(300):
            try:
                pool.send(actions)
                pool.recv()
            except (skybody.Error, ValueError):  # in use; in flight already; nothing in flight
                pass
            except BaseException as error:
                unexpected.append(error)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert unexpected == []
    if pool.in_flight:
        pool.recv()
    pool.send(actions)
    assert len(pool.recv()) == 8


def test_pools_of_different_scenarios_and_plugin_paths_are_built_at_once(tmp_path: Path) -> None:
    plugins = Path(__file__).parents[2] / "build" / "release" / "tests" / "plugins" / "good"
    if not plugins.is_dir():
        pytest.skip("the tests' plugins are not built: ./dev build")
    # Each scenario needs a plugin from its own folder that exists nowhere else.
    needs = {
        "lane_task": ["task={plugin: lane_task}", "randomization=[]"],
        "delay_sensor": ["sensors=[{plugin: delay_sensor}]"],
    }
    hashes: dict[str, set[int]] = {name: set() for name in needs}

    def work(name: str) -> None:
        folder = tmp_path / name
        folder.mkdir()
        shutil.copy(plugins / f"{name}.so", folder)
        for _ in range(5):
            compiled = CompiledScenario("hover", needs[name], [folder])
            assert name in compiled.plugins
            pool = Pool(compiled, 4, num_threads=2, seed=1, keep_hash=True)
            actions = begin(pool)
            for _ in range(5):
                pool.send(actions)
                pool.recv()
            hashes[name].add(pool.hash())

    with ThreadPoolExecutor(2) as threads:
        list(threads.map(work, needs))  # raises the exception of a thread
    assert all(len(each) == 1 for each in hashes.values())  # the same every time
    assert hashes["lane_task"] != hashes["delay_sensor"]


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE")


def test_a_thousand_pools_leave_memory_handles_and_threads_flat(hover: CompiledScenario) -> None:
    actions = np.zeros((2, 4), np.float32)

    def cycle(count: int) -> None:
        for _ in range(count):
            with Pool(hover, 2, num_threads=2) as pool:
                pool.send_reset()
                pool.recv()
                pool.send(actions)
                pool.recv()

    cycle(100)  # the allocator's arenas and thread stacks exist afterwards
    before, handles = resident_bytes(), len(os.listdir("/proc/self/fd"))
    cycle(1000)
    # A pool of two hover environments uses far more than 100 KB; a leak of 4 KB each would show.
    assert resident_bytes() - before < 4_000_000
    assert len(os.listdir("/proc/self/fd")) == handles
