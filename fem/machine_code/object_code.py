"""Object code: written beside the layout of its arguments, loaded by llvmlite, called by ctypes.

The layout of arguments is Numba's own, numbers and addresses in a row: an array is two addresses of its owner, which
none is needed of here, its size, the size of an item, the address of the data, then shape and strides; tuples and
NamedTuples are what is in them, in turn.
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
from typing import Any, NamedTuple

import numpy as np

FLOAT, INTEGER, LOGICAL, ADDRESS = "d", "q", "b", "P"
"""Codes of the `struct` module for what a kernel takes and returns."""

NUMBERS: dict[type, str] = {
    float: FLOAT,
    np.float64: FLOAT,
    int: INTEGER,
    np.int64: INTEGER,
    bool: LOGICAL,
    np.bool_: LOGICAL,
}
LAST_INTEGER = 2**63

Call = Callable[[list[Any]], Any]
"""Calls machine code with the values of its arguments in a row."""

C_TYPES = {FLOAT: ctypes.c_double, INTEGER: ctypes.c_int64, LOGICAL: ctypes.c_int8, ADDRESS: ctypes.c_void_p}
"""C types by the code of a value."""

UNUSED = ("unpickle", "do_raise", "gil_ensure", "gil_release", "runtime_build_excinfo_struct")
"""Functions of Numba that only its errors call, with a Python object at hand; here nobody asks for that."""

HELPER = re.compile(rb"\bnumba_(\w+)")
"""Names of Numba's own functions in object code: without their addresses LLVM would end the process."""

LARGEST, LONGEST_HEADER = 2**26, 2**16
"""Bytes of a file of object code, and of its first line, at most."""


class UnknownTypeError(TypeError):
    """An argument of a type whose layout is not known here."""


class Prepared:
    """An argument laid out once for many calls; arrays in it must stay where they are."""

    def __init__(self, value: Any) -> None:
        self.value = value
        self.kinds, self.values = flattened((value,))


def flattened(arguments: tuple[Any, ...]) -> tuple[tuple[Any, ...], list[Any]]:
    """The types of the arguments, by which machine code is found, and their values in a row.

    Raises UnknownTypeError for other than floats, integers, logicals, arrays of them, None, and tuples of these.
    """
    kinds: list[Any] = []
    values: list[Any] = []
    for argument in arguments:
        _add(argument, kinds, values)
    return tuple(kinds), values


def _add(value: Any, kinds: list[Any], values: list[Any]) -> None:
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


def _add_array(array: np.ndarray, kinds: list[Any], values: list[Any]) -> None:
    flags, dtype = array.flags, array.dtype
    if dtype.kind not in "fciub" or not dtype.isnative or not flags.aligned:
        raise UnknownTypeError(dtype)
    layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
    kinds.append((dtype.char, array.ndim, layout, flags.writeable))
    address = array.__array_interface__["data"][0]
    values += (None, None, array.size, dtype.itemsize, address, *array.shape, *array.strides)


def codes(kind: Any) -> str:
    """The codes of the values of an argument of this type, in a row."""
    if kind is None:
        return ADDRESS
    if isinstance(kind, str):
        return kind
    if len(kind) == 2:
        return ""
    return 2 * ADDRESS + 2 * INTEGER + ADDRESS + 2 * kind[1] * INTEGER


def spelled(kind: Any) -> str:
    """The type in words that are the same in every process."""
    if isinstance(kind, tuple) and len(kind) == 2:
        return f"{kind[0].__module__}.{kind[0].__qualname__}/{kind[1]}"
    return str(kind)


class ObjectCode(NamedTuple):
    """Machine code of one kernel for arguments of certain types.

    symbol: its name in the code. arguments: codes of the values that it takes. result: a code, None, or a list of the
    module and name of a tuple's class and of the items' results.
    """

    symbol: str
    arguments: str
    result: Any
    code: bytes


class KernelError(RuntimeError):
    """A kernel has ended with an error, as a law from outside may raise one."""


def encoded(found: ObjectCode, identity: dict[str, Any]) -> bytes:
    """Content of a file of object code: a digest of the rest, a line that says what it is, the code."""
    header = identity | {"symbol": found.symbol, "result": found.result}
    content = json.dumps(header).encode() + b"\n" + found.code
    return hashlib.sha256(content).digest() + content


def decoded(content: bytes, identity: dict[str, Any]) -> ObjectCode | None:
    """Object code out of a file's content; None where that is not whole, or does not say that it is what is wanted."""
    digest, content = content[:32], content[32:]
    header, _, code = content.partition(b"\n")
    if hashlib.sha256(content).digest() != digest or len(header) > LONGEST_HEADER:
        return None
    try:
        said = json.loads(header)
        found = ObjectCode(said.pop("symbol"), identity["values"], said.pop("result"), code)
        _layout(found.result), _reader(found.result)
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None
    return found if said == identity else None


@functools.cache
def machine() -> dict[str, Any]:
    """The processor and the programs that code is made by and for, and their settings."""
    llvm = _llvm()
    programs = {name: version(name) for name in ("numba", "llvmlite")}
    return {
        "processor": [llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()],
        "versions": {"python": sys.version, "numpy": np.__version__, **programs},
        "settings": sorted(
            f"{k}={v}" for k, v in os.environ.items() if k.startswith("NUMBA_") and "CACHE" not in k
        ),
    }


def helpers_of(found: ObjectCode) -> set[str]:
    """Functions of Numba that the code calls, beside those that nobody asks for."""
    return {name.decode() for name in HELPER.findall(found.code)} - set(UNUSED)


def load_code(found: ObjectCode) -> Call:
    """Put the code into memory; what calls it raises KernelError if it ends with one."""
    llvm, engine = _llvm(), _engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(found.code))
    engine.finalize_object()
    kinds: list[Any] = [C_TYPES[code] for code in 2 * ADDRESS + found.arguments]
    if not (address := engine.get_function_address(found.symbol)):
        raise LookupError(found.symbol)
    function = ctypes.CFUNCTYPE(ctypes.c_int32, *kinds)(address)
    layout, read = _layout(found.result), _reader(found.result)

    def call(values: list[Any]) -> Any:
        result, error = layout(), ctypes.c_void_p()
        if status := function(ctypes.addressof(result), ctypes.addressof(error), *values):
            raise KernelError(f"{found.symbol[:60]} ended with status {status}")
        return read(result)

    return call


def _layout(result: Any) -> Any:
    """The C type of a result."""
    if isinstance(result, list):
        fields = [(f"f{i}", _layout(item)) for i, item in enumerate(result[2:])]
        return type("Result", (ctypes.Structure,), {"_fields_": fields})
    return C_TYPES[ADDRESS if result is None else result]


def _reader(result: Any) -> Callable[[Any], Any]:
    """Function that makes the Python value of a C value of this type."""
    if result is None:
        return lambda value: None
    if result == LOGICAL:
        return lambda value: bool(getattr(value, "value", value))
    if not isinstance(result, list):
        return lambda value: getattr(value, "value", value)
    items = [(f"f{i}", _reader(item)) for i, item in enumerate(result[2:])]
    names, module = result[1].split("."), sys.modules[result[0]]  # nothing is imported for a name
    kind: Any = functools.reduce(lambda owner, name: vars(owner)[name], names, module)
    make = kind if kind is tuple else kind._make
    return lambda value: make([read(getattr(value, name)) for name, read in items])


@functools.cache
def _llvm() -> Any:
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding


@functools.cache
def _engine() -> Any:
    """Memory for machine code, laid out as Numba asks for."""
    llvm = _llvm()
    _offer(llvm, {f"numba_{name}": _address(_never) for name in UNUSED})
    _offer(llvm, {f"NRT_{name}": address for name, address in _allocation().items()})
    triple = llvm.get_process_triple()
    x86 = triple.startswith(("x86", "i686"))
    target = llvm.Target.from_triple(triple).create_target_machine(
        cpu=llvm.get_host_cpu_name(), reloc="static" if x86 else "default", codemodel="jitdefault", jit=True
    )
    return llvm.create_mcjit_compiler(llvm.parse_assembly(f'target triple = "{triple}"'), target)


def _offer(llvm: Any, symbols: dict[str, int]) -> None:
    """Tell LLVM where these functions are, which Numba tells it once it is imported."""
    for name, address in symbols.items():
        if not llvm.address_of_symbol(name):
            llvm.add_symbol(name, address)


@ctypes.CFUNCTYPE(ctypes.c_void_p)
def _never() -> None:
    return None


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _allocation() -> dict[str, int]:
    """Numba's functions for memory, from its extension module: that alone does not import Numba."""
    numba = importlib.util.find_spec("numba")
    folders = numba.submodule_search_locations if numba else None
    spec = PathFinder.find_spec("_nrt_python", [str(Path(path, "core", "runtime")) for path in folders or ()])
    if spec is None:
        raise ImportError("numba.core.runtime._nrt_python")
    helpers: dict[str, int] = importlib.util.module_from_spec(spec).c_helpers
    return helpers
