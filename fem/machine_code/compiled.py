"""The decorators by which everything in this package is compiled, and how laws get into compiled code.

Nothing here imports Numba: see `fem.machine_code`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from fem.machine_code.folder import expected_time, keep_time, one_process_compiles
from fem.machine_code.kernel import Kernel, replace_in_code
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

LOOP = "the time loop of this kind of model"


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
        with one_process_compiles(
            code, lambda: on_compile(f"waiting for another process that compiles {LOOP}")
        ):
            if not kernel.has_code(*arguments):
                on_compile(f"compiling {LOOP}, once on this machine: about {expected_time():.0f} s")
                began = time.perf_counter()
                compile_all()
                spent, kept = time.perf_counter() - began, ""
                try:
                    keep_time(spent)
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
        replace_in_code(generic, chooser(merged), inline)
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

        replace_in_code(generic, choose, "always" if merged else "never")
        return implementation

    return register


def chosen(generic: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator: in compiled code `generic` is what the decorated function says of Numba's types of the arguments."""

    def register(choose: Callable[..., Any]) -> Callable[..., Any]:
        replace_in_code(generic, choose, "always")
        return choose

    return register
