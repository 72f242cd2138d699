"""Draws the shipped references, flown by a QDrone2, for controllers/reference/README.md.

    python -m research run reference_figures [--program build/release/bin/skybody]

Each is flown by `skybody run hover --reference NAME`; the path is dashed, the flight is a line.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from research.common.options import Options
from research.common.places import PROGRAM, ROOT
from research.common.programs import run_skybody

PAGE = "controllers/reference/figure.png"

FIGURE = ROOT / "controllers/reference/figure.png"
NAMES = ("circle", "helix", "figure_eight", "lissajous", "waypoints", "step")
APPROACH = 4.0  # s, of all shipped references
# Near each path, so that the approach does not fill the picture.
BEGIN = ("randomization=[]", "robots.quad.pose.position=[0, 0, 1.2]")


def fly(program: Path, name: str, folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, positions and references."""
    out = folder / name
    words = ("run", "hover", "--reference", name, "--out", out, "--no-picture", "--steps", "16000")
    run_skybody(*words, overrides=BEGIN, program=program)
    with h5py.File(out / "flight.h5") as log:
        episode = log["episodes"]["0001"]
        return episode["time"][:], episode["bodies"][:, 0, :3], episode["goal"][:, 0, :3]


def draw(panel, name: str, time: np.ndarray, flown: np.ndarray, path: np.ndarray) -> None:
    rows = time >= APPROACH
    panel.plot(*flown[rows].T, color="tab:blue", linewidth=1.2)
    panel.plot(*path[rows].T, color="black", linestyle=(0, (4, 3)), linewidth=0.9)
    error = 100.0 * np.linalg.norm(flown[rows] - path[rows], axis=1)
    panel.set_title(f"{name}: RMS {np.sqrt(np.mean(error**2)):.1f} cm", fontsize=10)
    points = path[rows]
    middle = 0.5 * (points.max(axis=0) + points.min(axis=0))
    half = 0.55 * max(float(np.ptp(points, axis=0).max()), 0.5)
    panel.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
    panel.set_zlim(max(0.0, middle[2] - half), middle[2] + half)
    panel.locator_params(nbins=4)
    panel.tick_params(labelsize=7, pad=0)
    panel.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")


def main() -> None:
    options = Options(__doc__, __name__, "one reference", PROGRAM).given()
    figure = plt.figure(figsize=(12, 7.4))
    with tempfile.TemporaryDirectory() as folder:
        for k, name in enumerate(NAMES[:1] if options.quick else NAMES):
            panel = figure.add_subplot(2, 3, k + 1, projection="3d")
            draw(panel, name, *fly(options.program, name, Path(folder)))
        figure.tight_layout()
        picture = options.out / FIGURE.name if options.quick else FIGURE
        figure.savefig(picture, dpi=110)
        print(picture)
