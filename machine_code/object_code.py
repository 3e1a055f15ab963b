"""Object code on disk, loaded by llvmlite and called by ctypes.

It is stored with the layout of its arguments: numbers and addresses of eight bytes each in a row. An array is the
address of its data, then shape and strides; tuples and NamedTuples are their items in turn, and None is nothing. A
kernel reads them from there, and writes the numbers of its result behind one another.
"""

import ctypes
import functools
import hashlib
import json
import os
import struct
import sys
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from machine_code import values as translated
from machine_code.values import ITEMS

if TYPE_CHECKING:
    from llvmlite.binding import ExecutionEngine, TargetMachine

FLOAT, INTEGER, LOGICAL, ADDRESS = "d", "q", "b", "P"
"""Codes of the `struct` module for arguments and results of a kernel."""

NUMBERS: dict[type, str] = {
    float: FLOAT,
    np.float64: FLOAT,
    int: INTEGER,
    np.int64: INTEGER,
    bool: LOGICAL,
    np.bool_: LOGICAL,
}
"""Codes by the types of numbers."""
LAST_INTEGER = 2**63
"""Smallest integer that does not fit."""

Kinds = tuple[object, ...]
"""Types of arguments: a code, None, class and length of a tuple, or type, dimensions and layout of an array."""

Result = str | None | list["Result"]
"""Type of a result: a code, None, or module and name of a tuple's class before the types of its items."""

Bind = Callable[[list[object]], Callable[[], object]]
"""Function from the values of arguments in a row to the call of machine code with them."""

CODES = {FLOAT: translated.FLOAT, INTEGER: translated.INTEGER, LOGICAL: translated.LOGICAL}
"""LLVM's types of numbers by their codes."""

CHECK_INDICES = "TAILSLAP_CHECK_INDICES"
"""Environment variable; with it, kernels end the process at an index outside an array."""

LARGEST, LONGEST_HEADER = 2**26, 2**16
"""Largest numbers of bytes of a file of object code, and of its first line."""


class UnknownTypeError(TypeError):
    """An argument of a type whose layout is not known here."""


class Prepared:
    """An argument prepared once for many calls.

    Arrays in it must keep their memory.
    """

    def __init__(self, value: object) -> None:
        self.value = value
        self.kinds, self.values = flattened((value,))


def flattened(arguments: tuple[object, ...]) -> tuple[Kinds, list[object]]:
    """Return the types of the arguments, and their values in a row.

    Machine code is chosen by the types. Raises UnknownTypeError for other than floats, integers, logicals, arrays of
    them, None, and tuples of these.
    """
    kinds: list[object] = []
    values: list[object] = []
    for argument in arguments:
        _add(argument, kinds, values)
    return tuple(kinds), values


def _add(value: Any, kinds: list[object], values: list[object]) -> None:
    """Append type and values of an argument."""
    kind = type(value)
    if kind is np.ndarray:
        _add_array(value, kinds, values)
    elif (code := NUMBERS.get(kind)) and (code != INTEGER or -LAST_INTEGER <= value < LAST_INTEGER):
        kinds.append(code)
        values.append(int(value) if code == LOGICAL else value)
    elif value is None:
        kinds.append(None)
    elif kind is Prepared:
        kinds += value.kinds
        values += value.values
    elif isinstance(value, tuple):
        kinds.append((kind, len(value)))
        for item in value:
            _add(item, kinds, values)
    else:
        raise UnknownTypeError(kind)


def _add_array(array: np.ndarray, kinds: list[object], values: list[object]) -> None:
    """Append type and values of an array."""
    flags, dtype = array.flags, array.dtype
    if dtype.char not in ITEMS or not dtype.isnative or not flags.aligned:
        raise UnknownTypeError(dtype)
    layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
    kinds.append((dtype.char, array.ndim, layout, flags.writeable))
    address = array.__array_interface__["data"][0]
    values += (address, *array.shape, *array.strides)


def value_codes(kind: Any) -> str:
    """Return the codes of the values of an argument of this type."""
    if isinstance(kind, str):
        return kind
    return "" if kind is None or len(kind) == 2 else ADDRESS + 2 * kind[1] * INTEGER


def type_text(kind: object) -> str:
    """Return a text of the type, equal in every process."""
    if isinstance(kind, tuple) and len(kind) == 2:
        return f"{kind[0].__module__}.{kind[0].__qualname__}/{kind[1]}"
    return str(kind)


class ObjectCode(NamedTuple):
    """Machine code of a kernel for arguments of certain types.

    symbol: its name in the code. arguments: codes of the values of its arguments.
    """

    symbol: str
    arguments: str
    result: Result
    code: bytes


def encoded(code: ObjectCode, identity: dict[str, object]) -> bytes:
    """Return the content of a file of object code.

    It is a digest of the remainder, a line with the identity, and the code.
    """
    header = identity | {"symbol": code.symbol, "result": code.result}
    content = json.dumps(header).encode() + b"\n" + code.code
    return hashlib.sha256(content).digest() + content


def decoded(content: bytes, identity: dict[str, object]) -> ObjectCode | None:
    """Return the object code of a file's content.

    The result is None where the content is damaged or has another identity.
    """
    digest, content = content[:32], content[32:]
    header, _, code = content.partition(b"\n")
    if hashlib.sha256(content).digest() != digest or len(header) > LONGEST_HEADER:
        return None
    try:
        fields = json.loads(header)
        decoded_code = ObjectCode(fields.pop("symbol"), str(identity["values"]), fields.pop("result"), code)
        list(_codes(decoded_code.result)), _reader(decoded_code.result)
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None
    return decoded_code if fields == identity else None


@functools.cache
def machine() -> dict[str, object]:
    """Return processor, versions and settings on which machine code depends."""
    from importlib.metadata import version

    llvm = llvm_library()
    return {
        "processor": [llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()],
        "versions": {"llvmlite": version("llvmlite"), "python": sys.version},
        "settings": [CHECK_INDICES] if checks_indices() else [],
    }


def checks_indices() -> bool:
    """Return True if kernels are to check indices."""
    return bool(os.environ.get(CHECK_INDICES))


def load_code(code: ObjectCode) -> Bind:
    """Load object code and return the function that binds its arguments."""
    llvm, engine = llvm_library(), _engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(code.code))
    engine.finalize_object()
    if not (address := engine.get_function_address(code.symbol)):
        raise LookupError(code.symbol)
    function = ctypes.CFUNCTYPE(None, ctypes.c_char_p, ctypes.c_char_p)(address)
    numbers, read = _layout("".join(_codes(code.result))), _reader(code.result)
    arguments = _layout(code.arguments)

    def bind(values: list[object]) -> Callable[[], object]:
        packed = arguments.pack(*values)

        def call() -> object:
            # A result of this call alone, as other threads may call too.
            result = ctypes.create_string_buffer(numbers.size)
            function(result, packed)
            return read(iter(numbers.unpack_from(result)))

        return call

    return bind


def _layout(codes: str) -> struct.Struct:
    """Return the layout of values, each of eight bytes."""
    return struct.Struct(codes.replace(LOGICAL, INTEGER))


def _codes(result: Result) -> Iterator[str]:
    """Yield the codes of the numbers of a result.

    Raises LookupError for others.
    """
    if isinstance(result, list):
        for item in result[2:]:
            yield from _codes(item)
    elif result is not None:
        CODES[result]
        yield result


def _reader(result: Result) -> Callable[[Iterator[Any]], object]:
    """Return the function that makes a result of its numbers."""
    if result is None:
        return lambda numbers: None
    if result == LOGICAL:
        return lambda numbers: bool(next(numbers))
    if not isinstance(result, list):
        return next
    items = [_reader(item) for item in result[2:]]
    names, module = str(result[1]).split("."), sys.modules[str(result[0])]  # nothing is imported for a name
    kind: Any = functools.reduce(lambda owner, name: vars(owner)[name], names, module)
    make = kind if kind is tuple else kind._make
    return lambda numbers: make([read(numbers) for read in items])


@functools.cache
def llvm_library() -> ModuleType:
    """Return llvmlite's interface to LLVM, initialised."""
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding


def new_target(speed: int) -> "TargetMachine":
    """Return LLVM's description of this machine.

    speed: level of optimisation from 0 to 3.
    """
    llvm = llvm_library()
    triple = llvm.get_process_triple()
    return llvm.Target.from_triple(triple).create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=speed,
        reloc="static" if triple.startswith(("x86", "i686")) else "default",
        codemodel="jitdefault",
        jit=True,
    )


@functools.cache
def _engine() -> "ExecutionEngine":
    """Return LLVM's memory for machine code."""
    llvm = llvm_library()
    module = llvm.parse_assembly(f'target triple = "{llvm.get_process_triple()}"')
    return llvm.create_mcjit_compiler(module, new_target(0))
