"""Steps a second in contact and with couplings, compared with flight, Simbody, MuJoCo and Bullet.

    python -m research run contact_speed [--quick] [--out DIR]

All figures are from one run: physics steps per second of all environments on one core.
"""

from __future__ import annotations

import json
import statistics
from dataclasses import dataclass
from typing import Any

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, thousands, write_page
from research.common.places import ROOT
from research.common.programs import output_of, run_bench
from research.peers import environments

PAGE = "contact_speed"


@dataclass(frozen=True)
class Case:
    """Arguments of `skybody bench` on one core."""

    name: str
    scenario: str
    actions: str = "hold"
    envs: int = 256
    overrides: tuple[str, ...] = ()

    def run(self, seconds: float) -> dict[str, float]:
        """Physics steps a second, and the share of those with bodies near contact."""
        words = ("--actions", self.actions)
        found = run_bench(self.scenario, seconds, *words, envs=self.envs, overrides=self.overrides)
        return {"rate": found["physics_steps_per_second"], "near": found["near_share"]}


FORMATIONS = {2: "formation_2", 5: "formation", 10: "formation_10", 20: "formation_20"}
HOVER_RANGE = 2782  # [rad/s]: the largest speed for which an action of zero is hover speed


def in_flight(robots: int) -> tuple[str, ...]:
    """Overrides: a constant action of zero hovers, in episodes of a second."""
    speeds = (
        f"robots[{k}].controllers[0].parameters.max_speed={HOVER_RANGE}" for k in range(robots)
    )
    return ("stepping.horizon=1000", *speeds)


LYING = ("robots.quad.pose.position=[0,0,0.058]", "robots.quad.rotor_speed=0", "randomization=[]")
TUMBLES = ("task.parameters.tilt_max=3.1415", "task.parameters.yaw_max=4")
TEN_STEPS = ("stepping.action_repeat=10",)
CASES = [
    Case("hover", "hover", "hold", 512),
    Case("hover, K = 10", "hover", "hold", 512, TEN_STEPS),
    Case("all on the ground", "hover", "zero", 512, (*LYING, *TUMBLES)),
    *(
        Case(f"formation of {n}, {how}", name, "zero", 32, in_flight(n) * (how == "in flight"))
        for n, name in FORMATIONS.items()
        for how in ("in flight", "zero")
    ),
    *(
        Case(f"formation of {n}, zero, K = 10", name, "zero", 32, TEN_STEPS)
        for n, name in FORMATIONS.items()
    ),
    Case("forest, hold", "forest", "hold", 512),
    Case("forest, random, ends by tilt", "forest", "random", 512),
    Case("forest, random, 1.25 s", "forest", "random", 512, ("stepping.horizon=125", *TUMBLES)),
    Case("forest, random, 10 s", "forest", "random", 512, TUMBLES),
    Case("plate on rods", "cooperative_payload"),
    Case(
        "plate on rods, Simbody", "cooperative_payload", "hold", 8, ("stepping.dynamics=simbody",)
    ),
]


def from_peers(seconds: float) -> list[dict[str, Any]]:
    python = environments.python_of("contact")
    script = ROOT / "research/peers/contact_scenes.py"
    printed = output_of([python, script, str(seconds)])
    return [json.loads(line) for line in printed.splitlines() if line.startswith("{")]


def measured(trials: int, seconds: float, with_peers: bool) -> dict[str, Any]:
    ours: dict[str, list[dict[str, float]]] = {case.name: [] for case in CASES}
    theirs: list[dict[str, Any]] = []
    for trial in range(trials):
        for case in CASES:
            ours[case.name].append(case.run(seconds))
            print(
                f"{trial + 1}/{trials} {case.name}: {ours[case.name][-1]['rate']:,.0f}", flush=True
            )
        theirs += from_peers(seconds) if with_peers else []
    return {"ours": ours, "peers": theirs}


def median(found: dict[str, Any], name: str) -> float:
    return statistics.median(trial["rate"] for trial in found["ours"][name])


def of_peer(found: dict[str, Any], engine: str, scene: str) -> float | None:
    rates = [r["rate"] for r in found["peers"] if (r["engine"], r["scene"]) == (engine, scene)]
    return statistics.median(rates) if rates else None


def against(ours: float, theirs: float | None) -> str:
    return "" if theirs is None else f"{thousands(theirs)} ({ours / theirs:,.0f}x)"


def page(found: dict[str, Any]) -> str:
    rows = [head("case | steps/s | near | of flight | of hover")]
    flight = {"forest": "hover, K = 10", "all on": "hover"}
    for case in CASES:
        rate = median(found, case.name)
        near = statistics.median(trial["near"] for trial in found["ours"][case.name])
        base = next((b for prefix, b in flight.items() if case.name.startswith(prefix)), None)
        if case.name.endswith(", zero"):
            base = case.name.replace("zero", "in flight")
        share = f"{rate / median(found, base):.2f}" if base else ""
        of_hover = f"{rate / median(found, 'hover'):.2f}"
        rows.append([case.name, thousands(rate), f"{100 * near:.1f} %", share, of_hover])
    peers = [["scene", "Skybody", "MuJoCo", "Bullet"]]
    scenes = {f"on the ground, {n}": f"formation of {n}, zero, K = 10" for n in FORMATIONS}
    scenes = {"on the ground, 1": "all on the ground", **scenes, "plate on rods": "plate on rods"}
    for scene, name in scenes.items():
        rate = median(found, name)
        peers.append(
            [
                scene,
                thousands(rate),
                against(rate, of_peer(found, "MuJoCo", scene)),
                against(rate, of_peer(found, "Bullet", scene)),
            ]
        )
    simbody = median(found, "plate on rods") / median(found, "plate on rods, Simbody")
    return f"""# Speed in contact and with couplings

{machine_line(found["facts"])}

    .venv/bin/python -m research run contact_speed

Thousands of physics steps a second on one core: all environments together, median of
{found["trials"]} trials of {found["seconds"]:g} s. `near`: steps in which something was near
enough to touch. `zero` is the formation's constant action of the paper, 68 % of the thrust that
hovers: all fall and lie. `of flight`: of the same robots in flight with as many steps an action,
in the forest of `hover, K = 10`; `of hover`: of the scenario `hover` as it is shipped.
`random, 1.25 s` and `10 s`: nothing ends an episode but that time, so that vehicles crash into
trees and ground, and thrash there.

{markdown_table(rows)}

The plate on rods makes {simbody:,.0f} times the steps of the same world on Simbody.

## Beside MuJoCo and Bullet

The same scenes, a world on a core each, contact on, dt 1 ms: vehicles of one box and four feet
that carry 68 % of their weight and lie on the ground; and three of them above a plate on rods
(MuJoCo: tendons of fixed length). `research/peers/contact_scenes.py` has them. Our steps are those
of whole environments, with rotors and controllers, and with observation and reward after every
tenth (the plate and the single vehicle: after every) step; theirs are physics alone.

{markdown_table(peers)}
"""


def main() -> int:
    options = Options(__doc__, __name__).given()
    trials, seconds = (1, 0.05) if options.quick else (3, 2.0)
    found = {"facts": facts(), "trials": trials, "seconds": seconds}
    found |= measured(trials, seconds, not options.quick)
    write_page(options.out, PAGE, page(found), found)
    return 0
