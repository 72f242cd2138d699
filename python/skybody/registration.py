"""Gymnasium ids of the shipped scenarios: `skybody/Hover-v0` for `hover`, and so on."""

from __future__ import annotations

SCENARIOS = (
    "arm",
    "boom",
    "chase",
    "chase_agents",
    "collision",
    "cooperative_payload",
    "downwash_pair",
    "forest",
    "formation",
    "formation_10",
    "formation_2",
    "formation_20",
    "four_bar",
    "gates",
    "hard_landing",
    "hover",
    "hover_crazyflie",
    "hover_firefly",
    "hover_hummingbird",
    "hover_learn",
    "low_battery",
    "obstacles",
    "obstacles_rays",
    "omav",
    "payload",
    "payload_paper",
    "platform_landing",
    "rotor_out",
    "trajectory_flights",
    "trajectory_training",
    "vehicles",
    "windy_hover",
)


def gymnasium_id(scenario: str) -> str:
    """`skybody/HoverLearn-v0` for `hover_learn`."""
    camel = "".join(word.capitalize() for word in scenario.split("_"))
    return f"skybody/{camel}-v0"


def register() -> None:
    """Registers all shipped scenarios with Gymnasium where it is installed; again does nothing.

    `gymnasium.make` gives a `SkybodyEnv`, `gymnasium.make_vec` a `SkybodyVectorEnv`.
    """
    try:
        import gymnasium
    except ImportError:
        return
    for scenario in SCENARIOS:
        name = gymnasium_id(scenario)
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="skybody.env:SkybodyEnv",
                vector_entry_point="skybody.vector:SkybodyVectorEnv",
                kwargs={"scenario": scenario},
            )
