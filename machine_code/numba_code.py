"""Compiling by Numba, in the only module that imports it."""

import functools
import gc
import operator
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from machine_code.object_code import ADDRESS, FLOAT, INTEGER, LOGICAL, ObjectCode, Result, UnknownTypeError

if TYPE_CHECKING:
    from numba.core.dispatcher import Dispatcher

NUMBERS = {"float64": FLOAT, "int64": INTEGER, "bool": LOGICAL, "none": None}
"""Codes of results by Numba's names of their types."""

OPERATORS = {
    operator.add, operator.sub, operator.mul, operator.truediv, operator.neg, operator.iadd, operator.isub,
    operator.imul, operator.itruediv, operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne,
    operator.getitem, operator.setitem,
}  # fmt: skip
"""Operators whose types depend on the types of numbers and arrays alone, not on the values of literals."""


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


# Numba imports them if installed, which takes long, and would colour thousands of messages that are not shown.
with hidden_modules("coverage", "cffi", "colorama"):
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
    with _short_compilation():
        dispatcher.compile(types)
        specialised, convention = dispatcher.overloads[types], dispatcher.targetctx.call_conv
        machine_code = specialised.library.machine_code()
    description = specialised.fndesc
    layout = convention.get_function_type(description.restype, description.argtypes)
    codes = "".join(map(_code, layout.args[2:]))  # behind the addresses of the result and of an error
    return ObjectCode(description.llvm_func_name, codes, _result(description.restype), machine_code)


@contextmanager
def _short_compilation() -> Iterator[None]:
    """Determine types and optimise functions once, without collecting garbage."""
    from numba.core.registry import cpu_target
    from numba.core.types import Function

    with numba.core.compiler_lock.global_compiler_lock:
        cpu_target.target_context.refresh()  # compiles Numba's own functions, which need their addresses
        codegen = cpu_target.target_context.codegen()
        library, set_env = _linked_library(), codegen.set_env
        get_call_type, collects = Function.get_call_type, gc.isenabled()

        def set_env_of_code(name: str, environment: object) -> None:
            if codegen._engine.get_global_value_address(name):
                set_env(name, environment)

        gc.disable()
        Function.get_call_type = _known_call_type(get_call_type)  # type: ignore[method-assign]
        codegen._library_class, codegen.set_env = library, set_env_of_code
        try:
            yield
        finally:
            Function.get_call_type = get_call_type  # type: ignore[method-assign]
            del codegen._library_class, codegen.set_env
            if collects:
                gc.enable()


@functools.cache
def _linked_library() -> type:
    """Return the class of libraries that are optimised within their callers.

    Numba optimises and translates every function, also those that only other compiled functions call, and that takes
    most of the time.
    """
    from numba.core.codegen import JITCodeLibrary

    class LinkedLibrary(JITCodeLibrary):
        """A function with those that it calls."""

        def machine_code(self) -> bytes:
            """Return the object code of the optimised functions."""
            if not self._compiled_object:
                self._get_module_for_linking()  # a copy, so that callers do not depend on the order of compiling
                for _ in range(2):  # loops of triangles take a tenth more time after one pass
                    super()._optimize_final_module()
                super()._finalize_final_module()
            return self._get_compiled_object()

        def _optimize_final_module(self) -> None:
            if self._called_from_python():
                super()._optimize_final_module()

        def _finalize_final_module(self) -> None:
            self._finalized = True
            if self._called_from_python():
                super()._finalize_final_module()

        def _called_from_python(self) -> bool:
            """Return True if Python can call the function, as a user's."""
            return any(
                function.name.startswith("_ZN7cpython") and not function.is_declaration
                for function in self._final_module.functions
            )

    return LinkedLibrary


def _known_call_type(get_call_type: Callable[..., object]) -> Callable[..., object]:
    """Return a function that finds the types of each operation once.

    Numba tries tens of implementations of each operator on numbers and arrays.
    """
    plain = numba.types.Number, numba.types.Boolean, numba.types.Array
    memory: dict[tuple[object, ...], tuple[object, object]] = {}

    def call_type(function: Any, context: object, arguments: tuple[object, ...], named: object) -> object:
        kinds = tuple(map(numba.types.unliteral, arguments))
        if (
            named
            or function.typing_key not in OPERATORS
            or not all(isinstance(kind, plain) for kind in kinds)
        ):
            return get_call_type(function, context, arguments, named)
        key = id(function), *kinds
        if key not in memory:  # with the function, so that no other one has its address
            memory[key] = get_call_type(function, context, kinds, named), function
        return memory[key][0]

    return call_type


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
    """Register a function for calls from compiled code."""
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
