"""Functions that all pools of environments share: state, parameters, hashes, recordings."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._native import CompiledScenario
from .arguments import (
    MOST_ENVS,
    MOST_THREADS,
    check_seed,
    env_ids,
    flag,
    integer,
    integer_within,
    text,
)
from .observations import Observations
from .requests import Change, When, at_reset, request_lines

_ids = env_ids  # some methods have an argument of this name


def drain(pool: _native.Pool) -> None:
    """Receives the environments that an interrupted step left in flight."""
    while pool.in_flight > 0:
        pool.recv()


def make_native(
    compiled: CompiledScenario,
    num_envs: int,
    *,
    seed: int,
    num_threads: int,
    pin_threads: bool,
    keep_hash: bool,
    infos: bool = True,
    debug: bool = False,
    **more: Any,
) -> _native.Pool:
    """The C++ pool of a scenario. Raises TypeError and ValueError for invalid options."""
    return _native.Pool(
        compiled,
        integer_within("num_envs", num_envs, 1, MOST_ENVS),
        num_threads=integer_within("num_threads", num_threads, 0, MOST_THREADS),
        seed=check_seed(seed) or 0,
        pin_threads=flag("pin_threads", pin_threads),
        keep_hash=flag("keep_hash", keep_hash),
        info=flag("infos", infos),
        debug=flag("debug", debug),
        **more,
    )


class PooledEnvironments:
    """Saving, forking, parameters, hashes and recordings of the environments of one pool.

    `native` is the underlying `_native.Pool`, for functions that are not wrapped here.
    """

    native: _native.Pool
    _observations: Observations

    def observations(self) -> Any:
        """Last observation of every environment, in new arrays; for use after a restore or fork."""
        return self._observations.now(self.native)

    def privileged(self) -> NDArray[np.float32]:
        """Last privileged row of every environment (num_envs, privileged_size), a new array."""
        return self.native.privileged()

    def save(self) -> bytes:
        """The complete state of all environments: motion, drawn values, counters, random keys.

        Raises:
            skybody.Error: some environments are in flight.
        """
        return self.native.save()

    def restore(self, saved: bytes) -> Any:
        """Restores all environments from a `save`.

        Returns:
            their observations, as `observations` returns them.

        Raises:
            ValueError: `saved` comes from another scenario or number of environments.
            skybody.Error: some environments are in flight.
        """
        self.native.restore(saved)
        return self.observations()

    def fork(self, source: int, targets: ArrayLike, rekey: bool = False) -> None:
        """Turns environments into copies of `source`: same motion, drawn values and future.

        Args:
            rekey: each copy draws its own random numbers from then on.

        Raises:
            ValueError: an id is out of range or in flight.
        """
        self.native.fork(source, env_ids(targets), rekey)

    def state(self, path: str) -> NDArray[np.float64]:
        """A value of the state of every environment, in a new array (num_envs, *shape).

        `state_paths` lists all paths, with units, frames and shapes. Vectors are in world axes W
        (z up) or in axes B of their own body or link, quaternions w x y z, W from B; SI units. For
        a robot `quad`:

        * `robots.quad.base.position` (3,), `.rotation` (4,), `.velocity` (3,) of the origin, all in
          W, `.angular_velocity` (3,) in B; likewise `robots.quad.links.NAME.position` and so on,
          and `bodies.position` (bodies, 3) of all bodies;
        * `robots.quad.joints.NAME.position`, `.velocity`: () for one coordinate;
        * `robots.quad.rotors.speed`, `.command` (rotors,), `robots.quad.rotors[0].speed` ();
        * `sensors.NAME.CHANNEL`, as last sampled (images: `observations`);
        * `robots.quad.links.NAME.contact.force`, `.moment`, `.touching`, if a plugin of the
          scenario requests contacts;
        * `time`, `steps`, `episode`, `status`, `q`, `u`, `action`, `command`;
        * every randomizable parameter, at its current value: `robots.quad.links.NAME.mass`.

        After the end of an episode it is the state at that end until the environment is reset. With
        autoreset "same_step" it is the first state of the new episode.

        Raises:
            ValueError: no such path (the nearest ones are named), or no episode has begun.
            skybody.Error: some environments are in flight: `recv` them first.
        """
        return self.native.state(text("path", path))

    def state_paths(self) -> dict[str, _native.StateValue]:
        """All paths of `state`: path -> unit, frame, shape and meaning."""
        return self.native.compiled.state_values

    def param(self, env: int, path: str) -> float:
        """Value of a randomizable parameter (`compiled.param_paths`) in one environment."""
        return self.native.param(integer("env", env), text("path", path))

    def set_param(self, env: int, path: str, value: float) -> None:
        """Sets a randomizable parameter, in the unit of `compiled.param_info(path)`.

        Raises:
            ValueError: an unknown path, or a value out of its bounds.
            skybody.Error: some environments are in flight.
        """
        self.native.set_param(integer("env", env), text("path", path), value)

    def request(
        self,
        env_ids: ArrayLike | None,
        changes: Mapping[str, Change],
        when: When = "next_step",
    ) -> None:
        """Requests values of randomizable parameters; environments may be in flight.

        A request is applied with the next action that is sent to an environment after this call:

        * before the first physics step of that transition; or
        * if the transition is a reset, after the draws of the randomizers.

        Requests are applied in the order of the calls; each environment draws its own values. The
        same seed and the same order of calls give the same bits.

        Args:
            env_ids: (n,) int32, the environments; None: all.
            changes: path (as in randomizers, `[*]` and `*` included) -> a number, several
                for a vector, or a draw such as
                `{"distribution": "uniform", "range": [0.8, 1.2], "form": "scale"}`: see
                `skybody.requests.Draw`. Units: `compiled.param_info(path)`.
            when: "next_step", or "next_reset": the next episode that begins.

        Raises:
            ValueError: no such environment or parameter, a vector of another length, an invalid
                distribution, or a value that would be out of its bounds.
            TypeError: a value that is not a number, a list of numbers or a draw. In both cases
                nothing is requested.
        """
        ids = None if env_ids is None else _ids(env_ids)
        lines = request_lines(self.native.compiled, changes)
        self.native.request(lines, False, at_reset(when), ids)

    def randomize(self, env_ids: ArrayLike | None = None, when: When = "next_step") -> None:
        """Requests draws of all randomizers, whatever their schedule. Motion continues.

        See `request`.
        """
        self.native.request([], True, at_reset(when), None if env_ids is None else _ids(env_ids))

    def hash(self, env: int | None = None) -> int:
        """Trajectory hash of one environment, or of all. Requires keep_hash=True."""
        return self.native.hash() if env is None else self.native.hash(env)

    def record(self, path: str | os.PathLike[str], states: bool = False) -> None:
        """Records all transitions from now on to an HDF5 file, for `skybody replay`.

        `stop_recording` or `close` finishes it; until then it is complete up to the last write of
        about 4 MiB. Trajectory hashes are kept during the recording, also without keep_hash.

        Args:
            path: the file; an existing one is replaced.
            states: also records all state words of every transition (8 bytes each), so that a
                diverging replay can name those that differ.

        Raises:
            skybody.Error: some environments are in flight, a recording is running already, or the
                file cannot be written. If writing fails later (no space), the call that steps or
                resets raises it, and the recording ends.
        """
        if self.native.in_flight > 0:
            raise _native.Error(
                f"record() while {self.native.in_flight} environments are in flight: recv() them "
                "first"
            )
        self.native.record(os.fspath(path), states)

    def stop_recording(self) -> None:
        """Finishes the file of `record`; it does not contain transitions in flight.

        Raises:
            skybody.Error: no recording is running, or the file cannot be finished.
        """
        self.native.stop_recording()

    @property
    def clipped(self) -> int:
        """Number of action values sent so far outside [-1, 1], which were clipped; 0 is normal."""
        return self.native.clipped

    @property
    def faults(self) -> int:
        """Number of faulted transitions received so far, in all environments."""
        return self.native.faults
