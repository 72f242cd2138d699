"""A camera on a racing vehicle: adds it to a scenario, and saves colours, depth, ids and normals.

python examples/camera.py [--out cameras.png]
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import skybody
from matplotlib import colormaps
from numpy.typing import NDArray
from PIL import Image
from skybody.program import run_program

CAMERA = """sensors=[{plugin: camera, name: front, parameters: {robot: ROBOT,
position: [0.1, 0, 0.05],
width: 480, height: 360, field_of_view: 1.6, max_range: 20, period: 20,
outputs: [rgb, depth, instance, normal]}}]"""
OBSERVE = "observe=[front.rgb, front.depth, front.instance, front.normal]"
# The camera's vehicle behind the other one, before the first gate.
PLACES = (
    "randomization=[]",
    "robots.red.pose={position: [3.3, -3.4, 1.9], rpy: [0, 0.15, 1.72]}",
    "robots.blue.pose={position: [3.2, -1.9, 1.7], rpy: [0.3, 0.2, 1.6]}",
)

Pixels = NDArray[np.uint8]


def in_colors(shares: NDArray[Any], name: str) -> Pixels:
    """Values in [0, 1] as colours of one of matplotlib's maps."""
    return (255 * colormaps[name](shares)[..., :3]).astype(np.uint8)


def picture(observation: dict[str, NDArray[Any]]) -> Pixels:
    """The four images of the first environment, two by two."""
    rgb, depth, instance, normal = (
        observation[f"front_{name}"][0] for name in ("rgb", "depth", "instance", "normal")
    )
    near = in_colors(np.exp(-depth / 4), "magma")
    ids = in_colors((instance % 20) / 20, "tab20") * (instance[..., None] > 0).astype(np.uint8)
    toward = (127.5 * (1 + normal * [1, -1, -1])).astype(np.uint8)
    return np.concatenate(
        [np.concatenate([rgb, near], axis=1), np.concatenate([ids, toward], axis=1)]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("cameras.png"), help="the picture")
    options = parser.parse_args()
    overrides = [*PLACES, CAMERA.replace("ROBOT", "red"), OBSERVE]
    envs = skybody.make_vec("racing_duel", 1, seed=1, overrides=overrides)
    observation, _ = envs.reset()
    Image.fromarray(picture(observation)).save(options.out)
    print(f"{options.out}: colours and depth, instances and normals")


if __name__ == "__main__":
    run_program(main)
