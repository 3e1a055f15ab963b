"""Object code on disk, loaded by llvmlite and called by ctypes.

It is stored with the layout of its arguments, which is Numba's own: numbers and addresses in a row. An array is two
addresses of its owner, which are not needed here, its size, the size of an item, the address of the data, then shape
and strides. Tuples and NamedTuples are their items in turn.
"""

import ctypes
import functools
import hashlib
import importlib.util
import json
import os
import re
import sys
from collections.abc import Callable
from importlib.machinery import PathFinder
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from llvmlite.binding import ExecutionEngine

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

Call = Callable[[list[object]], object]
"""Call of machine code with the values of its arguments in a row."""

C_TYPES = {FLOAT: ctypes.c_double, INTEGER: ctypes.c_int64, LOGICAL: ctypes.c_int8, ADDRESS: ctypes.c_void_p}
"""C types by the code of a value."""

UNUSED = ("unpickle", "do_raise", "gil_ensure", "gil_release", "runtime_build_excinfo_struct")
"""Functions of Numba that only its errors call, with a Python object.

No kernel raises such errors.
"""

HELPER = re.compile(rb"\bnumba_(\w+)")
"""Names of Numba's own functions in object code.

Without their addresses LLVM would end the process.
"""

SETTING = re.compile("NUMBA_(?!CACHE|NUM_THREADS)")
"""Environment variables that change the code.

Workers of a sweep have one thread and run the code of other commands.
"""

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
        values.append(value)
    elif value is None:
        kinds.append(None)
        values.append(None)
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
    if dtype.kind not in "fciub" or not dtype.isnative or not flags.aligned:
        raise UnknownTypeError(dtype)
    layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
    kinds.append((dtype.char, array.ndim, layout, flags.writeable))
    address = array.__array_interface__["data"][0]
    values += (None, None, array.size, dtype.itemsize, address, *array.shape, *array.strides)


def value_codes(kind: Any) -> str:
    """Return the codes of the values of an argument of this type."""
    if kind is None:
        return ADDRESS
    if isinstance(kind, str):
        return kind
    if len(kind) == 2:
        return ""
    return 2 * ADDRESS + 2 * INTEGER + ADDRESS + 2 * kind[1] * INTEGER


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


class KernelError(RuntimeError):
    """Error within a kernel or a registered law."""


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
        _layout(decoded_code.result), _reader(decoded_code.result)
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None
    return decoded_code if fields == identity else None


@functools.cache
def machine() -> dict[str, object]:
    """Return processor, versions and settings on which machine code depends."""
    llvm = _llvm()
    programs = {name: version(name) for name in ("numba", "llvmlite")}
    return {
        "processor": [llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()],
        "versions": {"python": sys.version, "numpy": np.__version__, **programs},
        "settings": sorted(f"{k}={v}" for k, v in os.environ.items() if SETTING.match(k)),
    }


def helpers_of(code: ObjectCode) -> set[str]:
    """Return the functions of Numba that the code needs."""
    return {name.decode() for name in HELPER.findall(code.code)} - set(UNUSED)


def load_code(code: ObjectCode) -> Call:
    """Load object code and return its call.

    The call raises KernelError if the kernel ends with an error.
    """
    llvm, engine = _llvm(), _engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(code.code))
    engine.finalize_object()
    kinds: list[Any] = [C_TYPES[code] for code in 2 * ADDRESS + code.arguments]
    if not (address := engine.get_function_address(code.symbol)):
        raise LookupError(code.symbol)
    function = ctypes.CFUNCTYPE(ctypes.c_int32, *kinds)(address)
    layout, read = _layout(code.result), _reader(code.result)

    def call(values: list[object]) -> object:
        result, error = layout(), ctypes.c_void_p()
        if status := function(ctypes.addressof(result), ctypes.addressof(error), *values):
            raise KernelError(f"{code.symbol[:60]} ended with status {status}")
        return read(result)

    return call


def _layout(result: Result) -> Any:
    """Return the C type of a result."""
    if isinstance(result, list):
        fields = [(f"f{i}", _layout(item)) for i, item in enumerate(result[2:])]
        return type("Result", (ctypes.Structure,), {"_fields_": fields})
    return C_TYPES[ADDRESS if result is None else result]


def _reader(result: Result) -> Callable[[object], object]:
    """Return the conversion of C values of a type to Python."""
    if result is None:
        return lambda value: None
    if result == LOGICAL:
        return lambda value: bool(getattr(value, "value", value))
    if not isinstance(result, list):
        return lambda value: getattr(value, "value", value)
    items = [(f"f{i}", _reader(item)) for i, item in enumerate(result[2:])]
    names, module = str(result[1]).split("."), sys.modules[str(result[0])]  # nothing is imported for a name
    kind: Any = functools.reduce(lambda owner, name: vars(owner)[name], names, module)
    make = kind if kind is tuple else kind._make
    return lambda value: make([read(getattr(value, name)) for name, read in items])


@functools.cache
def _llvm() -> ModuleType:
    """Return llvmlite's interface to LLVM, initialised."""
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding


@functools.cache
def _engine() -> "ExecutionEngine":
    """Return LLVM's memory for machine code, with the layout that Numba needs."""
    llvm = _llvm()
    _register_symbols(llvm, {f"numba_{name}": _address(_stand_in) for name in UNUSED})
    _register_symbols(llvm, {f"NRT_{name}": address for name, address in _allocation().items()})
    triple = llvm.get_process_triple()
    x86 = triple.startswith(("x86", "i686"))
    target = llvm.Target.from_triple(triple).create_target_machine(
        cpu=llvm.get_host_cpu_name(), reloc="static" if x86 else "default", codemodel="jitdefault", jit=True
    )
    return llvm.create_mcjit_compiler(llvm.parse_assembly(f'target triple = "{triple}"'), target)


def _register_symbols(llvm: ModuleType, symbols: dict[str, int]) -> None:
    """Register the addresses of functions with LLVM.

    Numba registers its own once it is imported.
    """
    for name, address in symbols.items():
        if not llvm.address_of_symbol(name):
            llvm.add_symbol(name, address)


@ctypes.CFUNCTYPE(ctypes.c_void_p)
def _stand_in() -> None:
    """Stand in for functions that are not called."""
    return None


def _address(function: Any) -> int:
    """Return the address of a C function."""
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _allocation() -> dict[str, int]:
    """Return the addresses of Numba's functions for memory.

    They are in an extension module, which does not import Numba.
    """
    numba = importlib.util.find_spec("numba")
    folders = numba.submodule_search_locations if numba else None
    spec = PathFinder.find_spec("_nrt_python", [str(Path(path, "core", "runtime")) for path in folders or ()])
    if spec is None:
        raise ImportError("numba.core.runtime._nrt_python")
    helpers: dict[str, int] = importlib.util.module_from_spec(spec).c_helpers
    return helpers
