"""Info values: from columns of a batch to the info dictionaries of learners."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._native import Batch, CompiledScenario, InfoColumns

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


class ValueRows(NamedTuple):
    """Rows of info values and privileged rows."""

    info: NDArray[np.float32]
    privileged: NDArray[np.float32]


class InfoRows(NamedTuple):
    """All inputs of the infos."""

    info: NDArray[np.float32]
    privileged: NDArray[np.float32]
    agent_reward: NDArray[np.float32]
    fault: NDArray[np.bool_]
    fault_reasons: Any
    """One string or None per row; None: no fault."""
    clipped: NDArray[np.int32] | None


def final_values(batch: Batch) -> ValueRows:
    """Values of a batch before the reset (same-step autoreset)."""
    return ValueRows(batch.final_info, batch.final_privileged)


def scattered_rows(
    batch: Batch, num_envs: int, envs: NDArray[Any], ended: NDArray[np.intp] | None = None
) -> tuple[InfoRows, NDArray[np.bool_]]:
    """Rows of a batch at the indices of their environments; zeros and no reasons elsewhere.

    Args:
        batch: the source. All its faults must be among the rows taken.
        envs: environments of the rows taken.
        ended: the rows to take, with their values before the reset; None: all rows, with their
            present values.

    Returns:
        the rows, and the mask (num_envs,) of environments that have one.
    """

    def scattered(values: NDArray[Any]) -> NDArray[Any]:
        nothing = None if values.dtype == object else 0
        out = np.full((num_envs, *values.shape[1:]), nothing, values.dtype)
        out[envs] = values if ended is None else values[ended]
        return out

    mask = np.zeros(num_envs, np.bool_)
    mask[envs] = True
    values = ValueRows(batch.info, batch.privileged) if ended is None else final_values(batch)
    reasons, clipped = batch.fault_reasons, batch.clipped
    rows = InfoRows(
        scattered(values.info),
        scattered(values.privileged),
        scattered(batch.agent_reward),
        scattered(batch.fault),
        None if reasons is None else scattered(np.array(reasons, dtype=object)),
        None if clipped is None else scattered(clipped),
    )
    return rows, mask


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
        self._columns: list[tuple[str, int, int]] = []  # name, first column, number of columns
        for channel in compiled.info_channels if present else ():
            if channel.name in RESERVED:
                raise ValueError(
                    f"the task of `{compiled.name}` declares an info value `{channel.name}`, "
                    f"but Skybody itself uses the names {', '.join(RESERVED)}: rename it"
                )
            self._columns.append((channel.name, channel.first, channel.count))
        self._views = InfoColumns(self._columns)
        self._masks = ["_" + name for name, _, _ in self._columns]
        if self._has_privileged:
            self._masks.append("_privileged")

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_views"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._views = InfoColumns(self._columns)

    def columns(self, rows: Batch | InfoRows | ValueRows) -> dict[str, Any]:
        """One array per info value, (n,) or (n, count): views of the rows."""
        infos: dict[str, Any] = self._views.of(rows.info) if self._columns else {}
        if self._has_privileged:
            infos["privileged"] = rows.privileged
        return infos

    def masked(self, rows: Batch | InfoRows, mask: NDArray[np.bool_]) -> dict[str, Any]:
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

    def of_row(self, rows: Batch | ValueRows, i: int) -> dict[str, Any]:
        """Values of row `i`: np.float32 each, or a copy (count,)."""
        info: dict[str, Any] = {}
        if self._columns:
            row = rows.info[i]
            for name, first, count in self._columns:
                info[name] = row[first] if count == 1 else row[first : first + count].copy()
        if self._has_privileged:
            info["privileged"] = rows.privileged[i].copy()
        return info


def add_fault_reasons(infos: dict[str, Any], reasons: Any) -> None:
    """Adds `fault_reason`: a string for each faulted row, None elsewhere; its mask is `fault`."""
    infos["fault_reason"] = np.asarray(reasons, dtype=object)
    infos["_fault_reason"] = infos["fault"]
