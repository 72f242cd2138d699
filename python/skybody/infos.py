"""The task's info values: from columns of a batch to the dictionaries that learners expect."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ._native import Batch, CompiledScenario

RESERVED = (
    "env_id",
    "was_reset",
    "fault",
    "fault_reason",
    "agent_reward",
    "privileged",
    "final_obs",
    "final_info",
    "terminal_observation",  # Stable-Baselines3's
)


class InfoRows(Protocol):
    """Where infos come from: a `Batch`, or some of its rows (`ScatteredRows`)."""

    @property
    def info(self) -> NDArray[np.float32]: ...
    @property
    def privileged(self) -> NDArray[np.float32]: ...
    @property
    def agent_reward(self) -> NDArray[np.float32]: ...
    @property
    def fault(self) -> NDArray[np.bool_]: ...
    @property
    def fault_reasons(self) -> Any: ...


class ScatteredRows:
    """Rows of a batch at the places of their environments; zeros, and no reasons, elsewhere.

    Args:
        batch: the rows. All of its faults are among those taken.
        num_envs: number of environments.
        envs: environments of the rows that are taken.
        ended: the rows of the same numbers, as they were before the reset (same-step autoreset);
            False: all rows, in order.
    """

    def __init__(self, batch: Batch, num_envs: int, envs: NDArray[Any], ended: bool) -> None:
        self._batch, self._num_envs, self._envs, self._ended = batch, num_envs, envs, ended
        self.mask = np.zeros(num_envs, np.bool_)
        self.mask[envs] = True

    def _scattered(self, values: NDArray[Any]) -> NDArray[Any]:
        nothing = None if values.dtype == object else 0
        out = np.full((self._num_envs, *values.shape[1:]), nothing, values.dtype)
        out[self._envs] = values[self._envs] if self._ended else values
        return out

    @property
    def info(self) -> NDArray[np.float32]:
        return self._scattered(self._batch.final_info if self._ended else self._batch.info)

    @property
    def privileged(self) -> NDArray[np.float32]:
        batch = self._batch
        return self._scattered(batch.final_privileged if self._ended else batch.privileged)

    @property
    def agent_reward(self) -> NDArray[np.float32]:
        return self._scattered(self._batch.agent_reward)

    @property
    def fault(self) -> NDArray[np.bool_]:
        return self._scattered(self._batch.fault)

    @property
    def fault_reasons(self) -> Any:
        reasons = self._batch.fault_reasons
        return None if reasons is None else self._scattered(np.array(reasons, dtype=object))


class InfoChannels:
    """Where each of a task's info values lies in a row of `Batch.info`.

    Beside them an info has `privileged` where the scenario has privileged columns.

    Args:
        present: whether rows carry them at all; else there are none.

    Raises:
        ValueError: a task declares an info value under a name that Skybody uses itself.
    """

    def __init__(self, compiled: CompiledScenario, present: bool = True) -> None:
        self._has_privileged = compiled.privileged_size > 0
        self._team = len(compiled.agents) > 1
        self._columns: list[tuple[str, str, int | slice]] = []
        for channel in compiled.info_channels if present else ():
            if channel.name in RESERVED:
                raise ValueError(
                    f"the task of `{compiled.name}` declares an info value `{channel.name}`, "
                    f"but Skybody itself uses the names {', '.join(RESERVED)}: rename it"
                )
            end = channel.first + channel.count
            where = channel.first if channel.count == 1 else slice(channel.first, end)
            self._columns.append((channel.name, "_" + channel.name, where))

    def columns(
        self, rows: NDArray[np.float32], privileged: NDArray[np.float32]
    ) -> dict[str, NDArray[Any]]:
        """One array per info value, (n,) or (n, count): views of `rows`, (n, info_size)."""
        infos: dict[str, NDArray[Any]] = {name: rows[:, where] for name, _, where in self._columns}
        if self._has_privileged:
            infos["privileged"] = privileged
        return infos

    def masked(self, rows: InfoRows, mask: NDArray[np.bool_]) -> dict[str, Any]:
        """Info values, faults and rewards of agents with Gymnasium's `_name` masks, which say for
        which environments a value is given.

        A vector environment calls it in each step, so that it looks at no column in vain.
        """
        infos: dict[str, Any] = {}
        if self._columns:
            values = rows.info.T  # its rows are views that take half the time of columns
            for name, mask_name, where in self._columns:
                infos[name] = values[where] if type(where) is int else values[where].T
                infos[mask_name] = mask
        if self._has_privileged:
            infos["privileged"], infos["_privileged"] = rows.privileged, mask
        infos["fault"], infos["_fault"] = rows.fault, mask
        if (reasons := rows.fault_reasons) is not None:
            add_fault_reasons(infos, reasons)
        if self._team:
            infos["agent_reward"], infos["_agent_reward"] = rows.agent_reward, mask
        return infos

    def of_row(self, row: NDArray[np.float32], privileged: NDArray[np.float32]) -> dict[str, Any]:
        """Values of one row, (info_size,): np.float32 each, or a copy (count,)."""
        info: dict[str, Any] = {
            name: row[where].copy() if isinstance(where, slice) else row[where]
            for name, _, where in self._columns
        }
        if self._has_privileged:
            info["privileged"] = privileged.copy()
        return info


def add_fault_reasons(infos: dict[str, Any], reasons: Any) -> None:
    """`fault_reason`, a text for each row that is a fault, None elsewhere; its mask is `fault`."""
    infos["fault_reason"] = np.asarray(reasons, dtype=object)
    infos["_fault_reason"] = infos["fault"]
