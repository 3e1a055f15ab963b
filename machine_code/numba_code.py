"""Compiling by Numba, in the only module that imports it."""

import functools
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from machine_code.object_code import ADDRESS, FLOAT, INTEGER, LOGICAL, ObjectCode, Result, UnknownTypeError

if TYPE_CHECKING:
    from numba.core.dispatcher import Dispatcher

NUMBERS = {"float64": FLOAT, "int64": INTEGER, "bool": LOGICAL, "none": None}
"""Codes of results by Numba's names of their types."""


@contextmanager
def hidden_modules(*modules: str) -> Iterator[None]:
    """Import as if these modules were not installed.

    Modules that are already imported remain.
    """
    hidden = [module for module in modules if module not in sys.modules]
    for module in hidden:
        sys.modules[module] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        for module in hidden:
            del sys.modules[module]


with hidden_modules("coverage", "cffi"):  # Numba imports them if installed, which takes long
    import numba
    from numba.extending import overload, register_jitable, typeof_impl

    with suppress(ImportError):
        import numba.core.typing.cffi_utils

# NUMBA_DISABLE_JIT is for functions of users. Without compilation these loops would take days, and parts of them exist
# only as compiled code.
numba.config.DISABLE_JIT = 0


def make_dispatcher(function: Callable[..., object], options: dict[str, object]) -> "Dispatcher":
    """Return Numba's dispatcher of a function for other compiled code."""
    return numba.njit(**options)(function)


def compile_for(dispatcher: "Dispatcher", arguments: tuple[object, ...]) -> ObjectCode:
    """Return the machine code for arguments of these types."""
    types = tuple(map(numba.typeof, arguments))
    dispatcher.compile(types)
    specialised, convention = dispatcher.overloads[types], dispatcher.targetctx.call_conv
    description = specialised.fndesc
    layout = convention.get_function_type(description.restype, description.argtypes)
    codes = "".join(map(_code, layout.args[2:]))  # behind the addresses of the result and of an error
    machine_code = specialised.library._get_compiled_object()
    return ObjectCode(description.llvm_func_name, codes, _result(description.restype), machine_code)


def register_numba_symbols() -> None:
    """Register the addresses of Numba's own functions with LLVM.

    Numba does the same when it compiles.
    """
    from numba.core.registry import cpu_target

    cpu_target.target_context.refresh()


def replace_generic(generic: Callable[..., object], choose: Callable[..., object], inline: str) -> None:
    """Replace `generic` in compiled code by the function that `choose` returns.

    It receives Numba's types of the arguments.
    """
    overload(generic, strict=False, inline=inline)(choose)


def python_type(kind: object) -> type | None:
    """Return the Python type behind Numba's type of a NamedTuple or None.

    The result is None for any other type.
    """
    none = type(None) if isinstance(kind, numba.types.NoneType) else None
    return getattr(kind, "instance_class", none)


@functools.cache
def make_callable(helper: Callable[..., object]) -> None:
    """Register a plain function for calls from compiled code."""
    register_jitable(helper)


def _code(kind: object) -> str:
    """Return the code of an argument.

    kind: LLVM's type.
    """
    name = str(kind)
    return (
        ADDRESS
        if name.endswith("*") or name == "ptr"
        else {"double": FLOAT, "i64": INTEGER, "i8": LOGICAL}[name]
    )


def _result(kind: object) -> Result:
    """Return the type of a result in the form of `ObjectCode`.

    Raises UnknownTypeError for other than numbers, None and tuples of these.
    """
    if isinstance(kind, numba.types.BaseTuple):
        python_class = getattr(kind, "instance_class", tuple)
        return [python_class.__module__, python_class.__qualname__, *map(_result, kind.types)]
    if str(kind) not in NUMBERS:
        raise UnknownTypeError(f"a kernel cannot return {kind}")
    return NUMBERS[str(kind)]


@functools.cache
def register_kernel_type(kernel: type) -> None:
    """Let compiled code call kernels of this class."""
    typeof_impl.register(kernel)(lambda called, context: numba.types.Dispatcher(called.dispatcher))
