"""Object code: written beside the layout of its arguments, loaded by llvmlite, called by ctypes."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import importlib.util
import json
import os
import re
import tempfile
from collections.abc import Callable
from contextlib import suppress
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from fem.machine_code.arguments import ADDRESS, FLOAT, INTEGER, LOGICAL

C_TYPES = {FLOAT: ctypes.c_double, INTEGER: ctypes.c_int64, LOGICAL: ctypes.c_int8, ADDRESS: ctypes.c_void_p}
"""C types by the code of a value."""

UNUSED = ("unpickle", "do_raise", "gil_ensure", "gil_release", "runtime_build_excinfo_struct")
"""Functions of Numba that only its errors call, with a Python object at hand; here nobody asks for that."""

HELPER = re.compile(rb"\bnumba_(\w+)")
"""Names of Numba's own functions in object code: without their addresses LLVM would end the process."""

Call = Callable[[list[Any]], Any]
"""Calls machine code with the values of its arguments in a row."""


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


def write_code(path: Path, found: ObjectCode) -> None:
    """Write object code to a file, whole or not at all; a folder or disk that cannot take it is no error."""
    content = json.dumps(found[:-1]).encode() + b"\n" + found.code
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=".")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(hashlib.sha256(content).digest() + content)
            os.replace(name, path)
        except OSError:
            os.unlink(name)


def read_code(path: Path) -> ObjectCode | None:
    """Object code that was written to a file; None where there is none, or none that is whole."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, content = content[:32], content[32:]
    if hashlib.sha256(content).digest() != digest:
        return None
    layout, _, code = content.partition(b"\n")
    symbol, arguments, result = json.loads(layout)
    return ObjectCode(symbol, arguments, result, code)


@functools.cache
def machine() -> str:
    """The processor and the programs that code is made by and for, and their settings."""
    llvm = _llvm()
    settings = sorted(
        f"{k}={v}" for k, v in os.environ.items() if k.startswith("NUMBA_") and "CACHE" not in k
    )
    programs = [f"{name} {version(name)}" for name in ("numba", "llvmlite")]
    return "|".join([llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(), *programs, *settings])


def helpers_of(found: ObjectCode) -> set[str]:
    """Functions of Numba that the code calls, beside those that nobody asks for."""
    return {name.decode() for name in HELPER.findall(found.code)} - set(UNUSED)


def load_code(found: ObjectCode) -> Call:
    """Put the code into memory; what calls it raises KernelError if it ends with one."""
    llvm, engine = _llvm(), _engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(found.code))
    engine.finalize_object()
    kinds: list[Any] = [C_TYPES[code] for code in 2 * ADDRESS + found.arguments]
    function = ctypes.CFUNCTYPE(ctypes.c_int32, *kinds)(engine.get_function_address(found.symbol))
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
    return C_TYPES[result or ADDRESS]


def _reader(result: Any) -> Callable[[Any], Any]:
    """Function that makes the Python value of a C value of this type."""
    if result is None:
        return lambda value: None
    if result == LOGICAL:
        return lambda value: bool(getattr(value, "value", value))
    if not isinstance(result, list):
        return lambda value: getattr(value, "value", value)
    kind = functools.reduce(getattr, result[1].split("."), importlib.import_module(result[0]))
    items = [(f"f{i}", _reader(item)) for i, item in enumerate(result[2:])]
    make: Any = kind if kind is tuple else kind._make
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
    assert numba
    folder = Path((numba.submodule_search_locations or [""])[0], "core", "runtime")
    path = next(p for end in EXTENSION_SUFFIXES if (p := folder / f"_nrt_python{end}").exists())
    spec = importlib.util.spec_from_file_location("_nrt_python", path)
    assert spec
    helpers: dict[str, int] = importlib.util.module_from_spec(spec).c_helpers
    return helpers
