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

from machine_code import object_code
from machine_code.captures import CHOICES, Captures, Choose
from machine_code.object_code import Bind, Kinds, flattened, type_text, value_codes
from machine_code.system import folder
from machine_code.values import Implementation, Nothing, Record, Value, refuse

Function = Callable[..., Any]

OnCompile = Callable[[str], None]
"""Callback for messages while code is compiled."""

LOOP = "the time loop of this type of model"

_LOCK = threading.RLock()


class Laws(Protocol):
    """Laws that compiled code chooses by the type of their constants."""

    def by_type(self, kind: type | None) -> Any:
        """Return the law with constants of this type, or None.

        `inlined` has the names of fields whose kernels are merged into their caller.
        """


class Kernel:
    """A function that is compiled on first call for its argument types.

    function: in the language of kernels (docs/kernels.md), whose names are read when it is compiled, at the start of
    a run. A call raises UnknownTypeError for arguments and results other than numbers, arrays, None and tuples of
    these.
    """

    def __init__(self, function: Function, **choices: bool) -> None:
        functools.update_wrapper(self, function)
        self.py_func, self.implementation = function, Implementation(function, **choices)
        self._binds: dict[Kinds, Bind] = {}
        self._captures: dict[Kinds, Captures] = {}

    def __reduce__(self) -> str:
        return self.py_func.__qualname__

    def __call__(self, *arguments: object) -> Any:
        return self.bound(*arguments)()

    def bound(self, *arguments: object) -> Callable[[], Any]:
        """Return the call with these arguments, which are prepared once.

        Arrays among them must keep their memory.
        """
        kinds, values = flattened(arguments)
        bind = self._binds.get(kinds)
        if bind is None or not self._captures[kinds].are_current(with_functions=False):
            bind = self._bind_for(kinds)
        call = bind(values)
        return lambda alive=arguments: call()  # type: ignore[misc]  # keeps the arrays whose addresses are in values

    def is_loaded(self, *arguments: object) -> bool:
        """Return True if this process has machine code for such arguments.

        It is of the functions and values that the kernel names now.
        """
        kinds = flattened(arguments)[0]
        return kinds in self._binds and self._captured(kinds) is self._captures[kinds]

    def has_code(self, *arguments: object) -> bool:
        """Return True if there is machine code for arguments of these types.

        It may be in this process or on disk, from which it is then loaded.
        """
        return self._stored_bind(flattened(arguments)[0]) is not None

    def path(self, *arguments: object) -> Path:
        """Return the file of the machine code for arguments of these types."""
        kinds = flattened(arguments)[0]
        return self._file(kinds, self._captured(kinds))[0]

    def assembly(self, *arguments: object) -> str:
        """Return the text of the machine code for arguments of these types."""
        from machine_code import llvm_code

        kinds = flattened(arguments)[0]
        return llvm_code.assembly(self.implementation, kinds, implementation_of)

    def _captured(self, kinds: Kinds) -> Captures:
        """Return the functions and values on which code for these types depends."""
        captures = self._captures.get(kinds)
        if captures is None or not captures.are_current():
            records = {kind[0] for kind in kinds if isinstance(kind, tuple) and len(kind) == 2}
            captures = Captures(self, {type(None), *records})
        return captures

    def _file(self, kinds: Kinds, captures: Captures) -> tuple[Path, dict[str, object]]:
        """Return the file of the code for these types, and its identity.

        The identity is all on which the code depends, and the file must have the same.
        """
        function = self.py_func
        identity = object_code.machine() | {
            "kernel": f"{function.__module__}.{function.__qualname__}",
            "arguments": " ".join(map(type_text, kinds)),
            "values": "".join(map(value_codes, kinds)),
            "sources": [folder.own_sources("machine_code"), captures.digest],
        }
        digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:20]
        return folder.cache_folder() / f"{function.__name__}-{digest}.code", identity

    def _stored_bind(self, kinds: Kinds) -> Bind | None:
        """Return the binding of machine code that exists, or None.

        It is in this process or on disk.
        """
        with _LOCK:
            captures = self._captured(kinds)
            if self._captures.get(kinds) is not captures:
                path, identity = self._file(kinds, captures)
                code = object_code.decoded(folder.read(path, object_code.LARGEST), identity)
                self._binds.pop(kinds, None)  # before the captures, which other threads compare
                self._captures[kinds] = captures
                with suppress(LookupError):  # of another kernel
                    self._binds |= {kinds: object_code.load_code(code)} if code else {}
            return self._binds.get(kinds)

    def _bind_for(self, kinds: Kinds) -> Bind:
        """Return the binding of the machine code, compiled if necessary."""
        with _LOCK:
            bind = self._stored_bind(kinds)
            if bind is None:
                code = self._compiled(kinds, self._captures[kinds])
                bind = self._binds[kinds] = object_code.load_code(code)
            return bind

    def _compiled(self, kinds: Kinds, captures: Captures) -> object_code.ObjectCode:
        """Compile the code for these types, and store it."""
        from machine_code.llvm_code import compile_kernel
        from machine_code.translate import symbol_of

        def resolve(callee: object, arguments: tuple[Value, ...]) -> Implementation | None:
            implementation = implementation_of(callee, arguments)
            if implementation is not None and not captures.follows(implementation.function):
                refuse(f"{implementation.function.__qualname__}, whose captured values are not known before")
            return implementation

        path, identity = self._file(kinds, captures)
        symbol = symbol_of(f"kernel_{path.stem.rpartition('-')[2]}", self.py_func)
        code = compile_kernel(self.implementation, kinds, resolve, symbol)
        with suppress(OSError):  # the code is valid, and `compile_once` reports it
            if folder.own_sources.__wrapped__("machine_code") == folder.own_sources("machine_code"):
                folder.write(path, object_code.encoded(code, identity))
        return code


def implementation_of(callee: object, arguments: tuple[Value, ...]) -> Implementation | None:
    """Return the Python function that compiled code calls, or None."""
    if isinstance(callee, Kernel):
        return callee.implementation
    if not isinstance(callee, FunctionType):
        return None
    for choose, is_merged in CHOICES.get(callee, ()):
        chosen = choose(*arguments)
        if chosen is not None:
            implementation = getattr(chosen, "implementation", Implementation(chosen))
            return implementation._replace(is_merged=is_merged)
    return None if callee in CHOICES else Implementation(callee)


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


def reordered(function: Function) -> Kernel:
    """Decorate a compiled function whose sums may have any order.

    It holds for the functions that are merged into it. Such sums lose the error terms and, where numbers cancel, the
    NaN of those of Python.
    """
    return Kernel(function, is_reordered=True)


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
    CHOICES.setdefault(generic, []).append((choose, is_merged))


def _type_of(value: Value) -> type | None:
    """Return the type of a NamedTuple or None, and None for others."""
    if isinstance(value, Nothing):
        return type(None)
    return value.kind if isinstance(value, Record) else None
