"""The one decorator by which everything in this package is compiled.

Machine code is kept on disk, in a folder named after a digest of this package's sources: Numba itself only
looks at the file of the function that it loads, and would go on using a loop whose inlined callee has changed.
"""

from __future__ import annotations

import fcntl
import functools
import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
import numba.extending
import platformdirs

FAST_MATH = {"contract", "nsz", "reassoc"}
"""Fused multiply-add and regrouping are allowed; NaN and infinity keep their meaning, the checks need them."""


def inlined(function: Callable[..., Any]) -> Any:
    """A part of a compiled loop that must be merged into it: only then are its lanes packed."""
    return numba.njit(fastmath=FAST_MATH, error_model="numpy", inline="always")(function)


def compiled(function: Callable[..., Any]) -> Any:
    """Compile on first call for the types it meets, and keep the result on disk.

    The compiled code lets other Python threads run.
    """
    # The cache folder is read when a function is decorated; other users of Numba keep theirs.
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        return numba.njit(cache=True, nogil=True, fastmath=FAST_MATH, error_model="numpy")(function)
    finally:
        numba.config.CACHE_DIR = before


def has_code(function: Any, *arguments: Any) -> bool:
    """Whether this process has machine code of a compiled function for arguments of these types."""
    return tuple(map(numba.typeof, arguments)) in function.overloads


@contextmanager
def one_process_compiles() -> Iterator[None]:
    """Make other processes wait that are here as well: they then load what this one has compiled.

    Where the folder of the compiled code cannot be written, each compiles for itself.
    """
    try:
        cache_folder().mkdir(parents=True, exist_ok=True)
        lock = open(cache_folder() / "lock", "a")  # noqa: SIM115
    except OSError:
        yield
        return
    with lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def implements(generic: Callable[..., Any], *kinds: type, inline: str = "never") -> Callable[..., Any]:
    """Decorator: what `generic` is, in compiled code, for a first argument that is one of these NamedTuples, or None.

    The choice is made by type when a loop is compiled; the function's other arguments are as the generic's.
    """

    def register(implementation: Callable[..., Any]) -> Callable[..., Any]:
        def choose(first: Any, *rest: Any) -> Any:
            kind = getattr(
                first, "instance_class", type(None) if isinstance(first, numba.types.NoneType) else None
            )
            return implementation if kind in kinds else None

        numba.extending.overload(generic, strict=False, inline=inline)(choose)
        return implementation

    return register


@functools.cache
def cache_folder() -> Path:
    """Folder of the compiled code: under $NUMBA_CACHE_DIR, else under the user's cache folder."""
    digest = hashlib.sha256()
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(source.read_bytes())
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_path("tailslap", appauthor=False)
    return Path(base) / digest.hexdigest()[:16]
