"""The state file: for each row that ended well here its commit and its time."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from research.common import page_data
from research.common.pages import write_json
from research.everything.rows import Row, measured_commit, sources_are_of


@dataclass
class Record:
    """Rows that have ended: {name: {commit, seconds}}."""

    file: Path

    def read(self) -> dict[str, Any]:
        """Empty if nothing was run."""
        return dict(json.loads(self.file.read_text())) if self.file.is_file() else {}

    def add(self, row: Row, seconds: float) -> None:
        """Adds a row that has ended."""
        ended = {"commit": page_data.commit(), "seconds": round(seconds, 1)}
        write_json(self.file, self.read() | {row.name: ended})

    def minutes(self, row: Row) -> float:
        """Time of the last run here, or the estimate of the plan."""
        ended = self.read().get(row.name)
        return ended["seconds"] / 60.0 if ended else row.minutes

    def has_ended(self, row: Row) -> bool:
        """Whether the row has ended here, with today's sources."""
        return sources_are_of(self.read().get(row.name, {}).get("commit", ""))

    def reason(self, row: Row, resume: bool) -> str | None:
        """Why the row need not run again; None: it must."""
        commit = measured_commit(row)
        if sources_are_of(commit):
            return f"its data are of {commit}, whose sources are today's"
        if resume and self.has_ended(row):
            return "it has ended here, with today's sources"
        return None
