"""The connection to a Ray cluster. Each problem with it is one message."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import secrets
import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import skybody
from skybody.extras import install_command
from skybody.train.hyperparameters import UsageError

LOCAL = "local"
ADDRESSES = (
    "HOST:PORT of its head, `auto` for this machine's cluster, or `local` for a cluster "
    "that ends with this command"
)
ADDRESS_HELP = f"address of the cluster: {ADDRESSES}; default: {LOCAL}"
REMEDY = install_command(["ray"])
PACKAGES = Path(skybody.__file__).parents[1]  # the folder from which this package was imported
ANSWER_SECONDS = 5.0  # limit for a head to accept a connection


class ClusterError(UsageError):
    """Ray is missing, there is no cluster, or it is too small; the text is the whole message."""


@contextlib.contextmanager
def cluster(address: str, cpus: int | None = None, option: str = "--address") -> Iterator[Any]:
    """Connects to a cluster for a scope; returns the module `ray`.

    An existing connection of the process is used, and stays open.

    Args:
        address: "local", "auto" or HOST:PORT.
        cpus: number of processors of a local cluster; None: all of this machine.
        option: the command-line option of the address, for messages.

    Raises:
        ClusterError: Ray is not installed, or there is no cluster at the address.
    """
    # Without a cluster at the address, Ray's own log would print a line each second while it tries.
    os.environ.setdefault("RAY_BACKEND_LOG_LEVEL", "error")
    is_connected = "ray" in sys.modules and sys.modules["ray"].is_initialized()
    if address == LOCAL and not is_connected:
        _demand_token()
    ray = import_ray()
    _check_answers(address, option)
    if is_connected:
        yield ray
        return
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    # Without an address Ray would join any cluster on this machine, even another user's.
    options: dict[str, Any] = {"address": address}
    if address == LOCAL:
        options |= {"include_dashboard": False, "num_cpus": cpus}
    try:
        # Ray workers import from the working folder of this call, which may contain another user's
        # files. Use a folder from which they import anyway.
        with contextlib.chdir(PACKAGES):
            ray.init(logging_level="ERROR", log_to_driver=False, **options)
    except (ConnectionError, RuntimeError, ValueError) as error:
        raise ClusterError(_no_cluster(option, address, _first_sentence(error))) from error
    try:
        yield ray
    finally:
        ray.shutdown()


def _demand_token() -> None:
    """Requires a token for a local cluster, because all users of the machine can reach its ports.

    Without a token in the environment Ray would write one to the home folder, for all clusters.
    """
    os.environ.setdefault("RAY_AUTH_MODE", "token")
    if not any(name in os.environ for name in ("RAY_AUTH_TOKEN", "RAY_AUTH_TOKEN_PATH")):
        os.environ["RAY_AUTH_TOKEN"] = secrets.token_hex(32)
    if "ray" in sys.modules:  # it read the environment when it was imported
        from ray._raylet import AuthenticationTokenLoader, Config

        Config.initialize("")
        AuthenticationTokenLoader.instance().reset_cache()


def import_ray() -> Any:
    """The module `ray`. Raises ClusterError if it is not installed."""
    if importlib.util.find_spec("ray") is None:
        raise ClusterError(f"needs the package `ray`, not installed here: {REMEDY}")
    import ray

    return ray


def check_cpus(ray: Any, wanted: float, what: str) -> None:
    """Raises ClusterError if the whole cluster has fewer than `wanted` processors."""
    found = ray.cluster_resources().get("CPU", 0.0)
    if found < wanted:
        raise ClusterError(
            f"{what}: the cluster has {found:g} processors; take fewer, or add machines "
            "(`ray start --address=HEAD:PORT`)"
        )


def _check_answers(address: str, option: str) -> None:
    """Raises ClusterError if no head answers. Ray would try for two minutes and end the process."""
    if address in (LOCAL, "auto"):
        return
    host, colon, port = address.rpartition(":")
    if not colon or not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise ClusterError(f"{option} {address}: write HOST:PORT, `auto` or `local`")
    try:
        with socket.create_connection((host, int(port)), ANSWER_SECONDS) as connection:
            is_head = os.environ.get("RAY_USE_TLS", "0") != "0" or _speaks_http2(connection)
    except OSError as error:
        raise ClusterError(_no_cluster(option, address, error.strerror or str(error))) from error
    if not is_head:
        reason = "something else answers; a head's own port is 6379 where nobody chose another"
        raise ClusterError(_no_cluster(option, address, reason))


def _speaks_http2(connection: socket.socket) -> bool:
    """Whether the peer answers with a settings frame (RFC 9113, sections 3.4 and 4.1), as a head
    does.

    With another server at the port (a dashboard, a client server), Ray would wait forever.
    """
    settings = 4
    connection.settimeout(ANSWER_SECONDS)
    connection.sendall(
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, settings, 0, 0, 0, 0, 0])
    )
    try:
        answer = connection.recv(9)
    except TimeoutError:
        return False
    return len(answer) >= 4 and answer[3] == settings


def _first_sentence(error: Exception) -> str:
    return str(error).splitlines()[0].partition(". ")[0]


def _no_cluster(option: str, address: str, reason: str) -> str:
    return (
        f"{option} {address}: no Ray cluster there ({reason}); `ray start --head` starts one, "
        f"`{option} local` needs none"
    )
