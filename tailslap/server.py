"""Serve the page of `tailslap explore` to the present user.

The secret is the first part of every path, as cookies of 127.0.0.1 are sent to all of its ports.
"""

import atexit
import contextlib
import os
import secrets
import socket
import tempfile
import webbrowser
from collections.abc import Awaitable, Callable, Iterator, MutableMapping
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import quote

from tailslap.errors import InputError

HOST = "127.0.0.1"
PAGE = Path(__file__).with_name("explore.py")
REDIRECT = '<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0; url={}">'
"""File that the browser opens: a secret among its arguments would be visible to all users."""

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Scope]]
Send = Callable[[Scope], Awaitable[None]]
"""Types of ASGI: the request, and the functions that receive and send its messages."""

FORBIDDEN, FOREIGN = 403, 1008
"""Status of a refused request, and code of a refused websocket."""


def serve(scene: str, port: int, headless: bool) -> NoReturn:
    """Serve the page until an interrupt, which ends the process.

    Raises InputError for a port that is in use.
    """
    import marimo
    import uvicorn

    with socket.socket() as listener:
        _listen(listener, port)
        secret = secrets.token_urlsafe(32)
        app = marimo.create_asgi_app(quiet=True).with_app(path=f"/{secret}", root=str(PAGE)).build()
        guard = Guard(app, port, secret)
        address = f"{guard.origin}/{secret}/?scene={quote(scene)}"
        print(f"tailslap explore: {address} (Ctrl-C ends it)", flush=True)
        settings = uvicorn.Config(guard, log_level="error", lifespan="off", timeout_graceful_shutdown=1)
        with contextlib.suppress(KeyboardInterrupt), _shown(address, headless):
            uvicorn.Server(settings).run([listener])
    # Kernels are threads, also those of closed tabs, and may be within a run. SciPy's factors belong to the thread that
    # made them: the interpreter's own end would wait for the threads, or print an error while it frees the factors.
    atexit._run_exitfuncs()
    os._exit(0)


def _listen(listener: socket.socket, port: int) -> None:
    """Take the port before the address is printed.

    No other process can then answer there.
    """
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HOST, port))
        listener.listen()
    except OSError as error:
        raise InputError("--port", port, f"{error.strerror}; choose another port") from None


@contextlib.contextmanager
def _shown(address: str, headless: bool) -> Iterator[None]:
    """Open the address in the browser.

    It is in a private file, which is removed at the end of the block.
    """
    with tempfile.TemporaryDirectory(prefix="tailslap-") as folder:
        if not headless:
            webbrowser.open(redirecting_file(Path(folder), address).as_uri())
        yield


def redirecting_file(folder: Path, address: str) -> Path:
    """Write the file that leads a browser to an address.

    It is readable by this user alone.
    """
    path = folder / "explore.html"
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
        file.write(REDIRECT.format(address))
    return path


class Guard:
    """ASGI application for requests of one page.

    Others are refused. A request under another name of the host comes from another site whose name leads here; one with
    another origin from a page of another site.
    """

    def __init__(
        self, app: Callable[[Scope, Receive, Send], Awaitable[None]], port: int, secret: str
    ) -> None:
        self.app, self.secret = app, secret.encode()
        self.host = f"{HOST}:{port}"
        self.origin = f"http://{self.host}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request or a websocket."""
        if self._admits(scope):
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": FOREIGN})
        else:
            headers = [(b"content-type", b"text/plain")]
            await send({"type": "http.response.start", "status": FORBIDDEN, "headers": headers})
            await send(
                {"type": "http.response.body", "body": b"Open the address that tailslap explore has printed."}
            )

    def _admits(self, scope: Scope) -> bool:
        """Return True for host, origin and secret of the page.

        A request need not have an origin.
        """
        hosts, origins = (
            [value for key, value in scope["headers"] if key == name] for name in (b"host", b"origin")
        )
        secret = scope["path"].encode().split(b"/")[1:2]
        return (
            hosts == [self.host.encode()]
            and set(origins) <= {self.origin.encode()}
            and secrets.compare_digest(b"".join(secret), self.secret)
        )
