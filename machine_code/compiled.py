"""Compiled functions, with the decorators that make them and their call.

A call uses machine code on disk. Where there is none, Numba compiles first. Where another version of Numba does not
have a name that this needs and Numba does not guarantee, a call goes through Numba itself. It is slower, because
Numba is imported and compiles in every process, and has the same results.
"""

import functools
import hashlib
import json
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

from machine_code import folder, object_code
from machine_code.object_code import (
    Call,
    Kinds,
    Prepared,
    UnknownTypeError,
    flattened,
    type_text,
    value_codes,
)

FAST_MATH = {"contract", "nsz", "reassoc"}
"""Optimisations that are allowed: fused multiply-add and regrouping.

NaN and infinity keep their meaning, which the checks need.
"""

OPTIONS: dict[str, object] = {
    "fastmath": FAST_MATH,
    "error_model": "numpy",
    "no_cpython_wrapper": True,  # ctypes calls the code
    "no_cfunc_wrapper": True,
}

Function = Callable[..., Any]

OnCompile = Callable[[str], None]
"""Callback for messages while code is compiled."""

LOOP = "the time loop of this type of model"

_LOCK = threading.RLock()

_PENDING: list[tuple[Function, Function, str]] = []
"""Functions that are not yet registered with Numba.

Each is a generic function; a function of Numba's types of its arguments, which returns the implementation in compiled
code; and "always" or "never", whether that is merged into its caller.
"""

CALLABLE = {"no_cpython_wrapper": False, "inline": "never"}
"""Options by which Python can call a function of Numba."""

MISSING_NAME_ERRORS = (AttributeError, ImportError, LookupError, TypeError)
"""Errors of a name that another version of Numba does not have, or has with another meaning."""


class Laws(Protocol):
    """Laws that compiled code chooses by the type of their constants."""

    def by_type(self, kind: type | None) -> Any:
        """Return the law with constants of this type, or None.

        `inlined` has the names of fields whose kernels are merged into their caller, `helpers` the functions that
        they call.
        """


def _numba_code() -> ModuleType:
    """Return the module that compiles, with all functions registered."""
    from machine_code import numba_code

    numba_code.register_kernel_type(Kernel)
    while _PENDING:
        numba_code.replace_generic(*_PENDING.pop(0))
    return numba_code


class Kernel:
    """A function that is compiled on first call for its argument types.

    function: in the part of Python that Numba compiles. options: of `numba.njit`. A call raises UnknownTypeError for
    arguments and results other than numbers, arrays, None and tuples of these.
    """

    def __init__(self, function: Function, options: dict[str, object]) -> None:
        functools.update_wrapper(self, function)
        self.py_func, self.targetoptions = function, options
        self._calls: dict[Kinds, Call] = {}

    def __reduce__(self) -> str:
        return self.py_func.__qualname__

    def __call__(self, *arguments: object) -> Any:
        return self.bound(*arguments)()

    def bound(self, *arguments: object) -> Callable[[], Any]:
        """Return the call with these arguments, which are prepared once.

        Arrays among them must keep their memory.
        """
        kinds, values = flattened(arguments)
        call = self._calls.get(kinds) or self._call_for(kinds, arguments)
        if call is None:
            return functools.partial(self._through_numba, *_plain(arguments))
        return lambda alive=arguments: call(values)  # type: ignore[misc]  # keeps the arrays whose addresses are in values

    def has_code(self, *arguments: object) -> bool:
        """Return True if there is machine code for arguments of these types.

        It may be in this process or on disk, from which it is then loaded.
        """
        return self._call_for(flattened(arguments)[0]) is not None

    def path(self, *arguments: object) -> Path:
        """Return the file of the machine code for arguments of these types."""
        return self._file(flattened(arguments)[0])[0]

    @functools.cached_property
    def dispatcher(self) -> Any:
        """Numba's dispatcher of the function, for calls from other compiled code."""
        return _numba_code().make_dispatcher(self.py_func, self.targetoptions)

    def _file(self, kinds: Kinds) -> tuple[Path, dict[str, object]]:
        """Return the file of the code for these types, and its identity.

        The identity is all on which the code depends, and the file must have the same.
        """
        function = self.py_func
        identity = object_code.machine() | {
            "kernel": f"{function.__module__}.{function.__qualname__}",
            "arguments": " ".join(map(type_text, kinds)),
            "values": "".join(map(value_codes, kinds)),
            "sources": folder.sources() + folder.own_sources(function),
        }
        digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:20]
        return folder.cache_folder() / f"{function.__name__}-{digest}.code", identity

    @functools.cached_property
    def _through_numba(self) -> Any:
        """Function that calls through Numba itself."""
        return _numba_code().make_dispatcher(self.py_func, {"nogil": True} | self.targetoptions | CALLABLE)

    def _call_for(self, kinds: Kinds, arguments: tuple[object, ...] | None = None) -> Call | None:
        """Return the call of the machine code, compiled where arguments are present.

        The result is None without arguments where there is no code, and where Numba does not have a name that this
        needs.
        """
        with _LOCK:
            try:
                if kinds not in self._calls and "_through_numba" not in vars(self):
                    self._load(kinds, arguments)
            except UnknownTypeError:
                raise
            except MISSING_NAME_ERRORS:
                self._through_numba  # noqa: B018  # from this call on
            return self._calls.get(kinds)

    def _load(self, kinds: Kinds, arguments: tuple[object, ...] | None) -> None:
        """Load the machine code for these types, compiled if necessary."""
        path, identity = self._file(kinds)
        code = object_code.decoded(folder.read(path, object_code.LARGEST), identity)
        if code is None:
            if arguments is None:
                return
            code = _numba_code().compile_for(self.dispatcher, _plain(arguments))
            if code.arguments != identity["values"]:
                raise UnknownTypeError(f"{self.py_func.__name__} takes {code.arguments}")
            with suppress(OSError):  # the code is valid, and `compile_once` reports it
                folder.write(path, object_code.encoded(code, identity))
        if object_code.helpers_of(code):  # a law calls functions of Numba
            _numba_code().register_numba_symbols()
        self._calls[kinds] = object_code.load_code(code)


def _plain(arguments: tuple[object, ...]) -> tuple[object, ...]:
    """Return the arguments with prepared ones replaced by their values."""
    return tuple(argument.value if isinstance(argument, Prepared) else argument for argument in arguments)


def inlined(function: Function) -> Kernel:
    """Decorate a function that is merged into its compiled callers.

    Only then are its SIMD blocks vectorised.
    """
    return Kernel(function, OPTIONS | {"inline": "always"})


def compiled(function: Function) -> Kernel:
    """Decorate a function that is compiled on first call and stored.

    The compiled code runs without the lock of the interpreter, in parallel with other Python threads.
    """
    return Kernel(function, OPTIONS | {"nogil": True})


def allocation_free(function: Function) -> Kernel:
    """Decorate a function as `compiled` does, if it creates no array.

    Numba then counts no references to arrays, which takes a quarter of the time of a loop over many views.
    """
    return Kernel(function, OPTIONS | {"nogil": True, "_nrt": False})


def compile_once(
    compile_all: Callable[[], object], kernel: Kernel, *arguments: object, on_compile: OnCompile
) -> None:
    """Compile, or load from disk, all code of a run.

    Of each kind of model, one process of the machine compiles at a time. kernel, arguments: their machine code shows
    whether this was done before. on_compile: called with the expected time where code has to be compiled, and
    afterwards with the time that it took and the reason if it is not stored; and while another process is waited for.
    """
    if not kernel.has_code(*arguments):
        code = kernel.path(*arguments)
        with folder.one_process_compiles(
            code, lambda: on_compile(f"waiting for another process to compile {LOOP}")
        ):
            if not kernel.has_code(*arguments):
                on_compile(f"compiling {LOOP}, once on this machine: about {folder.expected_time():.0f} s")
                began = time.perf_counter()
                compile_all()
                spent, remark = time.perf_counter() - began, ""
                try:
                    folder.save_time(spent)
                except OSError as error:
                    remark = f", not kept for the next run: {code.parent}: {error.strerror or error}"
                on_compile(f"compiled in {spent:.0f} s{remark}")
                return
    compile_all()


def ignore_compiling(message: str) -> None:
    """Ignore messages about compiling."""


def by_law(laws: Laws, kernel: str) -> Function:
    """Return a compiled function that calls the kernel of a law.

    kernel: field of the law. The law is the one whose constants the first argument holds, chosen by their type when a
    loop is compiled.
    """

    def generic(constants: object, *rest: object) -> object:
        raise NotImplementedError(type(constants))

    def chooser(merged: bool) -> Function:
        def choose(first: object, *rest: object) -> object:
            from machine_code.numba_code import make_callable, python_type

            law = laws.by_type(python_type(first))
            if law is None or (kernel in law.inlined) != merged:
                return None
            for helper in law.helpers:
                make_callable(helper)
            return getattr(law, kernel)

        return choose

    for merged, inline in ((True, "always"), (False, "never")):
        _PENDING.append((generic, chooser(merged), inline))
    return generic


def optional(merged: bool = False) -> Function:
    """Decorate a function of compiled code for a first argument None.

    `implements` adds those for other types.
    """

    def register(function: Function) -> Function:
        implements(function, type(None), merged)(function)
        return function

    return register


def implements(generic: Function, kind: type, merged: bool = False) -> Function:
    """Decorate the implementation of `generic` for a type of first argument.

    kind: a NamedTuple. It is for parts of the loop itself; laws, which a scene names, are chosen by `by_law`. merged:
    True to merge the code into the caller.
    """

    def register(implementation: Function) -> Function:
        def choose(first: object, *rest: object) -> object:
            from machine_code.numba_code import python_type

            return implementation if python_type(first) is kind else None

        _PENDING.append((generic, choose, "always" if merged else "never"))
        return implementation

    return register


def chosen(generic: Function) -> Function:
    """Decorate a function that returns the implementation of `generic`.

    It receives Numba's types of the arguments.
    """

    def register(choose: Function) -> Function:
        _PENDING.append((generic, choose, "always"))
        return choose

    return register
