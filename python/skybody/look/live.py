"""Pictures of environments as they are now, for `render()` of Gymnasium and PettingZoo."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from skybody._native import CompiledScenario, Pool

from .film import Film, Frame, Panel, Size
from .motion import Array, Motion
from .rows import Rows
from .scene import Scene, Style

TRAIL = 2.0  # length of trails [s]
STYLE = Style(trail=TRAIL, trail_value="", reference=False, contacts=False)
World = tuple[float, ...]  # number of the episode, and values of the obstacles
PARTS = ("position", "rotation", "velocity", "angular_velocity")  # of a row of `bodies`


class Params(Mapping[str, float]):
    """Values of the parameters of an environment by path."""

    def __init__(self, pool: Pool, env: int) -> None:
        self._pool, self._env = pool, env
        self._paths = frozenset(pool.compiled.param_paths)

    def __getitem__(self, path: str) -> float:
        if path not in self._paths:
            raise KeyError(path)
        return self._pool.param(self._env, path)

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


class Live(Motion):
    """The states of an environment that were seen in the last seconds of its episode."""

    def __init__(self, pool: Pool, env: int) -> None:
        """Sees nothing yet."""
        self._pool, self._env = pool, env
        self._drawn = Params(pool, env)
        self.forget()

    def forget(self) -> None:
        """Begins anew."""
        self._rows: dict[str, list[Array]] = {"time": [], "bodies": [], "rotor_speed": []}
        self._rows["goal"] = []
        self._read: dict[str, Rows] = {}
        self._turns = np.zeros(len(self.compiled.rotors))

    def see(self, state: Mapping[str, Array]) -> None:
        """Adds the present state; one that was seen before it is no past counts from now on.

        Args:
            state: values of all environments by the names of rows.
        """
        now = float(state["time"][self._env])
        self._read.clear()
        times = self._rows["time"]
        if times and now < float(times[-1]):
            self.forget()
            times = self._rows["time"]
        if times and now == float(times[-1]):
            for rows in self._rows.values():
                rows.pop()
        for name, rows in self._rows.items():
            value = self._pool.goals(self._env) if name == "goal" else state[name][self._env]
            rows.append(np.asarray(value))
        if len(times) > 1:
            self._turns = self._turns + self._rows["rotor_speed"][-1] * (now - float(times[-2]))
        while len(times) > 1 and float(times[1]) < now - TRAIL - 1.0:
            for rows in self._rows.values():
                rows.pop(0)

    # --- as a motion ----------------------------------------------------------------------------

    @property
    def compiled(self) -> CompiledScenario:
        """The scenario."""
        return self._pool.compiled

    @property
    def drawn(self) -> Mapping[str, float]:
        """Values of the parameters by path, now."""
        return self._drawn

    @property
    def time(self) -> Array:
        """Of each row, since the reset [s]."""
        return np.array(self._rows["time"])

    @property
    def body_names(self) -> list[str]:
        """ROBOT.LINK of each body."""
        return list(self._pool.compiled.bodies)

    @property
    def goal_columns(self) -> Mapping[str, int]:
        """The goals by their numbers."""
        return {str(k): k for k in range(len(self._rows["goal"][-1]))}

    @property
    def touching(self) -> NDArray[np.bool_]:
        """It is not known: none."""
        return np.zeros(len(self._rows["time"]), bool)

    def rows(self, name: str) -> Rows:
        """The rows that were seen."""
        if name not in self._read:
            self._read[name] = Rows(np.array(self._rows[name]))
        return self._read[name]

    def turns(self, time: float) -> Array:
        """Angle of each rotor now [rad]."""
        return self._turns


class Pictures:
    """Draws some environments of a pool."""

    def __init__(self, pool: Pool, envs: int, size: tuple[int, int], camera: str) -> None:
        """Draws nothing yet.

        Args:
            pool: its environments have begun an episode whenever they are drawn.
            envs: the first so many are drawn.
            size: width and height [pixels].
            camera: of skybody.look.cameras.
        """
        self._pool, self._size, self._camera = pool, size, camera
        self._live = [Live(pool, env) for env in range(envs)]
        self._films: list[tuple[World, Film] | None] = [None] * envs
        paths = pool.compiled.param_paths
        self._paths = [path for path in paths if path.startswith(("obstacles.", "couplings."))]

    def forget(self) -> None:
        """Trails begin anew."""
        for live in self._live:
            live.forget()

    def draw(self) -> list[Frame]:
        """A picture of each environment, (height, width, 3) uint8."""
        bodies = [self._pool.state(f"bodies.{part}") for part in PARTS]
        state = {
            "time": self._pool.state("time"),
            "bodies": np.concatenate(bodies, axis=-1),
            "rotor_speed": self._pool.state("rotor_speed"),
        }
        episodes = self._pool.state("episode")
        return [self._draw(env, int(episodes[env]), state) for env in range(len(self._live))]

    def _draw(self, env: int, episode: int, state: Mapping[str, Array]) -> Frame:
        live, made = self._live[env], self._films[env]
        world = (episode, *(live.drawn[path] for path in self._paths))
        if made is None or made[0][0] != episode:
            live.forget()
        live.see(state)
        if made is None or made[0] != world:
            made = self._films[env] = (world, self._film(live))
        return made[1].frame(live.duration)

    def _film(self, live: Live) -> Film:
        width, height = self._size
        panel = Panel((Scene(live, STYLE),), self._camera, 0, 0, width, height)
        return Film([panel], Size(width, height))
