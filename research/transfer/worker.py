"""Flies a policy in one simulator, with the Python of that simulator's environment.

python -m research.transfer.worker REQUEST.json OUT.npz

The request: `engine`, `policy` (an NPZ of network.arrays_of()), `condition` (fields of Condition),
`seconds`; of flights along references `form`, `seeds` and `references` (their number); of races
`races` (their number) and `seed`.
"""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from research.transfer import conditions, flight, quadrotor, race, references
from research.transfer.network import Network


def fly(request: dict[str, Any], module: Any, policy: Network) -> dict[str, Any]:
    """Flights along references: seed by seed, all references of each."""
    condition = conditions.Condition(**request["condition"])
    seeds, count = request["seeds"], request["references"]
    truth = conditions.draw(condition, seeds, count)
    figures = references.draw(count).repeated(len(seeds))
    quad, form = quadrotor.read(), flight.FORMS[request["form"]]
    world = module.Engine(quad, truth, flight.DT)
    given = (figures, truth, condition, request["seconds"], seeds[0])
    flown = flight.fly(world, quad, policy, form, *given)
    world.close()
    return {**vars(flown), "engine": world.name}


def race_all(request: dict[str, Any], module: Any, policy: Network) -> dict[str, Any]:
    """Races, each on a course of its own."""
    condition = conditions.Condition(**request["condition"])
    seed, count = request["seed"], request["races"]
    truth = conditions.draw(condition, [seed], count)
    races, quad = race.draw(count, seed), quadrotor.read()
    gates = [races[0].mjcf(k) for k in range(count)]
    world = module.Engine(quad, truth, race.DT, gates)
    given = (races, truth, condition, request["seconds"], seed)
    flown = race.fly(world, quad, policy, *given)
    centres = {"centres": races[0].centres, "yaws": races[0].yaws}
    return {**vars(flown), **centres, "engine": world.name}


def main() -> None:
    """Reads the request, writes the answer."""
    request = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    module = importlib.import_module(f"research.transfer.engine_{request['engine']}")
    answer = race_all if "races" in request else fly
    np.savez(sys.argv[2], **answer(request, module, Network(np.load(request["policy"]))))


if __name__ == "__main__":
    main()
