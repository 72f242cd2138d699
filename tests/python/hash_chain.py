"""The hash of policy.h5 and of replays, as described in docs/policies.md and docs/replay.md."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import h5py
import numpy as np

MASK = 2**64 - 1
EVENTS = ("kind", "count", "argument", "env_id", "action", "path", "saved")
TRANSITIONS = (
    *("env_id", "hash", "episode", "episode_step", "was_reset", "status", "reward"),
    *("observation", "state"),
)
COLUMNS = [f"events/{name}" for name in EVENTS] + [f"transitions/{name}" for name in TRANSITIONS]


class Chain:
    """HashChain of core/base/math/hash.h."""

    def __init__(self) -> None:
        self.state, self.count = 0x243F6A8885A308D3, 0

    def add(self, words: Iterable[int]) -> Chain:
        for word in words:
            state = ((self.state ^ word) * 0x9E3779B97F4A7C15) & MASK
            state = ((state ^ (state >> 32)) * 0xD6E8FEB86659FD93) & MASK
            self.state = state ^ (state >> 29)
            self.count += 1
        return self

    def value(self) -> int:
        value = self.state ^ (self.count * 0x9E3779B97F4A7C15 & MASK)
        value = ((value ^ (value >> 33)) * 0xFF51AFD7ED558CCD) & MASK
        value = ((value ^ (value >> 33)) * 0xC4CEB9FE1A85EC53) & MASK
        return value ^ (value >> 33)


def hash_of(content: bytes) -> int:
    """hash_bytes of core/base/math/hash.h."""
    padded = content + bytes(-len(content) % 8)
    return Chain().add([*np.frombuffer(padded, "<u8").tolist(), len(content)]).value()


def rehash(path: Path) -> None:
    """Updates a recording's hashes to match its content, as an attacker can."""
    with h5py.File(path, "r+") as file:
        chain = header_chain(file)
        rows = [0] * len(COLUMNS)
        for number, burst in enumerate(file["bursts"][()].tolist()):
            for k, name in enumerate(COLUMNS):
                first, rows[k] = rows[k], burst[k]
                if rows[k] > first:
                    content = file[name][first : rows[k]].tobytes()
                    chain.add([rows[k], hash_of(content)])
            file["bursts"][number, len(COLUMNS)] = chain.value()


def header_chain(file: h5py.File) -> Chain:
    """Hash over all fields of a recording's header."""
    texts = ("skybody_version", "scenario", "scenario_file", "scenario_text", "autoreset")
    chain = Chain().add(hash_of(bytes(file.attrs[name])) for name in texts)
    chain.add([int(file.attrs["scenario_hash"], 16)])
    chain.add(int(file.attrs[name]) for name in ("seed", "first_env_id", "envs", "action_size"))
    for name in ("overrides", "plugin_path", "columns", "observation_names", "state_names"):
        values = [bytes(value) for value in file[name][()]] if file[name].size else []
        chain.add([len(values), *(hash_of(value) for value in values)])
    return chain
