"""Rates of `skybody bench` on one core, for the experiments that compare scenarios."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass

from throughput import ROOT

PROGRAM = ROOT / "build/release/bin/skybody"


@dataclass(frozen=True)
class Case:
    """Arguments of `skybody bench`."""

    name: str
    scenario: str
    actions: str = "hold"
    envs: int = 256
    overrides: tuple[str, ...] = ()


def run(case: Case, seconds: float) -> dict[str, float]:
    """Physics steps per second of all environments on one core, and the share of steps with
    bodies near contact.
    """
    command = [str(PROGRAM), "bench", case.scenario, "--json", "--threads", "1"]
    command += ["--envs", str(case.envs), "--actions", case.actions, "--seconds", str(seconds)]
    for override in case.overrides:
        command += ["--set", override]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")
    found = json.loads(done.stdout)
    return {"rate": float(found["physics_steps_per_second"]), "near": float(found["near_share"])}
