"""Compiled functions, with the decorators that make them and their call.

A call uses machine code on disk. Where there is none, the function is translated (`translate`) and compiled by LLVM
first.
"""

import functools
import hashlib
import json
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FunctionType
from typing import Any, Protocol

from machine_code import folder, object_code
from machine_code.object_code import (
    Bind,
    Kinds,
    flattened,
    type_text,
    value_codes,
)
from machine_code.values import Implementation, Nothing, Record, Value

Function = Callable[..., Any]

OnCompile = Callable[[str], None]
"""Callback for messages while code is compiled."""

LOOP = "the time loop of this type of model"

_LOCK = threading.RLock()

Choose = Callable[..., Function | None]
"""Function of the arguments' values that returns an implementation, or None if it has none for them."""

_IMPLEMENTATIONS: dict[Function, list[tuple[Choose, bool]]] = {}
"""Choices of the implementations of generic functions, and whether their code is merged into the caller."""


class Laws(Protocol):
    """Laws that compiled code chooses by the type of their constants."""

    def by_type(self, kind: type | None) -> Any:
        """Return the law with constants of this type, or None.

        `inlined` has the names of fields whose kernels are merged into their caller.
        """


class Kernel:
    """A function that is compiled on first call for its argument types.

    function: in the part of Python of `translate`. is_merged: True to merge the code into compiled callers.
    is_compact: see `compact`. A call raises UnknownTypeError for arguments and results other than numbers, arrays,
    None and tuples of these.
    """

    def __init__(self, function: Function, is_merged: bool = False, is_compact: bool = False) -> None:
        functools.update_wrapper(self, function)
        self.py_func, self.is_merged, self.is_compact = function, is_merged, is_compact
        self._binds: dict[Kinds, Bind] = {}

    def __reduce__(self) -> str:
        return self.py_func.__qualname__

    def __call__(self, *arguments: object) -> Any:
        return self.bound(*arguments)()

    def bound(self, *arguments: object) -> Callable[[], Any]:
        """Return the call with these arguments, which are prepared once.

        Arrays among them must keep their memory.
        """
        kinds, values = flattened(arguments)
        bind = self._binds.get(kinds) or self._bind_for(kinds)
        call = bind(values)
        return lambda alive=arguments: call()  # type: ignore[misc]  # keeps the arrays whose addresses are in values

    def is_loaded(self, *arguments: object) -> bool:
        """Return True if this process has machine code for such arguments."""
        return flattened(arguments)[0] in self._binds

    def has_code(self, *arguments: object) -> bool:
        """Return True if there is machine code for arguments of these types.

        It may be in this process or on disk, from which it is then loaded.
        """
        return self._stored_bind(flattened(arguments)[0]) is not None

    def path(self, *arguments: object) -> Path:
        """Return the file of the machine code for arguments of these types."""
        return self._file(flattened(arguments)[0])[0]

    def assembly(self, *arguments: object) -> str:
        """Return the text of the machine code for arguments of these types."""
        from machine_code import llvm_code

        kinds = flattened(arguments)[0]
        return llvm_code.assembly(self.py_func, kinds, implementation_of, self.is_compact)

    def _file(self, kinds: Kinds) -> tuple[Path, dict[str, object]]:
        """Return the file of the code for these types, and its identity.

        The identity is all on which the code depends, and the file must have the same.
        """
        function, constants = self.py_func, {kind[0] for kind in kinds if isinstance(kind, tuple)}
        identity = object_code.machine() | {
            "kernel": f"{function.__module__}.{function.__qualname__}",
            "arguments": " ".join(map(type_text, kinds)),
            "values": "".join(map(value_codes, kinds)),
            "sources": [folder.own_sources(), folder.sources_of(function), folder.sources_of_laws(constants)],
        }
        digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:20]
        return folder.cache_folder() / f"{function.__name__}-{digest}.code", identity

    def _stored_bind(self, kinds: Kinds) -> Bind | None:
        """Return the binding of machine code that exists, or None.

        It is in this process or on disk.
        """
        with _LOCK:
            if kinds not in self._binds:
                path, identity = self._file(kinds)
                code = object_code.decoded(folder.read(path, object_code.LARGEST), identity)
                with suppress(LookupError):  # of another kernel
                    self._binds |= {kinds: object_code.load_code(code)} if code else {}
            return self._binds.get(kinds)

    def _bind_for(self, kinds: Kinds) -> Bind:
        """Return the binding of the machine code, compiled if necessary."""
        with _LOCK:
            bind = self._stored_bind(kinds)
            if bind is None:
                bind = self._binds[kinds] = object_code.load_code(self._compiled(kinds))
            return bind

    def _compiled(self, kinds: Kinds) -> object_code.ObjectCode:
        """Compile the code for these types, and store it."""
        from machine_code.llvm_code import compile_kernel

        path, identity = self._file(kinds)
        code = compile_kernel(self.py_func, kinds, implementation_of, self.is_compact)
        with suppress(OSError):  # the code is valid, and `compile_once` reports it
            folder.write(path, object_code.encoded(code, identity))
        return code


def implementation_of(callee: object, arguments: tuple[Value, ...]) -> Implementation | None:
    """Return the Python function that compiled code calls, or None."""
    if isinstance(callee, Kernel):
        return Implementation(callee.py_func, callee.is_merged, callee.is_compact)
    if not isinstance(callee, FunctionType):
        return None
    for choose, is_merged in _IMPLEMENTATIONS.get(callee, ()):
        implementation = choose(*arguments)
        if implementation is not None:
            function = getattr(implementation, "py_func", implementation)
            return Implementation(function, is_merged, getattr(implementation, "is_compact", False))
    return None if callee in _IMPLEMENTATIONS else Implementation(callee, False, False)


def inlined(function: Function) -> Kernel:
    """Decorate a function that is merged into its compiled callers.

    Only then are its SIMD blocks vectorised.
    """
    return Kernel(function, is_merged=True)


def compiled(function: Function) -> Kernel:
    """Decorate a function that is compiled on first call and stored.

    The compiled code runs without the lock of the interpreter, in parallel with other Python threads.
    """
    return Kernel(function)


def compact(function: Function) -> Kernel:
    """Decorate a compiled function whose loops are short or rarely run.

    The loops are neither vectorised nor unrolled, with which a kernel compiles in two thirds of the time. Called from
    Python, it holds for all functions that this one calls.
    """
    return Kernel(function, is_compact=True)


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

    def chooser(is_merged: bool) -> Choose:
        def choose(first: Value, *rest: Value) -> Function | None:
            law = laws.by_type(_type_of(first))
            return None if law is None or (kernel in law.inlined) != is_merged else getattr(law, kernel)

        return choose

    for is_merged in (True, False):
        _add_choice(generic, chooser(is_merged), is_merged)
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
        def choose(first: Value, *rest: Value) -> Function | None:
            return implementation if _type_of(first) is kind else None

        _add_choice(generic, choose, merged)
        return implementation

    return register


def chosen(generic: Function) -> Function:
    """Decorate a function that returns the implementation of `generic`.

    It receives the values of the arguments (`machine_code.values`).
    """

    def register(choose: Choose) -> Choose:
        _add_choice(generic, choose, True)
        return choose

    return register


def _add_choice(generic: Function, choose: Choose, is_merged: bool) -> None:
    _IMPLEMENTATIONS.setdefault(generic, []).append((choose, is_merged))


def _type_of(value: Value) -> type | None:
    """Return the type of a NamedTuple or None, and None for others."""
    if isinstance(value, Nothing):
        return type(None)
    return value.kind if isinstance(value, Record) else None
