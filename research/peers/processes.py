"""Worlds of a library without its own batches, distributed over processes.

Commands and states are in shared memory; a byte through a pipe requests a step, a byte back
reports its end. So the states of all worlds are a NumPy array after each call, as for all peers.
"""

from __future__ import annotations

import contextlib
import multiprocessing
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Worlds(Protocol):
    def step(self, commands: Array, states: Array) -> None:
        """Steps all worlds with these commands and writes their states."""


Maker = Callable[[int], Worlds]


def shared(shape: tuple[int, ...]) -> Array:
    memory = multiprocessing.get_context("fork").RawArray("d", int(np.prod(shape)))
    return np.frombuffer(memory, np.float64).reshape(shape)


def serve(pipe: Connection, make: Maker, commands: Array, states: Array) -> None:
    """A process: steps its share at each request, until a request to end."""
    worlds = make(len(commands))
    pipe.send_bytes(b"r")
    while pipe.recv_bytes() == b"s":
        worlds.step(commands, states)
        pipe.send_bytes(b"d")


class Batch:
    """A number of worlds in several processes; with one process the caller steps them."""

    def __init__(
        self, make: Maker, commands: Array, states: tuple[int, ...], processes: int
    ) -> None:
        """make: creates a number of worlds. commands: (envs, ...), the same in every call. states:
        shape of one world's states.
        """
        envs = len(commands)
        self.commands, self.states = shared(commands.shape), shared((envs, *states))
        self.commands[:] = commands
        self.local = make(envs) if processes == 1 else None
        self.pipes, self.processes = [], []
        context = multiprocessing.get_context("fork")
        for k in range(processes if processes > 1 else 0):
            share = slice(envs * k // processes, envs * (k + 1) // processes)
            mine, other = context.Pipe()
            arguments = (other, make, self.commands[share], self.states[share])
            process = context.Process(target=serve, args=arguments, daemon=True)
            process.start()
            self.pipes.append(mine)
            self.processes.append(process)
        self.wait()

    def __call__(self) -> Array:
        if self.local:
            self.local.step(self.commands, self.states)
        for pipe in self.pipes:
            pipe.send_bytes(b"s")
        self.wait()
        return self.states

    def wait(self) -> None:
        for pipe, process in zip(self.pipes, self.processes, strict=True):
            while not pipe.poll(1.0):
                if not process.is_alive():
                    raise RuntimeError("a process ended by itself")
            pipe.recv_bytes()

    def close(self) -> None:
        for pipe, process in zip(self.pipes, self.processes, strict=True):
            with contextlib.suppress(OSError):  # it has already ended
                pipe.send_bytes(b"e")
            process.join()
