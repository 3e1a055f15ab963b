"""The one decorator by which everything in this package is compiled, and how laws get into compiled code.

Machine code is kept on disk, in a folder named after a digest of this package's sources and of those of laws from
outside it: Numba itself only looks at the file of the function that it loads, and would go on using a loop whose
inlined callee has changed.
"""

from __future__ import annotations

import fcntl
import functools
import hashlib
import os
import pickle
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import platformdirs

from fem.registry import PACKAGE, LawRegistry, outside_sources, watch
from fem.unseen import unseen

with unseen(
    "coverage", "cffi"
):  # Numba loads them where it finds them, which takes longer than much of itself
    import numba
    import numba.core.typing.cffi_utils
    import numba.extending
    from numba.core.caching import FunctionCache

FAST_MATH = {"contract", "nsz", "reassoc"}
"""Fused multiply-add and regrouping are allowed; NaN and infinity keep their meaning, the checks need them."""

USUAL_S, TIME_FILE = 10.0, "seconds"
"""Seconds that a loop takes to be compiled where no other tells; the file that keeps what the last one took, of
whatever version."""

Told = Callable[[float, bool], None]
"""Told seconds, and whether they are over."""

_dispatchers: list[Any] = []


def inlined(function: Callable[..., Any]) -> Any:
    """A part of a compiled loop that must be merged into it: only then are its SIMD blocks vectorised."""
    return numba.njit(fastmath=FAST_MATH, error_model="numpy", inline="always")(function)


def compiled(function: Callable[..., Any]) -> Any:
    """Compile on first call for the types it meets, and keep the result on disk.

    The compiled code lets other Python threads run.
    """
    dispatcher = numba.njit(nogil=True, fastmath=FAST_MATH, error_model="numpy")(function)
    _dispatchers.append(dispatcher)
    _keep_in(cache_folder(), dispatcher)
    return dispatcher


class _DispensableCache(FunctionCache):
    """Machine code on disk; where it cannot be written or read, as on a full disk, it is compiled anew."""

    @contextmanager
    def _guard_against_spurious_io_errors(self) -> Iterator[None]:
        with suppress(OSError, EOFError, pickle.UnpicklingError):
            yield


def _keep_in(folder: Path, *dispatchers: Any) -> None:
    """Keep the machine code of these functions in this folder."""
    # Numba reads the setting at this moment; other users of Numba keep theirs.
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)
    try:
        for dispatcher in dispatchers:
            with suppress(RuntimeError):  # Numba's, where no folder can be written
                dispatcher._cache = _DispensableCache(dispatcher.py_func)
    finally:
        numba.config.CACHE_DIR = before


def _follow_laws() -> None:
    """Laws have changed: code that knows of them belongs into another folder."""
    cache_folder.cache_clear()
    _keep_in(cache_folder(), *_dispatchers)


watch(_follow_laws)


def has_code(function: Any, *arguments: Any) -> bool:
    """Whether this process has machine code of a compiled function for arguments of these types."""
    return tuple(map(numba.typeof, arguments)) in function.overloads


def is_on_disk(function: Any, *arguments: Any) -> bool:
    """Whether machine code of a compiled function for arguments of these types is kept on disk."""
    try:
        key = function._cache._index_key(tuple(map(numba.typeof, arguments)), function.targetctx.codegen())
        return key in function._cache._cache_file._load_index()
    except (OSError, AttributeError, EOFError, pickle.UnpicklingError):  # no folder, or none that can be read
        return False


def compile_once(compile_all: Callable[[], None], function: Any, *arguments: Any, told: Told) -> None:
    """Compile, or load from disk, what a run needs: one process of the machine at a time.

    function, arguments: by whose machine code it is known whether that was done before. told: if it has to be
    compiled, told about how long that takes [s], and when it is done, how long it took.
    """
    if has_code(function, *arguments):
        return compile_all()
    with one_process_compiles():
        if is_on_disk(function, *arguments):
            return compile_all()
        told(expected_time(), False)
        began = time.perf_counter()
        compile_all()
        spent = time.perf_counter() - began
        told(spent, True)
        with suppress(OSError):
            (cache_folder().parent / TIME_FILE).write_text(f"{spent:.2f}")


def expected_time() -> float:
    """Seconds that a loop takes to be compiled: those that the last one took on this machine."""
    try:
        return float((cache_folder().parent / TIME_FILE).read_text())
    except (OSError, ValueError):
        return USUAL_S


def silent(seconds: float, done: bool) -> None:
    """Tell nobody."""


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


def by_law(laws: LawRegistry[Any], kernel: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Decorator: what `generic` is, in compiled code, for a first argument that holds the constants of a law.

    It is the law's field `kernel`, chosen by type when a loop is compiled; arguments are as the generic's.
    """

    def chooser(merged: bool) -> Callable[..., Any]:
        def choose(first: Any, *rest: Any) -> Any:
            law = laws.by_type(_kind(first))
            if law is None or (kernel in law.inlined) != merged:
                return None
            for helper in law.helpers:
                _callable(helper)
            return getattr(law, kernel)

        return choose

    def register(generic: Callable[..., Any]) -> Callable[..., Any]:
        for merged, inline in ((True, "always"), (False, "never")):
            numba.extending.overload(generic, strict=False, inline=inline)(chooser(merged))
        return generic

    return register


def implements(generic: Callable[..., Any], *kinds: type, merged: bool = False) -> Callable[..., Any]:
    """Decorator: what `generic` is, in compiled code, for a first argument that is one of these NamedTuples, or None.

    For parts of the loop itself; laws, which a scene names, are found by `by_law`. merged: put into the caller.
    """

    def register(implementation: Callable[..., Any]) -> Callable[..., Any]:
        def choose(first: Any, *rest: Any) -> Any:
            return implementation if _kind(first) in kinds else None

        inline = "always" if merged else "never"
        numba.extending.overload(generic, strict=False, inline=inline)(choose)
        return implementation

    return register


@functools.cache
def _callable(helper: Callable[..., Any]) -> None:
    """Let compiled code call this plain function."""
    numba.extending.register_jitable(helper)


def _kind(first: Any) -> type | None:
    """The Python type behind Numba's type of a NamedTuple or None; None for any other."""
    none = type(None) if isinstance(first, numba.types.NoneType) else None
    return getattr(first, "instance_class", none)


@functools.cache
def cache_folder() -> Path:
    """Folder of the compiled code: under $NUMBA_CACHE_DIR, else under the user's cache folder."""
    digest = _own_digest().copy()
    for source in outside_sources():
        digest.update(source)
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_path("tailslap", appauthor=False)
    return Path(base) / digest.hexdigest()[:16]


@functools.cache
def _own_digest() -> Any:
    digest = hashlib.sha256()
    for source in sorted(PACKAGE.rglob("*.py")):
        digest.update(source.read_bytes())
    return digest
