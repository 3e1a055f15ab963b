"""A compiled function: called by its machine code on disk, or compiled by Numba first."""

from __future__ import annotations

import functools
import hashlib
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fem.machine_code import folder
from fem.machine_code.arguments import Prepared, UnknownTypeError, codes_of, flattened, spelled
from fem.machine_code.pending import Function

_FINDING = threading.RLock()


class Kernel(Function):
    """A function that is compiled for the types that it is called with, on the first call of each.

    function: in the part of Python that Numba compiles. options: of `numba.njit`. A call raises UnknownTypeError for
    arguments and results other than numbers, arrays, None and tuples of these.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        functools.update_wrapper(self, function)
        self.py_func, self.targetoptions = function, options
        self._found: dict[tuple[Any, ...], Callable[[list[Any]], Any]] = {}

    def __reduce__(self) -> str:
        return self.py_func.__qualname__

    def __call__(self, *arguments: Any) -> Any:
        kinds, values = flattened(arguments)
        call = self._found.get(kinds) or self._find(kinds, arguments)
        return call(values)

    def bound(self, *arguments: Any) -> Callable[[], Any]:
        """The call with these arguments, laid out once for many times; arrays in them must stay where they are."""
        kinds, values = flattened(arguments)
        call = self._found.get(kinds) or self._find(kinds, arguments)
        return lambda kept=arguments: call(values)  # type: ignore[misc]  # values are addresses: what is there must live

    def has_code(self, *arguments: Any) -> bool:
        """Whether this process has machine code for arguments of these types."""
        return flattened(arguments)[0] in self._found

    def path(self, *arguments: Any) -> Path:
        """The file of the machine code for arguments of these types."""
        return self._path(flattened(arguments)[0])

    @functools.cached_property
    def dispatcher(self) -> Any:
        """What Numba makes of the function."""
        from fem.machine_code.numba_code import make_dispatcher

        return make_dispatcher(self)

    def _path(self, kinds: tuple[Any, ...]) -> Path:
        from fem.machine_code.object_code import machine

        what = "|".join([self.py_func.__module__, self.py_func.__qualname__, spelled(kinds), machine()])
        digest = hashlib.sha256(what.encode()).hexdigest()[:20]
        return folder.cache_folder() / f"{self.py_func.__name__}-{digest}.code"

    def _find(self, kinds: tuple[Any, ...], arguments: tuple[Any, ...]) -> Callable[[list[Any]], Any]:
        from fem.machine_code.object_code import load_code, read_code, write_code

        with _FINDING:
            path = self._path(kinds)
            code = read_code(path)
            if code is None:
                from fem.machine_code.numba_code import compile_for

                plain = (each.value if isinstance(each, Prepared) else each for each in arguments)
                code = compile_for(self.dispatcher, tuple(plain))
                if code.arguments != codes_of(kinds):
                    raise UnknownTypeError(f"{self.py_func.__name__} takes {code.arguments}")
                write_code(path, code)
            return self._found.setdefault(kinds, load_code(code))
