"""A page with a running simulation, served to this machine alone."""

from __future__ import annotations

import json
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from skybody import InputError

from .live import Live
from .page import filled, live_content

HOST = "127.0.0.1"
MOST_BYTES = 4096  # of a change


class Server(ThreadingHTTPServer):
    """Serves the page, its states as events, and takes changes.

    server_close() waits for the requests' threads, so that none of them holds the simulation when
    the process ends; live.close() comes before.
    """

    daemon_threads = False

    def __init__(self, live: Live, port: int) -> None:
        """Begins to listen; requests wait for serve_forever().

        Args:
            live: not started yet: the page has its present parameters.
            port: 0: any that is free.

        Raises:
            InputError: the port is in use.
        """
        self.live = live
        self.page = filled(live.compiled.name, *live_content(live)).encode()
        try:
            super().__init__((HOST, port), Handler)
        except OSError as error:
            raise InputError(
                f"--port {port}: {error.strerror}; take another one, or 0 for any that is free"
            ) from None

    @property
    def address(self) -> str:
        """For a browser on this machine."""
        return f"http://{HOST}:{self.server_port}/"


class Handler(BaseHTTPRequestHandler):
    """One request. Only pages of this server may make it, not those of other sites."""

    server: Server
    timeout = 2.0  # of a browser that neither asks nor reads [s]

    def do_GET(self) -> None:
        """The page, or its states until the browser leaves."""
        if not self._is_ours():
            return
        if self.path == "/":
            self._reply(HTTPStatus.OK, "text/html; charset=utf-8", self.server.page)
        elif self.path == "/states":
            self._stream()
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """A change."""
        if not self._is_ours():
            return
        size = self.headers.get("Content-Length", "")
        if self.path != "/change" or not size.isdecimal() or int(size) > MOST_BYTES:
            self.send_error(HTTPStatus.BAD_REQUEST)
            return
        try:
            wish = json.loads(self.rfile.read(int(size)))
            if not isinstance(wish, dict):
                raise ValueError("a change is a map")
            self.server.live.change(wish)
        except (ValueError, TypeError, RecursionError) as error:
            self._reply(HTTPStatus.BAD_REQUEST, "text/plain; charset=utf-8", str(error).encode())
            return
        self._reply(HTTPStatus.OK, "text/plain", b"")

    def log_message(self, *_: Any) -> None:
        """Prints nothing: thirty requests a second would."""

    def _is_ours(self) -> bool:
        """Refuses names that point here from elsewhere, and pages of other sites."""
        ours = f"{HOST}:{self.server.server_port}"
        origin = self.headers.get("Origin", f"http://{ours}")
        if self.headers.get("Host") == ours and origin == f"http://{ours}":
            return True
        self.send_error(HTTPStatus.FORBIDDEN)
        return False

    def _reply(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("X-Frame-Options", "DENY")  # no other site may show the page in its own
        self.end_headers()
        self.wfile.write(body)

    def _stream(self) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        try:
            for state in self.server.live.states():
                self.wfile.write(f"data: {json.dumps(state, allow_nan=False)}\n\n".encode())
                self.wfile.flush()
        except (ConnectionError, TimeoutError):
            return  # the browser has left
