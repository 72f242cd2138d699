"""Flies a trained policy by `skybody run`; compares its actions with those of PyTorch."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import torch
from numpy.typing import NDArray
from skybody.train.checkpoint import checkpoint_folders
from skybody.train.policy_file import read_policy
from torch import nn
from training_runs import ROOT, Run, RunError

TOLERANCE = 1e-6  # of actions in [-1, 1]: C++ computes in double, PyTorch in float
LEAST_ROWS = 1000
EPISODES = 3
PICTURE = "flight-0001.png"  # of the first episode


def fly_policy(program: Path, run: Run, out: Path) -> dict[str, Any]:
    """Flies the newest checkpoint; returns the printed table, and the comparison."""
    policy = os.path.relpath(run.folder.resolve(), ROOT)  # as in the picture's title
    command = [str(program.resolve()), "run", run.scenario, "--policy", policy]
    command += ["--episodes", str(EPISODES), "--seed", "1", "--out", str(out.resolve())]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        env={**os.environ, "SKYBODY_PYTHON": sys.executable},  # draws the pictures
    )
    if done.returncode != 0 or not (out / PICTURE).exists():
        raise RunError(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    observation, flown = recorded(out / "flight.h5")
    expected = torch_actions(run, observation)
    difference = float(np.abs(flown - expected).max())
    return {
        "learner": run.algorithm,
        "seed": run.seed,
        "table": done.stdout.partition("\n\n")[0],
        "rows": len(observation),
        "largest_difference": difference,
        "tolerance": TOLERANCE,
        "agrees": difference <= TOLERANCE,
    }


def recorded(log: Path) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Observations (n, O), and the resulting actions (n, A), of all episodes."""
    observations, actions = [], []
    with h5py.File(log) as file:
        for episode in file["episodes"].values():
            observations.append(episode["observation"][:-1])
            actions.append(episode["action"][1:])  # row k + 1 has the action for row k
    rows = sum(len(part) for part in observations)
    if rows < LEAST_ROWS:
        raise RunError(f"{log} has {rows} observations, too few to compare: {LEAST_ROWS} at least")
    return np.concatenate(observations), np.concatenate(actions).astype(np.float64)


def torch_actions(run: Run, observation: NDArray[np.float32]) -> NDArray[np.float64]:
    """The policy's actions (n, A) as computed by PyTorch in training: in single precision."""
    policy = read_policy(checkpoint_folders(run.folder)[-1] / "policy.h5")
    normalized = (torch.from_numpy(observation) - torch.from_numpy(policy.mean)) * torch.from_numpy(
        policy.scale
    )
    x = normalized.clamp(-policy.clip, policy.clip).float()
    for layer in policy.layers:
        weight, bias = (torch.from_numpy(values).float() for values in (layer.weight, layer.bias))
        x = nn.functional.linear(x, weight, bias)
        x = torch.tanh(x) if layer.activation == "tanh" else x
    return x.clamp(-1.0, 1.0).numpy().astype(np.float64)
