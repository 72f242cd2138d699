"""Frames per second of cameras beside Embree, PyBullet's TinyRenderer and MuJoCo's renderer.

    python -m research run camera_peers [--quick] [--out DIR]

bench_peer_embree is there if libembree-dev was found when it was built, MuJoCo's OSMesa needs
libosmesa6: `./dev bench --peers` installs both. The Python peers use .peers/contact; a trial leaves
them out unless it is there. All run on two processors, in turns, and the best round of each counts.
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import skybody

from research.common.machine import facts, machine_line, processors
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.common.places import PROGRAMS, ROOT
from research.common.programs import RunError, output_of
from research.common.throughput import QUICK, Length, measure
from research.peers import environments
from research.peers.environments import HERE, Skipped
from research.speed.camera_speed import BATCHES, ENVS, batch_case, draw

PAGE = "camera_peers"

RENDERER, EMBREE = PROGRAMS / "bench_render", PROGRAMS / "bench_peer_embree"
ALONE, FROM_PYTHON = "renderer alone", "from Python with physics"  # the two tasks
SIZE, FRAMES = 64, 2000
ROUNDS = 3
LENGTH = Length(trials=2, warm_up=20, receives=100, seconds=1.0, most=3.0)
CORES = 2
# Of the ground and of obstacles that `instance` shows.
GROUND, FIRST_OBSTACLE = 1, 3
OF_CAMERA = BATCHES["depth, instances"]  # of hover_camera
EMBREE_WAYS = [
    (shapes, rays) for shapes in ("triangles", "quads", "native") for rays in ("8", "16", "stream")
]
SCRIPTS = (
    ("PyBullet", "camera_pybullet.py", ()),
    ("MuJoCo, EGL", "camera_mujoco.py", ("--gl", "egl")),
    ("MuJoCo, OSMesa", "camera_mujoco.py", ("--gl", "osmesa")),
)
GOALS = {"Embree": 2.5, "PyBullet": 300.0, "MuJoCo": 30.0}  # ratios: ours to theirs
OURS = "Skybody"
# task, peer, version, mode, by_processor [frames per second of processor time]; with physics also
# rate [frames/s], seen, depth [m].
Row = dict[str, Any]


# --- the scene ----------------------------------------------------------------------------------


def bars(gate: skybody.Shape) -> list[dict[str, Any]]:
    """The four boxes of a gate, about its own place (core/model/gate.h)."""
    width, height, thickness = gate.size
    aside, above = 0.5 * (width + thickness), 0.5 * (height + thickness)
    post = [thickness, thickness, height + 2.0 * thickness]
    beam = [thickness, width, thickness]
    w, _, _, z = gate.rotation
    left = np.array([-2.0 * w * z, w * w - z * z, 0.0])  # y of a gate that is turned about z
    places = [(aside * left, post), (-aside * left, post)]
    places += [(np.array([0.0, 0.0, rise]), beam) for rise in (above, -above)]
    return [
        {"kind": "box", "size": size, "position": (np.array(gate.position) + place).tolist()}
        for place, size in places
    ]


def shapes_of(compiled: skybody.CompiledScenario) -> list[dict[str, Any]]:
    """The obstacles of `hover_camera`, gates as four boxes."""
    found = []
    for shape in compiled.obstacles:
        own = {"kind": shape.kind, "size": list(shape.size), "position": list(shape.position)}
        for part in bars(shape) if shape.kind == "gate" else [own]:
            more = {"rotation": list(shape.rotation), "instance": FIRST_OBSTACLE + shape.obstacle}
            found.append(part | more)
    return found


def scene_and_views(envs: int) -> tuple[dict[str, Any], dict[str, float]]:
    """The scene for peers (camera_scene.py), and the averages of our images of it."""
    case = batch_case(*OF_CAMERA)
    compiled = skybody.CompiledScenario(case.scenario, overrides=list(case.overrides))
    vectors = skybody.make_vec(compiled, envs, seed=1)
    images = vectors.reset()[0]
    places = [vectors.state(f"robots.quad.base.{name}") for name in ("position", "rotation")]
    scene = {
        "shapes": shapes_of(compiled),
        "poses": np.concatenate(places, axis=1).tolist(),
        "camera": [0.1, 0.0, 0.0],
        "pixels": SIZE,
        "field_of_view": 90.0,
        "farthest": 20.0,
        "substeps": compiled.action_repeat,
        "ground": GROUND,
    }
    depth, instance = images["front_depth"], images["front_instance"]
    near = depth < 20.0
    seen = float((near & (instance >= FIRST_OBSTACLE)).mean())
    return scene, {"seen": seen, "depth": float(depth[near].mean())}


def speed(row: Row) -> float:
    """Frames per second of processor time: the figure that is compared."""
    return float(row["by_processor"])


# --- measurements -------------------------------------------------------------------------------


def ours(views: dict[str, float], quick: bool) -> Iterator[Row]:
    """Our rows."""
    version = skybody.versions()["git"]
    start = {"peer": OURS, "version": version}
    frames = FRAMES // 20 if quick else FRAMES
    rate = draw(RENDERER, SIZE, "depth", frames).rate
    yield {**start, "task": ALONE, "mode": "bench_render", "by_processor": rate}
    trials = measure(batch_case(*OF_CAMERA), QUICK if quick else LENGTH)
    yield {
        **start,
        "task": FROM_PYTHON,
        "mode": "make_pool, 2 threads",
        "rate": max(trial.rate for trial in trials),
        "by_processor": max(trial.rate / (trial.cpu_use * processors()) for trial in trials),
        **views,
    }


def embree(quick: bool) -> Iterator[Row]:
    """Rows of Embree, all its ways.

    Raises:
        Skipped: its program was not built.
    """
    if not EMBREE.is_file():
        raise Skipped("bench_peer_embree was not built: libembree-dev is not there")
    frames = FRAMES // 20 if quick else FRAMES
    for shapes, rays in EMBREE_WAYS:
        words = ("--shapes", shapes, "--rays", rays, "--frames", str(frames), "--rounds", "3")
        found = json.loads(output_of([EMBREE, *words]))
        way = f"packets of {rays}" if rays.isdigit() else rays
        yield {
            "task": ALONE,
            "peer": "Embree",
            "version": found["version"],
            "mode": f"{shapes}, {way}",
            "by_processor": found["frames_per_second"],
        }


def scripted(name: str, script: str, scene: Path, words: tuple[str, ...]) -> Iterator[Row]:
    """Rows of a peer's script.

    Raises:
        Skipped: it is not installed, or a measurement failed.
    """
    quick = "--quick" in words
    if quick and not (environments.FOLDER / "contact").is_dir():
        raise Skipped(f"{name} is not installed, and a trial installs nothing")
    python = environments.python_of("contact")
    variables = {**os.environ, "PYTHONPATH": str(ROOT)}
    try:
        printed = output_of([python, HERE / script, "--scene", scene, *words], env=variables)
    except RunError as error:
        raise Skipped(str(error).splitlines()[-1]) from None
    for line in printed.splitlines():
        if line.startswith("{"):
            found = json.loads(line)
            if "skipped" in found:
                raise Skipped(found["skipped"])
            yield {**found, "task": FROM_PYTHON}


def measured(quick: bool) -> dict[str, Any]:
    """The best rows of all rounds by peer and mode, and reasons of missing ones."""
    scene, views = scene_and_views(ENVS)
    best: dict[tuple[str, str], Row] = {}
    skipped: dict[str, str] = {}
    effort = ("--seconds", "0.05", "--trials", "1", "--quick") if quick else ("--seconds", "1")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.json"
        file.write_text(json.dumps(scene), encoding="utf-8")
        for _ in range(1 if quick else ROUNDS):
            contestants = {OURS: ours(views, quick), "Embree": embree(quick)}
            for name, script, words in SCRIPTS:
                contestants[name] = scripted(name, script, file, (*words, *effort))
            for name, rows in contestants.items():
                try:
                    for row in rows:
                        print(f"{row['peer']}, {row['mode']}: {speed(row):,.0f}", flush=True)
                        key = row["peer"], row["mode"]
                        best[key] = max(row, best.get(key, row), key=speed)
                except Skipped as why:
                    skipped[name] = environments.plain(str(why))
    return {"rows": list(best.values()), "skipped": skipped, "shapes": len(scene["shapes"])}


# --- the page -----------------------------------------------------------------------------------


def best_of(rows: list[Row], peer: str, task: str) -> Row | None:
    """The fastest row of a contestant."""
    found = [row for row in rows if (row["peer"], row["task"]) == (peer, task)]
    return max(found, key=speed, default=None)


def ratio(mine: Row, theirs: Row) -> float:
    """Ours to theirs."""
    return speed(mine) / speed(theirs)


def table(rows: list[Row], task: str) -> str:
    """A task's rows, ours first."""
    mine = best_of(rows, OURS, task)
    assert mine is not None
    names = "contestant | mode | frames a processor second | ours / theirs"
    cells = [head(names + " | frames/s | seen | depth [m]" * (task == FROM_PYTHON))]
    for row in rows:
        if row["task"] != task:
            continue
        name = f"{row['peer']} {row['version']}"
        beside = "" if row is mine else f"{ratio(mine, row):.1f}"
        cells.append([name, row["mode"], f"{speed(row):,.0f}", beside])
        if task == FROM_PYTHON:
            cells[-1] += [
                f"{row['rate']:,.0f}",
                f"{100 * row['seen']:.2f} %",
                f"{row['depth']:.3f}",
            ]
    return markdown_table(cells, (0, 1))


def goals(rows: list[Row]) -> str:
    """The goals, with the best row of each peer."""
    cells = [head("peer | ours / theirs | goal | verdict")]
    for peer, least in GOALS.items():
        task = ALONE if peer == "Embree" else FROM_PYTHON
        mine, theirs = best_of(rows, OURS, task), best_of(rows, peer, task)
        if mine is None or theirs is None:
            cells.append([peer, "", f"{least:g}", "not measured"])
            continue
        found = ratio(mine, theirs)
        verdict = "met" if found >= least else "missed"
        cells.append([peer, f"{found:,.1f}", f"{least:g}", verdict])
    return markdown_table(cells, (0, 3))


def page(found: dict[str, Any]) -> str:
    """The page's text."""
    rows = found["rows"]
    missing = "".join(f"\nSkipped: {name}: {why}.\n" for name, why in found["skipped"].items())
    return f"""# Cameras beside other renderers

    .venv/bin/python -m research run camera_peers

{machine_line(found["facts"])}

Images of 64 x 64 pixels, depth and instances, a field of view of 90 degrees. All on the same
processors, in turns; the best of {found["rounds"]} rounds of each. Ratios are of frames per second
of processor time, since other programs ran beside, and of each peer's best mode.

{goals(rows)}
{missing}
## The renderer alone, on one thread

The scene of `bench_render`: 42 shapes and the ground ([camera_speed](camera_speed.md)), processor
time. Ours takes the places of all shapes anew in each frame; Embree's hierarchy is built once, of
high quality, so that it is not in its time. Triangles: 12 of a box, 1,024 of a ball or capsule;
quads: 6 and 512; native: Embree's own points and round curves. Rays are coherent; less than 0.1 %
of Embree's pixels differ from ours (`research/peers/embree_rays.cpp` compares them).

{table(rows, ALONE)}

## From Python, with physics

{ENVS} vehicles in the scene of `hover_camera`: {found["shapes"]} shapes, of which each gate is
four, and the ground. A frame is 20 physics steps of 1 ms and a new image of each vehicle's camera.
Two threads, or two processes. `seen`: share of pixels that see a shape; `depth`: mean depth of
pixels that see anything. TinyRenderer and OpenGL draw round shapes as triangles.

- Skybody: with rotors, contact, rewards, ends and resets; images are columns of the observation.
- PyBullet: `getCameraImage` by TinyRenderer. Vehicles without shapes share a world, which saves
  calls; or each has its own, as in a batch of environments, with shadows as by default.
- MuJoCo: a world for each vehicle, no contact; Mesa's llvmpipe draws on the processor, by EGL or
  OSMesa, without shadows and multisampling, `LP_NUM_THREADS=0`. `mujoco.Renderer` draws a frame for
  the depth and one for the segmentation; "one pass" calls the functions below it for both at once.

{table(rows, FROM_PYTHON)}
"""


def main() -> int:
    options = Options(__doc__, __name__, program=RENDERER).given()
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:CORES])
    found: dict[str, Any] = {"facts": facts(), "rounds": 1 if options.quick else ROUNDS}
    with environments.alone():
        found |= measured(options.quick)
    write_page(options.out, PAGE, page(found), found)
    return 0
