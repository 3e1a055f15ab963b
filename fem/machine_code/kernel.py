"""Compiled functions: called by their machine code on disk, compiled by Numba first where there is none.

Where another Numba lacks a name that this needs and Numba does not promise, a call goes through Numba itself: slower,
for Numba is imported and compiles in every process, and as right.
"""

from __future__ import annotations

import functools
import hashlib
import json
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from fem.machine_code import folder
from fem.machine_code.arguments import Call, Prepared, UnknownTypeError, codes, flattened, spelled

_FINDING = threading.RLock()

_PENDING: list[tuple[Callable[..., Any], Callable[..., Any], str]] = []
"""Arguments of `numba_code.replace_generic` that Numba has not been given yet."""

CALLABLE = {"no_cpython_wrapper": False, "inline": "never"}
"""Options by which Python can call what Numba makes."""

NAMELESS = (AttributeError, ImportError, LookupError, StopIteration, TypeError)
"""Errors by which a name shows that another Numba lacks, or has with another meaning."""


def replace_in_code(generic: Callable[..., Any], choose: Callable[..., Any], inline: str) -> None:
    """Have a generic function replaced in compiled code as soon as something is compiled: by what `choose` says of
    Numba's types of the arguments; inline: "always" or "never", merged into its caller or not."""
    _PENDING.append((generic, choose, inline))


def _numba_code() -> Any:
    """The module that compiles, with everything that it is to know."""
    from fem.machine_code import numba_code

    numba_code.know(Kernel)
    while _PENDING:
        numba_code.replace_generic(*_PENDING.pop(0))
    return numba_code


class Kernel:
    """A function that is compiled for the types that it is called with, on the first call of each.

    function: in the part of Python that Numba compiles. options: of `numba.njit`. A call raises UnknownTypeError for
    arguments and results other than numbers, arrays, None and tuples of these.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        functools.update_wrapper(self, function)
        self.py_func, self.targetoptions = function, options
        self._found: dict[tuple[Any, ...], Call] = {}

    def __reduce__(self) -> str:
        return self.py_func.__qualname__

    def __call__(self, *arguments: Any) -> Any:
        kinds, values = flattened(arguments)
        call = self._found.get(kinds) or self._find(kinds, arguments)
        return call(values) if call else self._through_numba(*_plain(arguments))

    def bound(self, *arguments: Any) -> Callable[[], Any]:
        """The call with these arguments, laid out once for many times; arrays in them must stay where they are."""
        kinds, values = flattened(arguments)
        call = self._found.get(kinds) or self._find(kinds, arguments)
        if call is None:
            return functools.partial(self._through_numba, *_plain(arguments))
        return lambda kept=arguments: call(values)  # type: ignore[misc]  # values are addresses: what is there must live

    def has_code(self, *arguments: Any) -> bool:
        """True if there is machine code for arguments of these types in this process, or on disk: it is then loaded."""
        return self._find(flattened(arguments)[0]) is not None

    def path(self, *arguments: Any) -> Path:
        """The file of the machine code for arguments of these types."""
        return self._file(flattened(arguments)[0])[0]

    @functools.cached_property
    def dispatcher(self) -> Any:
        """Numba's dispatcher of the function, for other compiled code to call."""
        return _numba_code().make_dispatcher(self.py_func, self.targetoptions)

    def _file(self, kinds: tuple[Any, ...]) -> tuple[Path, dict[str, Any]]:
        """The file of the code for these types, and all that the code depends on: the file must say the same."""
        from fem.machine_code.object_code import machine

        function = self.py_func
        identity = machine() | {
            "kernel": f"{function.__module__}.{function.__qualname__}",
            "arguments": " ".join(map(spelled, kinds)),
            "values": "".join(map(codes, kinds)),
            "sources": folder.sources() + folder.own_sources(function),
        }
        digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:20]
        return folder.cache_folder() / f"{function.__name__}-{digest}.code", identity

    @functools.cached_property
    def _through_numba(self) -> Any:
        """Callable of the function by Numba itself."""
        return _numba_code().make_dispatcher(self.py_func, {"nogil": True} | self.targetoptions | CALLABLE)

    def _find(self, kinds: tuple[Any, ...], arguments: tuple[Any, ...] | None = None) -> Call | None:
        """Callable of the machine code, compiled where arguments are given and none is kept.

        None without arguments where there is none, and where Numba lacks a name that this needs.
        """
        with _FINDING:
            try:
                if kinds not in self._found and "_through_numba" not in vars(self):
                    self._load(kinds, arguments)
            except UnknownTypeError:
                raise
            except NAMELESS:
                self._through_numba  # noqa: B018  # from now on
            return self._found.get(kinds)

    def _load(self, kinds: tuple[Any, ...], arguments: tuple[Any, ...] | None) -> None:
        from fem.machine_code import object_code

        path, identity = self._file(kinds)
        code = object_code.decoded(folder.read(path, object_code.LARGEST), identity)
        if code is None:
            if arguments is None:
                return
            code = _numba_code().compile_for(self.dispatcher, _plain(arguments))
            if code.arguments != identity["values"]:
                raise UnknownTypeError(f"{self.py_func.__name__} takes {code.arguments}")
            with suppress(OSError):  # it is as right, and `compile_once` says so
                folder.write(path, object_code.encoded(code, identity))
        if object_code.helpers_of(code):  # a law calls what only Numba has
            _numba_code().offer_helpers()
        self._found[kinds] = object_code.load_code(code)


def _plain(arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(each.value if isinstance(each, Prepared) else each for each in arguments)
