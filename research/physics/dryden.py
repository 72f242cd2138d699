"""Whether turbulence has the spectra of MIL-F-8785C.

    python -m research run dryden [--quick] [--out DIR]

The turbulence of 256 environments is sampled every 10 ms, a million times in each, from the info
value `dryden.velocity`. Welch's method gives its spectral densities, which are compared in
bands of a third of an octave with the standard's. Sampling folds frequencies above the Nyquist
frequency into the visible range, so the standard's densities are folded likewise.
"""

from __future__ import annotations

import itertools
import math
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import skybody
from numpy.typing import NDArray

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.common.places import ROOT
from research.common.plots import panels, save

PAGE = "dryden"

FOOT = 0.3048  # [m]
SAMPLE_TIME = 0.01  # [s]
HEIGHT = 20.0 * FOOT  # [m]
AIRSPEED = 10.0  # [m/s]
WIND_AT_20_FEET = 10.0  # [m/s]
COMPONENTS = ("u", "v", "w")
ENVS = 256
GOOD = 0.03  # deviation of a band from the standard
FEWEST = 2000  # minimum of averages of an evaluated band
FOLDS = 2000  # multiples of the sampling frequency that are folded into the standard's densities

# No vehicle flies: the scenario is a fixed deck on a rail in wind.
SCENARIO = """
name: dryden
stepping: {{dt: {dt}, action_repeat: 1}}
robots:
  - name: pad
    model: {models}/pad/pad.urdf
    pose: {{position: [0, 0, 1]}}
    controllers: [{{plugin: rail, parameters: {{times: [0, 1e9], positions: [0, 0, 0, 0, 0, 0]}}}}]
effects:
  - plugin: dryden
    parameters: {{height: {height}, airspeed: {airspeed}, wind_at_20_feet: {wind}, period: 1}}
task: {{plugin: watch, parameters: {{link: {link}}}}}
"""


def standard() -> dict[str, tuple[float, float]]:
    """Length [m] and sigma [m/s] of each component by the standard's low-altitude model."""
    feet = HEIGHT / FOOT
    base = 0.177 + 0.000823 * feet
    level = (FOOT * feet / base**1.2, 0.1 * WIND_AT_20_FEET / base**0.4)
    return {"u": level, "v": level, "w": (FOOT * feet, 0.1 * WIND_AT_20_FEET)}


def density(component: str, frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    """The standard's one-sided density [(m/s)^2/Hz] at a frequency [Hz]."""
    length, sigma = standard()[component]
    time_constant = length / AIRSPEED
    square = (2.0 * math.pi * frequency * time_constant) ** 2
    if component == "u":
        return 4.0 * sigma**2 * time_constant / (1.0 + square)
    return 2.0 * sigma**2 * time_constant * (1.0 + 3.0 * square) / (1.0 + square) ** 2


def folded(component: str, frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    """The density of samples: the sum of the process's densities at all aliased frequencies."""
    total = density(component, frequency)
    for fold in range(1, FOLDS + 1):
        total += density(component, fold / SAMPLE_TIME + frequency)
        total += density(component, fold / SAMPLE_TIME - frequency)
    return total


def samples(count: int, chunk: int) -> Iterator[NDArray[np.float32]]:
    """Velocities (chunk, 3, ENVS) [m/s], one chunk after another."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "dryden.yaml"
        file.write_text(
            SCENARIO.format(
                dt=SAMPLE_TIME,
                models=ROOT / "scenarios/models",
                height=HEIGHT,
                airspeed=AIRSPEED,
                wind=WIND_AT_20_FEET,
                link="deck",
            )
        )
        envs = skybody.make_vec(str(file), ENVS, seed=1, infos=True)
    try:
        envs.reset()
        actions = np.zeros((ENVS, envs.compiled.action_size), np.float32)
        rows = np.empty((chunk, ENVS, 3), np.float32)
        for _ in range(count // chunk):
            for row in rows:
                row[:] = envs.step(actions)[4]["dryden.velocity"]
            yield rows.transpose(0, 2, 1).copy()
    finally:
        envs.close()


def measured(count: int, segment: int) -> dict[str, Any]:
    """Mean spectra (3, segment/2 + 1) [(m/s)^2/Hz] by Welch: Hann windows that overlap by half."""
    window = np.hanning(segment + 1)[:-1].astype(np.float32)
    scale = 2.0 * SAMPLE_TIME / float(np.sum(window.astype(np.float64) ** 2))
    spectra = np.zeros((3, segment // 2 + 1))
    squares, number, segments = np.zeros(3), 0, 0
    half: NDArray[np.float32] | None = None
    for rows in samples(count, segment // 2):
        squares += np.sum(rows.astype(np.float64) ** 2, axis=(0, 2))
        number += rows.shape[0] * ENVS
        if half is not None:
            whole = np.concatenate((half, rows)) * window[:, None, None]
            for k in range(3):
                power = np.abs(np.fft.rfft(whole[:, k, :], axis=0)) ** 2
                spectra[k] += scale * np.mean(power, axis=1)
            segments += 1
        half = rows
    return {
        "spectra": spectra / segments,
        "segments": segments * ENVS,
        "sigma": np.sqrt(squares / number),
    }


def bands(found: dict[str, Any], segment: int) -> list[dict[str, Any]]:
    """Means over thirds of octaves, from the second line of the spectrum to Nyquist."""
    step = 1.0 / (segment * SAMPLE_TIME)
    lines = np.arange(segment // 2, dtype=np.float64) * step
    theory = {name: folded(name, lines) for name in COMPONENTS}
    edges = [2]
    while edges[-1] < len(lines):
        edges.append(max(edges[-1] + 1, round(edges[-1] * 2.0 ** (1.0 / 3.0))))
    result = []
    for low, high in itertools.pairwise(edges):
        inside = slice(low, min(high, len(lines)))
        width = len(lines[inside])
        entry: dict[str, Any] = {
            "frequency": float(np.sqrt(lines[inside][0] * lines[inside][-1])),
            # Adjacent lines of a Hann window are correlated: three count as two.
            "averages": int(found["segments"] * max(1.0, width / 1.5)),
        }
        for k, name in enumerate(COMPONENTS):
            mean = float(np.mean(found["spectra"][k][inside]))
            expected = float(np.mean(theory[name][inside]))
            entry[name] = {"density": mean, "standard": expected, "ratio": mean / expected}
        result.append(entry)
    return result


def summary(results: dict[str, Any]) -> list[list[Any]]:
    """A row for each component."""
    rows: list[list[Any]] = [
        head("component | L [m] | sigma [m/s] | found | bands | largest deviation | at [Hz]")
    ]
    judged = [band for band in results["bands"] if band["averages"] >= FEWEST]
    for name in COMPONENTS:
        length, sigma = standard()[name]
        worst = max(judged, key=lambda band: abs(band[name]["ratio"] - 1.0))
        numbers = [f"{length:.2f}", f"{sigma:.4f}", f"{results['sigma'][name]:.4f}", len(judged)]
        deviation = f"{100.0 * (worst[name]['ratio'] - 1.0):+.2f} %"
        rows.append([name, *numbers, deviation, f"{worst['frequency']:.3g}"])
    return rows


def is_good(results: dict[str, Any]) -> bool:
    return all(
        abs(band[name]["ratio"] - 1.0) <= GOOD
        for band in results["bands"]
        if band["averages"] >= FEWEST
        for name in COMPONENTS
    )


def page(results: dict[str, Any]) -> str:
    fewest = min(band["averages"] for band in results["bands"])
    verdict = "is" if is_good(results) else "IS NOT"
    highest = results["bands"][-1]
    process = float(density("u", np.array([highest["frequency"]]))[0])
    return f"""# Spectra of the Dryden turbulence

{machine_line(results["facts"])}

    .venv/bin/python -m research run dryden

The effect `dryden` at a height of 20 ft, with an airspeed of {AIRSPEED:g} m/s and a wind of
{WIND_AT_20_FEET:g} m/s at 20 ft, called every {1e3 * SAMPLE_TIME:g} ms: {ENVS} environments with
{results["samples"]:,} samples each. Spectra by Welch's method (segments of {results["segment"]:,}
samples, Hann windows that overlap by half) in bands of a third of an octave, each the mean of
{fewest:,} periodograms or more, beside the densities of MIL-F-8785C
([effects/dryden/README.md](../../effects/dryden/README.md)). The standard's are folded about the
Nyquist frequency, as sampling folds the process: at {highest["frequency"]:.0f} Hz that makes
{highest["u"]["standard"] / process:.1f} times the density of the process itself.

Every band {verdict} within {100 * GOOD:g} % of the standard. `found` is the standard deviation of
all samples.

{markdown_table(summary(results))}

![Spectral densities found and by the standard, and their ratio](images/dryden.png)
"""


def write_picture(results: dict[str, Any], path: Path) -> None:
    """Plots densities above, ratios below."""
    figure, axes = panels(2, 1, (8, 7), sharex=True, height_ratios=(3, 1))
    above, below = axes.flat
    shown = np.array([band["frequency"] for band in results["bands"]])
    lines = np.geomspace(shown[0], 0.5 / SAMPLE_TIME, 300)
    colours = ("#1f77b4", "#ff7f0e", "#2ca02c")
    words = ("u, along the wind", "v, across", "w, up")
    for name, colour, word in zip(COMPONENTS, colours, words, strict=True):
        above.loglog(lines, folded(name, lines), color=colour, linewidth=1.2)
        above.loglog(lines, density(name, lines), color=colour, linewidth=0.8, linestyle=":")
        found = [band[name]["density"] for band in results["bands"]]
        above.loglog(shown, found, "o", color=colour, markersize=4, label=word)
        ratios = [band[name]["ratio"] for band in results["bands"]]
        below.semilogx(shown, ratios, "o-", color=colour, markersize=3, linewidth=0.7)
    above.set_ylabel("spectral density [(m/s)²/Hz]")
    above.set_title("Dots: found. Lines: MIL-F-8785C, as sampled; dotted: of the process")
    above.legend(frameon=False)
    below.axhspan(1.0 - GOOD, 1.0 + GOOD, color="0.9")
    below.set_ylim(0.95, 1.05)
    below.set_ylabel("found / standard")
    below.set_xlabel("frequency [Hz]")
    save(figure, path, 110)


def main() -> int:
    options = Options(__doc__, __name__).given()
    count, segment = (40_000, 8192) if options.quick else (1_000_000, 32_768)
    # Rounded up to whole halves of segments.
    count = -(-count // (segment // 2)) * (segment // 2)
    began = time.perf_counter()
    found = measured(count, segment)
    results = {
        "facts": facts(),
        "seconds": time.perf_counter() - began,
        "samples": count,
        "segment": segment,
        "sigma": dict(zip(COMPONENTS, found["sigma"].tolist(), strict=True)),
        "bands": bands(found, segment),
    }
    write_page(options.out, PAGE, page(results), results)
    print(f"{results['seconds']:.0f} s")
    write_picture(results, options.out / "images/dryden.png")
    return 0 if options.quick or is_good(results) else 1
