"""Info values: from columns of a batch to the info dictionaries of learners."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ._native import Batch, CompiledScenario

RESERVED = (
    "env_id",
    "was_reset",
    "fault",
    "fault_reason",
    "clipped",
    "agent_reward",
    "privileged",
    "final_obs",
    "final_info",
    "terminal_observation",  # of Stable-Baselines3
)


class ValueRows(Protocol):
    """Rows of info values and privileged rows: a `Batch` or `KeptRows`."""

    @property
    def info(self) -> NDArray[np.float32]: ...
    @property
    def privileged(self) -> NDArray[np.float32]: ...


class InfoRows(ValueRows, Protocol):
    """All inputs of the infos: a `Batch`, `FinalRows` or `ScatteredRows`."""

    @property
    def agent_reward(self) -> NDArray[np.float32]: ...
    @property
    def fault(self) -> NDArray[np.bool_]: ...
    @property
    def fault_reasons(self) -> Any: ...
    @property
    def clipped(self) -> NDArray[np.int32] | None: ...


class KeptRows(NamedTuple):
    """Copies of values, valid after the batch has been recycled."""

    info: NDArray[np.float32]
    privileged: NDArray[np.float32]


class FinalRows:
    """The info values and privileged rows of a batch before the reset (same-step autoreset)."""

    def __init__(self, batch: Batch) -> None:
        self._batch = batch

    @property
    def info(self) -> NDArray[np.float32]:
        return self._batch.final_info

    @property
    def privileged(self) -> NDArray[np.float32]:
        return self._batch.final_privileged

    @property
    def agent_reward(self) -> NDArray[np.float32]:
        return self._batch.agent_reward

    @property
    def fault(self) -> NDArray[np.bool_]:
        return self._batch.fault

    @property
    def fault_reasons(self) -> Any:
        return self._batch.fault_reasons

    @property
    def clipped(self) -> NDArray[np.int32] | None:
        return self._batch.clipped


class ScatteredRows:
    """Some rows, scattered to the indices of their environments; zeros and no reasons elsewhere.

    Args:
        rows: the source. All its faults must be among the taken rows.
        num_envs: number of environments.
        envs: environments of the taken rows.
        taken: indices of the taken rows; None: all.

    `mask` (num_envs,) marks the environments that have a row.
    """

    def __init__(
        self,
        rows: InfoRows,
        num_envs: int,
        envs: NDArray[Any],
        taken: NDArray[np.intp] | None = None,
    ) -> None:
        self._rows, self._num_envs, self._envs = rows, num_envs, envs
        self._taken = slice(None) if taken is None else taken
        self.mask = np.zeros(num_envs, np.bool_)
        self.mask[envs] = True

    def _scattered(self, values: NDArray[Any]) -> NDArray[Any]:
        nothing = None if values.dtype == object else 0
        out = np.full((self._num_envs, *values.shape[1:]), nothing, values.dtype)
        out[self._envs] = values[self._taken]
        return out

    @property
    def info(self) -> NDArray[np.float32]:
        return self._scattered(self._rows.info)

    @property
    def privileged(self) -> NDArray[np.float32]:
        return self._scattered(self._rows.privileged)

    @property
    def agent_reward(self) -> NDArray[np.float32]:
        return self._scattered(self._rows.agent_reward)

    @property
    def fault(self) -> NDArray[np.bool_]:
        return self._scattered(self._rows.fault)

    @property
    def fault_reasons(self) -> Any:
        reasons = self._rows.fault_reasons
        return None if reasons is None else self._scattered(np.array(reasons, dtype=object))

    @property
    def clipped(self) -> NDArray[np.int32] | None:
        clipped = self._rows.clipped
        return None if clipped is None else self._scattered(clipped)


class InfoChannels:
    """Columns of the info values in a row of `Batch.info`: the task's, then other plugins'.

    An info also has `privileged` if the scenario has privileged columns.

    Args:
        present: whether rows have info values; if not, infos have none.

    Raises:
        ValueError: a task declares an info value under a name that Skybody uses itself.
    """

    def __init__(self, compiled: CompiledScenario, present: bool = True) -> None:
        self._has_privileged = compiled.privileged_size > 0
        self._team = len(compiled.agents) > 1
        self._columns: list[tuple[str, tuple[slice, int | slice]]] = []  # indices of all rows
        for channel in compiled.info_channels if present else ():
            if channel.name in RESERVED:
                raise ValueError(
                    f"the task of `{compiled.name}` declares an info value `{channel.name}`, "
                    f"but Skybody itself uses the names {', '.join(RESERVED)}: rename it"
                )
            end = channel.first + channel.count
            where = channel.first if channel.count == 1 else slice(channel.first, end)
            self._columns.append((channel.name, (slice(None), where)))
        self._masks = ["_" + name for name, _ in self._columns]
        if self._has_privileged:
            self._masks.append("_privileged")

    def columns(self, rows: ValueRows) -> dict[str, Any]:
        """One array per info value, (n,) or (n, count): views of the rows."""
        infos: dict[str, Any] = {}
        if self._columns:
            values = rows.info
            for name, where in self._columns:
                infos[name] = values[where]
        if self._has_privileged:
            infos["privileged"] = rows.privileged
        return infos

    def masked(self, rows: InfoRows, mask: NDArray[np.bool_]) -> dict[str, Any]:
        """Info values, faults and rewards of agents, with Gymnasium's `_name` masks.

        A mask marks the environments that have a value. A vector environment calls this in each
        step, so it does not scan the values.
        """
        infos = self.columns(rows)
        for name in self._masks:
            infos[name] = mask
        infos["fault"], infos["_fault"] = rows.fault, mask
        if (reasons := rows.fault_reasons) is not None:
            add_fault_reasons(infos, reasons)
        if (clipped := rows.clipped) is not None:
            infos["clipped"], infos["_clipped"] = clipped, mask
        if self._team:
            infos["agent_reward"], infos["_agent_reward"] = rows.agent_reward, mask
        return infos

    def of_row(self, rows: ValueRows, i: int) -> dict[str, Any]:
        """Values of row `i`: np.float32 each, or a copy (count,)."""
        info: dict[str, Any] = {}
        if self._columns:
            row = rows.info[i]
            for name, (_, where) in self._columns:
                info[name] = row[where].copy() if isinstance(where, slice) else row[where]
        if self._has_privileged:
            info["privileged"] = rows.privileged[i].copy()
        return info


def add_fault_reasons(infos: dict[str, Any], reasons: Any) -> None:
    """Adds `fault_reason`: a string for each faulted row, None elsewhere; its mask is `fault`."""
    infos["fault_reason"] = np.asarray(reasons, dtype=object)
    infos["_fault_reason"] = infos["fault"]
