"""A plain attitude loop: force in world axes to rotor speeds, by nominal constants."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from research.transfer.quadrotor import Quadrotor

Reals = NDArray[np.float64]
STIFFNESS = np.array([160.0, 160.0, 20.0])  # [1/s^2]
RATE_GAIN = np.array([20.0, 20.0, 8.0])  # [1/s]
DAMPING = np.array([20.0, 20.0, 6.0])  # [1/s]


def rotor_speeds(quad: Quadrotor, force: Reals, attitude: Reals, rates: Reals) -> Reals:
    """PD on the matrices' difference (Lee, Leok, McClamroch, CDC 2010), heading zero.

    Args:
        force: of all rotors, W (N, 3) [N].
        attitude: W from B (N, 3, 3).
        rates: B (N, 3) [rad/s].

    Returns:
        Commands (N, 4) [rad/s].
    """
    z = force / np.maximum(np.linalg.norm(force, axis=1, keepdims=True), 1e-6)
    y = np.cross(z, [1.0, 0.0, 0.0])
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    wanted = np.stack([np.cross(y, z), y, z], 2)
    twist = np.swapaxes(wanted, 1, 2) @ attitude
    twist = 0.5 * (twist - np.swapaxes(twist, 1, 2))
    error = np.stack([twist[:, 2, 1], twist[:, 0, 2], twist[:, 1, 0]], 1)
    thrust = np.maximum((force * attitude[:, :, 2]).sum(axis=1), 0.0)
    spin = np.cross(rates, quad.inertia * rates)
    torque = quad.inertia * (-STIFFNESS * error - DAMPING * rates) + spin
    return allocated(quad, thrust, torque)


def by_rates(quad: Quadrotor, thrust: Reals, wanted: Reals, rates: Reals) -> Reals:
    """Commands (N, 4) [rad/s] for thrusts (N) [N] and body rates (N, 3) [rad/s]."""
    spin = np.cross(rates, quad.inertia * rates)
    return allocated(quad, thrust, quad.inertia * RATE_GAIN * (wanted - rates) + spin)


def allocated(quad: Quadrotor, thrust: Reals, torque: Reals) -> Reals:
    """Rotor speeds (N, 4) [rad/s]; without room, thrust moves for roll and pitch, yaw gives way."""
    inverse, most = np.linalg.inv(quad.mixer).T, quad.max_speed**2
    tilting = torque[:, :2] @ inverse[1:3]
    spread = np.ptp(tilting, axis=1, keepdims=True)
    tilting *= np.minimum(1.0, most / np.maximum(spread, 1e-9))
    low, high = -tilting.min(axis=1), most - tilting.max(axis=1)
    lifting = np.clip(thrust * inverse[0, 0], low, high)[:, None] + tilting
    turning = torque[:, 2:] * inverse[3]
    room = np.where(turning > 0.0, most - lifting, lifting) / np.maximum(np.abs(turning), 1e-9)
    share = np.clip(room.min(axis=1, keepdims=True), 0.0, 1.0)
    return np.asarray(np.sqrt(np.clip(lifting + share * turning, 0.0, most)))
