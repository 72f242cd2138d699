"""An omav moves level and holds tilted poses; an arm moves its gripper to a position under indi."""

from __future__ import annotations

import math

import numpy as np
from skybody import Simulation

LEVEL = [1.0, 0.0, 0.0, 0.0]


def omav() -> Simulation:
    sim = Simulation("omav", overrides=["randomization=[]"], seed=1)
    sim.reset()
    return sim


def tilt(sim: Simulation) -> float:
    """Tilt of the base [rad]."""
    _, x, y, _ = sim.base().rotation
    return math.acos(min(1.0, 1.0 - 2.0 * (x * x + y * y)))


def off(sim: Simulation, place: list[float]) -> float:
    return float(np.linalg.norm(np.asarray(sim.base().position) - place))


def test_an_omav_hovers_and_moves_without_leaning() -> None:
    sim = omav()
    sim.command([0.0, 0.0, 2.0, *LEVEL])
    assert sim.advance(3000)
    assert off(sim, [0.0, 0.0, 2.0]) < 1e-6
    place = [1.0, -0.5, 2.3]
    sim.command([*place, *LEVEL])
    steepest, quickest = 0.0, 0.0
    for _ in range(600):
        assert sim.advance(10)
        steepest = max(steepest, tilt(sim))
        quickest = max(quickest, float(np.linalg.norm(sim.base().velocity)))
    assert quickest > 0.5
    assert steepest < math.radians(2.0)  # arms and rotors lag behind the commanded wrench
    assert off(sim, place) < 1e-3
    angles = [sim.state(f"robots.omav.joints.{name}_tilt.position") for name in ("left", "right")]
    assert np.abs(angles).max() < 0.01


def test_an_omav_holds_a_tilted_pose() -> None:
    sim = omav()
    half = math.radians(40.0) / 2.0
    sim.command([0.0, 0.0, 2.0, math.cos(half), math.sin(half), 0.0, 0.0])
    assert sim.advance(8000)
    assert abs(tilt(sim) - math.radians(40.0)) < 1e-3
    assert off(sim, [0.0, 0.0, 2.0]) < 5e-3
    assert float(np.linalg.norm(sim.base().velocity)) < 1e-3


def test_an_omav_hovers_on_its_back_and_turns_back_over() -> None:
    sim = omav()
    place, on_its_back = [0.0, 0.0, 5.0], [0.0, 1.0, 0.0, 0.0]
    sim.teleport(position=place, rotation=on_its_back, velocity=[0.0, 0.0, 0.0])
    for rotation in (on_its_back, LEVEL):
        sim.command([*place, *rotation])
        assert sim.advance(8000)
        assert off(sim, place) < 1e-3
        turn = abs(float(np.dot(sim.base().rotation, rotation)))
        assert turn > math.cos(0.5 * math.radians(0.1))


def test_an_omav_goes_on_as_it_was_saved() -> None:
    sim = omav()
    sim.command([0.5, 0.5, 2.5, 0.9, 0.3, 0.1, 0.0])
    assert sim.advance(333)
    saved = sim.save()
    assert sim.advance(333)
    first = [*sim.base().position, *sim.rotor_speeds]
    sim.restore(saved)
    assert sim.advance(333)
    assert first == [*sim.base().position, *sim.rotor_speeds]


def reaching(extra: str = "") -> Simulation:
    """The world `arm` under indi, arm and joint_pd."""
    chain = (
        "robots[0].controllers=[{plugin: indi}, "
        "{plugin: arm, parameters: {joints: [shoulder, elbow], link: gripper}}, "
        "{plugin: joint_pd, parameters: {joints: [shoulder, elbow], effort_limit: 3.4"
        f"{extra}}}}}]"
    )
    sim = Simulation("arm", overrides=[chain, "randomization=[]"], seed=1)
    sim.reset()
    return sim


def command(sim: Simulation, place: list[float], tool: list[float]) -> None:
    sim.command([*place, *([0.0] * 14), *tool, *LEVEL])


def gripper(sim: Simulation) -> np.ndarray:
    """Gripper position: 0.2 m below the elbow along the forearm, whose body contains it."""
    forearm = sim.body("gripper")
    w, x, y, z = forearm.rotation
    down = -np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    return np.asarray(forearm.position) + 0.2 * down


def test_an_arm_reaches_while_indi_holds_its_place() -> None:
    sim = reaching()
    place, tool = [0.0, 0.0, 2.0], [0.1, 0.0, 2.0 - 0.38]
    command(sim, place, [-0.05, 0.0, 2.0 - 0.35])
    assert sim.advance(3000)
    command(sim, place, tool)
    farthest = 0.0
    for _ in range(300):
        assert sim.advance(10)
        farthest = max(farthest, off(sim, place))
    assert farthest < 0.03
    assert off(sim, place) < 1e-3
    assert np.linalg.norm(gripper(sim) - tool) < 1e-3


def test_gains_of_drawn_arms_follow_their_constants_where_the_scenario_says_so() -> None:
    places = {}
    for constants in ("nominal", "own"):
        sim = reaching(f", constants: {constants}")
        sim.set_param("robots.hexa.links.forearm.mass", 0.5)
        command(sim, [0.0, 0.0, 2.0], [0.1, 0.0, 2.0 - 0.38])
        assert sim.advance(6000)
        places[constants] = np.linalg.norm(gripper(sim) - [0.1, 0.0, 2.0 - 0.38])
    assert places["own"] < 1e-3  # compensates the actual weight
    assert places["nominal"] > 3 * places["own"]
