"""A gmsh session that prints nothing, works in any thread and is always closed."""

from __future__ import annotations

import ctypes
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

# gmsh keeps one global state a process, so two threads must not be in it at once.
_LOCK = threading.Lock()


def _restore_handlers() -> None:
    """Set Python's signal handlers again: libraries within gmsh leave the default ones behind."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
        handler = signal.getsignal(number)
        if (
            handler == signal.SIG_IGN
        ):  # in any thread; a write to what has been closed is to raise, not to kill
            ctypes.CDLL(None).signal(int(number), ctypes.c_void_p(1))
        elif callable(handler) and threading.current_thread() is threading.main_thread():
            signal.signal(number, handler)


@contextmanager
def gmsh_model(name: str) -> Iterator[Any]:
    """Yield the gmsh module with an empty model of this name, and close what was opened, also after an error.

    A session that the calling program has open already is used and left open; only our model is removed.
    """
    import gmsh

    with _LOCK:
        ours = not gmsh.isInitialized()
        if ours:
            gmsh.initialize(readConfigFiles=False, interruptible=False)
            _restore_handlers()
        terminal = gmsh.option.getNumber("General.Terminal")
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(name)
        try:
            yield gmsh
        finally:
            if ours:
                gmsh.finalize()
                _restore_handlers()
            else:
                gmsh.model.remove()
                gmsh.option.setNumber("General.Terminal", terminal)
