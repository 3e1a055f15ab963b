"""WebAssembly of kernels, and the memory of their arguments.

LLVM's object file is a module but for its exports, so that no linker is needed. A module imports its memory, a stack
pointer and functions of mathematics. Addresses have 32 bits, in slots of eight bytes as those of `object_code`.
"""

import functools
import hashlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from machine_code.compiled import Kernel, implementation_of
from machine_code.object_code import ADDRESS, FLOAT, LARGEST, flattened, llvm_library, type_text, value_codes
from machine_code.system import folder

if TYPE_CHECKING:
    from llvmlite.binding import TargetMachine

TRIPLE = "wasm32-unknown-unknown"
FEATURES = "+bulk-memory,+nontrapping-fptoint,+sign-ext,+mutable-globals"
"""Instructions beyond the first version, in all browsers since 2021."""

FUNCTIONS = f"""
target triple = "{TRIPLE}"
declare double @llvm.fabs.f64(double)
declare double @llvm.exp.f64(double)
declare double @llvm.copysign.f64(double, double)
define double @tanh(double %x) {{
  %size = call double @llvm.fabs.f64(double %x)
  %twice = fmul double %size, -2.0
  %power = call double @llvm.exp.f64(double %twice)
  %above = fsub double 1.0, %power
  %below = fadd double 1.0, %power
  %ratio = fdiv double %above, %below
  %result = call double @llvm.copysign.f64(double %ratio, double %x)
  ret double %result
}}
"""
"""tanh to 2e-16 of 1, since browsers compute its exponential without a call of JavaScript."""

HEADER = b"\0asm\1\0\0\0"
CUSTOM, IMPORT, EXPORT, CODE = 0, 2, 7, 10
"""Numbers of sections of a module."""

SYMBOL_TABLE, UNDEFINED, EXPLICIT_NAME = 8, 0x10, 0x40
"""Part of the linking section, and flags of its symbols."""

DIGEST = "digest"
"""Name of the section with the digest of the kernels."""

PAGE = 65536
"""Unit of memory [bytes]."""

STACK = PAGE
"""Memory of the stack, below all arguments [bytes]."""

Calls = Mapping[str, tuple[Kernel, tuple[object, ...]]]
"""Kernels with examples of their arguments, by the names under which a module exports them."""


@functools.cache
def target() -> "TargetMachine":
    """Return LLVM's description of WebAssembly."""
    llvm = llvm_library()
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    return llvm.Target.from_triple(TRIPLE).create_target_machine(features=FEATURES, opt=3, reloc="static")


def digest_of(calls: Calls) -> str:
    """Return the digest of all on which a module depends."""
    from importlib.metadata import version

    texts = [version("llvmlite"), folder.own_sources("machine_code")]
    for name, (kernel, arguments) in calls.items():
        kinds = flattened(arguments)[0]
        texts += [name, kernel._captured(kinds).digest, *map(type_text, kinds)]
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()


def module(calls: Calls) -> bytes:
    """Return the module of kernels, each for arguments of these types.

    It is kept beside the compiled code of this machine. An exported function takes the addresses of its result and of
    the values of its arguments, as in `object_code`.
    """
    from machine_code import llvm_code

    digest = digest_of(calls)
    path = folder.cache_folder() / f"{digest[:20]}.wasm"
    mark = _section(CUSTOM, _text(DIGEST) + digest.encode())
    code = folder.read(path, LARGEST)
    if code.startswith(HEADER) and code.endswith(mark):
        return code
    kernels = {
        name: (kernel.implementation, flattened(arguments)[0]) for name, (kernel, arguments) in calls.items()
    }
    code = exported(llvm_code.object_file(kernels, implementation_of, target(), FUNCTIONS), kernels) + mark
    with suppress(OSError):
        folder.write(path, code)
    return code


def exported(code: bytes, names: Iterable[str]) -> bytes:
    """Return an object file as a module that exports these functions.

    Sections for a linker are left out.
    """
    sections = list(_sections(code))
    linking = next(body for kind, body in sections if kind == CUSTOM and _Reader(body).text() == "linking")
    place = _functions(linking, _imported_names(next(body for kind, body in sections if kind == IMPORT)))
    entries = [_text(name) + b"\0" + _number(place[name]) for name in names]
    parts = [HEADER]
    for kind, body in sections:
        if kind >= CODE and not any(part[:1] == bytes([EXPORT]) for part in parts):
            parts.append(_section(EXPORT, _number(len(entries)) + b"".join(entries)))
        if kind != CUSTOM:
            parts.append(_section(kind, body))
    return b"".join(parts)


class _Reader:
    """Bytes of a module that are read in turn."""

    def __init__(self, code: bytes, place: int = 0) -> None:
        self.code, self.place = code, place

    def number(self) -> int:
        """Return the next number (LEB128)."""
        value = shift = 0
        while True:
            byte = self.code[self.place]
            self.place += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    def bytes(self, count: int) -> bytes:
        self.place += count
        return self.code[self.place - count : self.place]

    def text(self) -> str:
        return self.bytes(self.number()).decode()


def _sections(code: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield numbers and contents of sections."""
    reader = _Reader(code, len(HEADER))
    while reader.place < len(code):
        kind = reader.number()
        yield kind, reader.bytes(reader.number())


def _imported_names(body: bytes) -> list[str]:
    """Return the names of the imported functions in their order."""
    reader, names = _Reader(body), list[str]()
    for _ in range(reader.number()):
        reader.text()
        name, kind = reader.text(), reader.number()
        if kind == 0:  # a function, by its type
            names.append(name)
            reader.number()
        elif kind == 3:  # a global, its type and whether it varies
            reader.bytes(2)
        else:  # a table, after its type of items, or a memory: limits
            reader.bytes(1 if kind == 1 else 0)
            for _ in range(1 + (reader.number() & 1)):
                reader.number()
    return names


def _functions(linking: bytes, imported: list[str]) -> dict[str, int]:
    """Return the numbers of the functions that the symbol table names."""
    reader, places = _Reader(linking), dict[str, int]()
    reader.text()
    reader.number()  # version
    while reader.place < len(linking):
        kind, size = reader.number(), reader.number()
        end = reader.place + size
        for _ in range(reader.number() if kind == SYMBOL_TABLE else 0):
            symbol, flags = reader.number(), reader.number()
            is_named = not flags & UNDEFINED or bool(flags & EXPLICIT_NAME)
            if symbol == 1:  # data
                name = reader.text()
                for _ in range(0 if flags & UNDEFINED else 3):
                    reader.number()
            elif symbol == 3:  # a section
                reader.number()
            else:
                place = reader.number()
                name = reader.text() if is_named else ""
                if symbol == 0:
                    places[name or imported[place]] = place
        reader.place = end
    return places


def _number(value: int) -> bytes:
    """Return a number in LEB128."""
    coded = bytearray()
    while value > 0x7F:
        coded.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*coded, value])


def _text(text: str) -> bytes:
    return _number(len(text.encode())) + text.encode()


def _section(kind: int, body: bytes) -> bytes:
    return bytes([kind]) + _number(len(body)) + body


class Place(NamedTuple):
    """Array in the memory of a module.

    at: address; slot: address of its shape among the arguments; content: its bytes, empty if all are zero.
    """

    at: int
    kind: str
    shape: tuple[int, ...]
    slot: int
    content: bytes


class Layout(NamedTuple):
    """Memory of the arguments of kernels.

    calls: addresses of the result and of the arguments, by name. arrays: by kernel, parameter and fields, as
    "solve.train.mass". slots: address and content of all arguments. size: end of the memory [bytes].
    """

    calls: dict[str, tuple[int, int]]
    arrays: dict[str, Place]
    slots: list[tuple[int, bytes]]
    size: int


def layout(calls: Calls, results: int = 64) -> Layout:
    """Lay out the arguments of kernels in the memory of a module.

    Arrays that several kernels have are the same there. results: room for the numbers of a result.
    """
    end, places, arrays = STACK, dict[int, int](), dict[str, Place]()
    addresses, slots = dict[str, tuple[int, int]](), list[tuple[int, bytes]]()
    for name, (kernel, arguments) in calls.items():
        parameters = kernel.py_func.__code__.co_varnames
        named = [
            array
            for parameter, argument in zip(parameters, arguments, strict=False)
            for array in _named_arrays(f"{name}.{parameter}", argument)
        ]
        for _, array in named:
            if id(array) not in places:
                places[id(array)] = end
                end += -(-max(array.nbytes, 1) // 16) * 16
        kinds, values = flattened(arguments)
        codes = "".join(map(value_codes, kinds))
        addresses[name], place, arrays_left = (end, end + 8 * results), end + 8 * results, iter(named)
        row = bytearray()
        for code, value in zip(codes, values, strict=True):
            if code == ADDRESS:
                path, array = next(arrays_left)
                content = array.tobytes() if array.any() else b""
                arrays.setdefault(
                    path,
                    Place(places[id(array)], array.dtype.char, array.shape, place + len(row) + 8, content),
                )
                value = places[id(array)]
            row += np.array(value, dtype="<f8" if code == FLOAT else "<i8").tobytes()
        slots.append((place, bytes(row)))
        end = place + -(-len(row) // 16) * 16
    return Layout(addresses, arrays, slots, end)


def _named_arrays(name: str, value: object) -> Iterator[tuple[str, Any]]:
    """Yield the arrays of an argument by names of fields."""
    if isinstance(value, np.ndarray):
        yield name, value
    elif isinstance(value, tuple):
        fields = getattr(value, "_fields", range(len(value)))
        for field, item in zip(fields, value, strict=True):
            yield from _named_arrays(f"{name}.{field}", item)
