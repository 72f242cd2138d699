"""Sockets on loopback, whose waits end at Ctrl-C."""

from __future__ import annotations

import errno
import socket

HOST = "127.0.0.1"
WAIT = 0.2  # longest wait without a look at the clock [s]


def bound(
    kind: socket.SocketKind, port: int, remedy: str = "or choose another port by --port"
) -> socket.socket:
    """A socket at a port of this machine that nobody else reaches.

    Args:
        kind: SOCK_DGRAM or SOCK_STREAM; the latter listens.
        port: 0: any that is free.
        remedy: another one than ending the program that has the port.

    Raises:
        ValueError: the port is in use or not allowed.
    """
    made = socket.socket(socket.AF_INET, kind)
    try:
        if kind == socket.SOCK_STREAM:
            made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind((HOST, port))
        if kind == socket.SOCK_STREAM:
            made.listen(1)
    except OSError as error:
        made.close()
        name = "TCP" if kind == socket.SOCK_STREAM else "UDP"
        if error.errno == errno.EADDRINUSE:
            raise ValueError(
                f"{name} port {port} of {HOST} is in use; end the other program {remedy}"
            ) from None
        raise ValueError(f"{name} port {port} of {HOST}: {error.strerror}") from None
    made.settimeout(WAIT)
    return made
