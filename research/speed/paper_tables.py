"""The throughput tables of the GzDRL paper (Tables III and IV), as printed there.

Rates are thousands of environment steps per second; a world counts once for any number of robots.
Processor use is in percent of all processors.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Computer:
    """One of the paper's two computers; cores according to the processor's maker."""

    name: str
    processor: str
    cores: int


@dataclass(frozen=True)
class Peak:
    """The best mean rate over the paper's numbers of environments, with its 95 % interval."""

    rate: float
    interval: float
    envs: int
    cpu: float


@dataclass(frozen=True)
class Architecture:
    """A row of Table III."""

    name: str
    workstation: Peak
    laptop: Peak


@dataclass(frozen=True)
class Throughput:
    """A row of Table IV: a rate for each number of robots in ROBOTS."""

    computer: str
    name: str
    rates: tuple[float, ...]


WORKSTATION = Computer("workstation", "AMD Ryzen Threadripper 3960X", 24)
LAPTOP = Computer("laptop", "AMD Ryzen 9 7940HS", 8)

COUNTS = (1, 4, 8, 16, 32, 64, 128)  # of environments, in Table III and figure 7
ROBOTS = (2, 5, 10, 20)  # in a world, in Table IV and figure 8
ENVS = 32  # of Table IV

GAZEBO_POOL = Architecture(
    "GzDRL (GazeboPool)", Peak(78.58, 2.08, 128, 78.1), Peak(43.38, 0.56, 32, 82.7)
)
ASYNC_POOL = Architecture(
    "GzDRL (AsyncDRLServerPool)", Peak(19.10, 1.79, 32, 20.6), Peak(24.59, 1.37, 32, 45.8)
)
MULTIPROCESSING = Architecture(
    "GzDRL (Multiprocessing)", Peak(23.80, 0.42, 64, 54.5), Peak(13.64, 0.66, 16, 61.9)
)
THREADING = Architecture("GzDRL (Threading)", Peak(3.03, 0.03, 1, 3.0), Peak(6.24, 0.13, 8, 15.4))
SERIAL = Architecture("GzDRL (Serial)", Peak(3.63, 0.06, 1, 3.0), Peak(5.08, 0.12, 1, 7.0))
OTHERS = (
    Architecture("OmniDrones", Peak(21.15, 0.22, 128, 30.7), Peak(35.47, 0.20, 128, 9.6)),
    Architecture("Aerial Gym", Peak(21.02, 0.27, 128, 3.7), Peak(44.56, 0.42, 128, 9.0)),
    Architecture("PyBullet-Drones", Peak(21.95, 1.25, 16, 16.3), Peak(26.92, 1.30, 16, 49.0)),
    Architecture("ROS 2 Multiprocessing", Peak(2.59, 0.18, 4, 25.6), Peak(7.22, 4.01, 8, 68.4)),
    Architecture("ROS 2 Serial", Peak(2.16, 1.05, 1, 9.6), Peak(9.06, 0.81, 1, 13.9)),
)

TABLE_4 = (
    Throughput("workstation", "GzDRL (GazeboPool)", (35.52, 17.82, 8.10, 3.18)),
    Throughput("workstation", "OmniDrones", (4.24, 4.19, 4.15, 4.10)),
    Throughput("workstation", "Aerial Gym", (7.15, 7.07, 6.62, 5.53)),
    Throughput("workstation", "PyBullet-Drones", (13.89, 10.23, 6.65, 2.69)),
    Throughput("laptop", "GzDRL (GazeboPool)", (32.95, 11.54, 5.01, 2.16)),
    Throughput("laptop", "OmniDrones", (7.11, 6.94, 6.89, 6.77)),
    Throughput("laptop", "Aerial Gym", (15.24, 14.88, 14.04, 11.44)),
    Throughput("laptop", "PyBullet-Drones", (13.31, 9.07, 5.09, 2.11)),
)
GAZEBO_POOL_WORKSTATION = TABLE_4[0]
GAZEBO_POOL_LAPTOP = TABLE_4[4]


def machines_line() -> str:
    """The source of the paper's figures."""
    return " and ".join(
        f"a {c.name} with {c.cores} cores ({c.processor})" for c in (WORKSTATION, LAPTOP)
    )
