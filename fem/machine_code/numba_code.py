"""Compiling by Numba: the one module that imports it, when something is to be compiled."""

import functools
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from fem.lazy import unseen
from fem.machine_code.object_code import ADDRESS, FLOAT, INTEGER, LOGICAL, ObjectCode, UnknownTypeError

with unseen("coverage", "cffi"):  # Numba loads them where it finds them, at length
    import numba
    from numba.extending import overload, register_jitable, typeof_impl

    with suppress(ImportError):
        import numba.core.typing.cffi_utils

# NUMBA_DISABLE_JIT is for functions of one's own: these loops would take days, and have parts that exist as
# compiled code alone.
numba.config.DISABLE_JIT = 0

NUMBERS = {"float64": FLOAT, "int64": INTEGER, "bool": LOGICAL, "none": None}
"""Results, by Numba's names of their types."""


def make_dispatcher(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Numba's dispatcher of a function, which other compiled code can call."""
    return numba.njit(**options)(function)


def compile_for(dispatcher: Any, arguments: tuple[Any, ...]) -> ObjectCode:
    """Machine code for arguments of these types."""
    types = tuple(map(numba.typeof, arguments))
    dispatcher.compile(types)
    made = dispatcher.overloads[types]
    convention = dispatcher.targetctx.call_conv
    layout = convention.get_function_type(made.fndesc.restype, made.fndesc.argtypes)
    codes = "".join(map(_code, layout.args[2:]))  # behind the addresses of the result and of an error
    return ObjectCode(
        made.fndesc.llvm_func_name, codes, _result(made.fndesc.restype), made.library._get_compiled_object()
    )


def offer_helpers() -> None:
    """Tell LLVM where Numba's own functions are, as Numba does when it compiles."""
    from numba.core.registry import cpu_target

    cpu_target.target_context.refresh()


def replace_generic(generic: Callable[..., Any], choose: Callable[..., Any], inline: str) -> None:
    """Let compiled code that calls `generic` call what `choose` says of Numba's types of the arguments."""
    overload(generic, strict=False, inline=inline)(choose)


def python_type(kind: Any) -> type | None:
    """The Python type behind Numba's type of a NamedTuple or None; None for any other."""
    none = type(None) if isinstance(kind, numba.types.NoneType) else None
    return getattr(kind, "instance_class", none)


@functools.cache
def make_callable(helper: Callable[..., Any]) -> None:
    """Let compiled code call this plain function."""
    register_jitable(helper)


def _code(kind: Any) -> str:
    """The code of a value in the row of arguments, by LLVM's name of its type."""
    name = str(kind)
    return (
        ADDRESS
        if name.endswith("*") or name == "ptr"
        else {"double": FLOAT, "i64": INTEGER, "i8": LOGICAL}[name]
    )


def _result(kind: Any) -> Any:
    """A result as `ObjectCode` has it. Raises UnknownTypeError for other than numbers, None and tuples of these."""
    if isinstance(kind, numba.types.BaseTuple):
        made = getattr(kind, "instance_class", tuple)
        return [made.__module__, made.__qualname__, *map(_result, kind.types)]
    if str(kind) not in NUMBERS:
        raise UnknownTypeError(f"a kernel cannot return {kind}")
    return NUMBERS[str(kind)]


@functools.cache
def know(kernel: type) -> None:
    """Let compiled code call kernels of this class as it calls functions of Numba's."""
    typeof_impl.register(kernel)(lambda called, context: numba.types.Dispatcher(called.dispatcher))
