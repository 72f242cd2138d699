"""A camera and a lidar on a racing vehicle: adds them to a scenario, and saves their images.

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

WIDTH, HEIGHT = 480, 360
RINGS = np.radians(np.linspace(-30, 10, 40)).tolist()
SENSORS = f"""sensors=[{{plugin: camera, name: front, parameters: {{robot: red,
position: [0.1, 0, 0.05],
width: {WIDTH}, height: {HEIGHT}, field_of_view: 1.6, max_range: 20, period: 20,
outputs: [rgb, depth, instance, normal, flow]}}}},
{{plugin: lidar, name: scan, parameters: {{robot: red, max_range: 20, period: 20,
elevations: {RINGS}, columns: 1440, outputs: [points, range], axes: world}}}}]"""
IMAGES = ("rgb", "depth", "instance", "normal", "flow")
OBSERVE = f"observe=[{', '.join(f'front.{name}' for name in IMAGES)}, scan.points, scan.range]"
PIXELS_PER_METRE = 28  # of the lidar's points from above
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


def flow_colors(flow: NDArray[Any]) -> Pixels:
    """Directions as hues, speeds as brightness."""
    angle = np.arctan2(flow[..., 1], flow[..., 0]) / (2 * np.pi) + 0.5
    speed = np.linalg.norm(flow, axis=-1)
    share = np.minimum(speed / np.percentile(speed, 99), 1.0)
    return (in_colors(angle, "hsv") * share[..., None]).astype(np.uint8)


def points_from_above(points: NDArray[Any], ranges: NDArray[Any]) -> Pixels:
    """Returns of a scan, coloured by height; x of W is up."""
    image = np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)
    hits = points[ranges < ranges.max()]
    middle = hits[:, :2].mean(axis=0)
    row = (HEIGHT / 2 - (hits[:, 0] - middle[0]) * PIXELS_PER_METRE).astype(int)
    column = (WIDTH / 2 - (hits[:, 1] - middle[1]) * PIXELS_PER_METRE).astype(int)
    inside = (row >= 0) & (row < HEIGHT) & (column >= 0) & (column < WIDTH)
    colors = in_colors(np.clip(hits[:, 2] / 3, 0, 1) * 0.85 + 0.15, "turbo")
    image[row[inside], column[inside]] = colors[inside]
    return image


def picture(observation: dict[str, NDArray[Any]]) -> Pixels:
    """Six images of the first environment, in two rows."""
    rgb, depth, instance, normal, flow = (observation[f"front_{name}"][0] for name in IMAGES)
    near = in_colors(np.exp(-depth / 4), "magma")
    ids = in_colors((instance % 20) / 20, "tab20") * (instance[..., None] > 0).astype(np.uint8)
    toward = (127.5 * (1 + normal * [1, -1, -1])).astype(np.uint8)
    above = points_from_above(observation["scan_points"][0], observation["scan_range"][0])
    rows = ((rgb, near, ids), (toward, flow_colors(flow), above))
    return np.concatenate([np.concatenate(row, axis=1) for row in rows])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("cameras.png"), help="the picture")
    options = parser.parse_args()
    envs = skybody.make_vec("racing_duel", 1, seed=1, overrides=[*PLACES, SENSORS, OBSERVE])
    envs.reset()
    forward = np.zeros(envs.action_space.shape, dtype=np.float32)
    for _ in range(8):  # at rest nothing flows
        observation = envs.step(forward)[0]
    Image.fromarray(picture(observation)).save(options.out)
    print(f"{options.out}: colours, depth, instances; normals, flow, the lidar's points from above")


if __name__ == "__main__":
    run_program(main)
