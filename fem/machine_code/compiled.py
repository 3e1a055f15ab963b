"""Compiled functions: the decorators, how laws get into compiled code, and the call by machine code on disk.

Numba compiles first where there is no machine code. Where another Numba lacks a name that this needs and Numba does not
promise, a call goes through Numba itself: slower, for Numba is imported and compiles in every process, and as right.
"""

import functools
import hashlib
import json
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from fem.machine_code import folder, object_code
from fem.machine_code.object_code import Call, Prepared, UnknownTypeError, codes, flattened, spelled
from fem.registry import LawRegistry

FAST_MATH = {"contract", "nsz", "reassoc"}
"""Fused multiply-add and regrouping are allowed; NaN and infinity keep their meaning, the checks need them."""

OPTIONS: dict[str, Any] = {
    "fastmath": FAST_MATH,
    "error_model": "numpy",
    "no_cpython_wrapper": True,  # the code is called by ctypes
    "no_cfunc_wrapper": True,
}

OnCompile = Callable[[str], None]
"""Callback of what there is to say while something is compiled."""

LOOP = "the time loop of this type of model"

_FINDING = threading.RLock()

_PENDING: list[tuple[Callable[..., Any], Callable[..., Any], str]] = []
"""Functions that Numba has not been given yet: a generic function; a function of Numba's types of its arguments, which
returns what the generic is in compiled code; and "always" or "never", whether that is merged into its caller."""

CALLABLE = {"no_cpython_wrapper": False, "inline": "never"}
"""Options by which Python can call what Numba makes."""

NAMELESS = (AttributeError, ImportError, LookupError, TypeError)
"""Errors by which a name shows that another Numba lacks, or has with another meaning."""


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
        return self.bound(*arguments)()

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
        function = self.py_func
        identity = object_code.machine() | {
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


def inlined(function: Callable[..., Any]) -> Any:
    """A part of a compiled loop that must be merged into it: only then are its SIMD blocks vectorised."""
    return Kernel(function, OPTIONS | {"inline": "always"})


def compiled(function: Callable[..., Any]) -> Any:
    """Compile on first call for the types it meets, and keep the result on disk.

    The compiled code lets other Python threads run.
    """
    return Kernel(function, OPTIONS | {"nogil": True})


def compile_once(
    compile_all: Callable[[], Any], kernel: Kernel, *arguments: Any, on_compile: OnCompile
) -> None:
    """Compile, or load from disk, what a run needs: of each kind of model, one process of the machine at a time.

    kernel, arguments: by whose machine code it is known whether that was done before. on_compile: called with the time
    expected where it has to be compiled, and when that is done with the time it took, and why it is not kept if so; and
    where another process is waited for.
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
                spent, kept = time.perf_counter() - began, ""
                try:
                    folder.keep_time(spent)
                except OSError as error:
                    kept = f", not kept for the next run: {code.parent}: {error.strerror or error}"
                on_compile(f"compiled in {spent:.0f} s{kept}")
                return
    compile_all()


def ignore_compiling(said: str) -> None:
    """Ignore what is said of compiling."""


def by_law(laws: LawRegistry[Any], kernel: str) -> Callable[..., Any]:
    """Function of compiled code alone: the field `kernel` of the law whose constants the first argument holds, chosen
    by its type when a loop is compiled."""

    def generic(constants: Any, *rest: Any) -> Any:
        raise NotImplementedError(type(constants))

    def chooser(merged: bool) -> Callable[..., Any]:
        def choose(first: Any, *rest: Any) -> Any:
            from fem.machine_code.numba_code import make_callable, python_type

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


def optional(merged: bool = False) -> Callable[..., Any]:
    """Decorator: a function of compiled code for a first argument None; `implements` adds those for other types."""

    def register(function: Callable[..., Any]) -> Callable[..., Any]:
        implements(function, type(None), merged)(function)
        return function

    return register


def implements(generic: Callable[..., Any], kind: type, merged: bool = False) -> Callable[..., Any]:
    """Decorator: what `generic` is, in compiled code, for a first argument of this type, a NamedTuple.

    For parts of the loop itself; laws, which a scene names, are found by `by_law`. merged: put into the caller.
    """

    def register(implementation: Callable[..., Any]) -> Callable[..., Any]:
        def choose(first: Any, *rest: Any) -> Any:
            from fem.machine_code.numba_code import python_type

            return implementation if python_type(first) is kind else None

        _PENDING.append((generic, choose, "always" if merged else "never"))
        return implementation

    return register


def chosen(generic: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator: in compiled code `generic` is what the decorated function says of Numba's types of the arguments."""

    def register(choose: Callable[..., Any]) -> Callable[..., Any]:
        _PENDING.append((generic, choose, "always"))
        return choose

    return register
