"""Machine code of a kernel, made by LLVM."""

import functools
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from machine_code import arithmetic
from machine_code.expressions import Arguments
from machine_code.llvm_text import FunctionText
from machine_code.object_code import (
    CODES,
    Kinds,
    ObjectCode,
    Result,
    UnknownTypeError,
    checks_indices,
    llvm_library,
    new_target,
    value_codes,
)
from machine_code.statements import METADATA
from machine_code.translate import Resolve, Translation
from machine_code.values import LOGICAL, NOTHING, Array, Implementation, Nothing, Number, Record, Value

if TYPE_CHECKING:
    from llvmlite.binding import ModuleRef, TargetMachine

SPEED = 3
"""LLVM's level of optimisation."""

TYPES = {"d": "double", "q": "i64", "b": "i64", "P": "ptr"}
"""LLVM's types by the codes of arguments."""

ATTRIBUTES = ("attributes #0 = { nounwind }", "attributes #1 = { nounwind willreturn memory(none) }")
"""Properties of the program's functions, and of those of the mathematics library."""


def compile_kernel(kernel: Implementation, kinds: Kinds, resolve: Resolve, symbol: str) -> ObjectCode:
    """Return the machine code of a kernel for arguments of these types.

    resolve: see `machine_code.translate.Resolve`. symbol: name of the code, which must be another for other code of
    the process. Raises TranslationError, and UnknownTypeError for a result that is not of numbers.
    """
    translation = Translation(resolve, kernel.is_compact, checks_indices())
    result = _translate(translation, kernel, kinds, symbol)
    codes = "".join(map(value_codes, kinds))
    machine_code = target().emit_object(_optimised(translation, target()))
    return ObjectCode(symbol, codes, _result_of(result), machine_code)


def assembly(kernel: Implementation, kinds: Kinds, resolve: Resolve) -> str:
    """Return the text of the machine code.

    Arguments as of `compile_kernel`.
    """
    translation = Translation(resolve, kernel.is_compact, checks_indices())
    _translate(translation, kernel, kinds, "kernel")
    text: str = target().emit_assembly(_optimised(translation, target()))
    return text


def object_file(
    kernels: Mapping[str, tuple[Implementation, Kinds]],
    resolve: Resolve,
    machine: "TargetMachine",
    further: str,
) -> bytes:
    """Return one object file of kernels by symbol, for another machine.

    Functions that several kernels call are there once. further: functions that it has in place of imported ones, in
    LLVM's language.
    """
    is_compact = all(kernel.is_compact for kernel, _ in kernels.values())
    translation = Translation(resolve, is_compact, checks_indices())
    for symbol, (kernel, kinds) in kernels.items():
        _translate(translation, kernel, kinds, symbol)
    module = _optimised(translation, machine)
    module.link_in(llvm_library().parse_assembly(further))
    code: bytes = machine.emit_object(module)
    return code


def _translate(translation: Translation, kernel: Implementation, kinds: Kinds, symbol: str) -> Value:
    """Translate a kernel to LLVM's language, and return its result."""
    codes = "".join(map(value_codes, kinds))

    def read(code: FunctionText) -> Arguments:
        places = [code.item("%arguments", "i64", str(n)) for n in range(len(codes))]
        loads = zip(codes, places, strict=True)
        operands = [
            code.value(f"load {TYPES[value]}, ptr {place}, !invariant.load !{{}}") for value, place in loads
        ]
        return _arguments(iter(kinds), iter(operands), code)

    return translation.kernel(kernel, symbol, read)


def _arguments(kinds: Iterator[Any], operands: Iterator[str], code: FunctionText) -> Arguments:
    """Return the arguments of a kernel, all that remain."""
    return tuple(_argument(kind, kinds, operands, code) for kind in kinds)


def _argument(kind: Any, kinds: Iterator[Any], operands: Iterator[str], code: FunctionText) -> Value:
    if kind is None:
        return NOTHING
    if isinstance(kind, str):
        operand = next(operands)
        number = CODES[kind]
        return Number(number, code.value(f"trunc i64 {operand} to i1") if number == LOGICAL else operand)
    if len(kind) == 2:
        return Record(kind[0], tuple(_argument(next(kinds), kinds, operands, code) for _ in range(kind[1])))
    item, dimensions, layout, _ = kind
    data, *sizes = (next(operands) for _ in range(1 + 2 * dimensions))
    shape = tuple(sizes[:dimensions])
    strides: list[str] = []
    for axis in reversed(range(dimensions)):
        if layout == "C":
            strides.append(code.product(shape[axis + 1], strides[-1]) if strides else "1")
        else:
            size = np.dtype(item).itemsize
            strides.append(code.value(f"sdiv exact i64 {sizes[dimensions + axis]}, {size}"))
    return Array(item, data, shape, tuple(reversed(strides)))


def _result_of(value: Value) -> Result:
    """Return the type of a result."""
    if isinstance(value, Nothing):
        return None
    if isinstance(value, Number):
        return next(code for code, kind in CODES.items() if kind == value.kind)
    if isinstance(value, Record):
        return [value.kind.__module__, value.kind.__qualname__, *map(_result_of, value.items)]
    raise UnknownTypeError(f"a kernel cannot return {value}")


def _optimised(translation: Translation, machine: "TargetMachine") -> "ModuleRef":
    """Return LLVM's module of a kernel, optimised for a machine."""
    llvm = llvm_library()
    declarations = [*arithmetic.DECLARATIONS, "declare void @llvm.trap()", *sorted(translation.declarations)]
    module = llvm.parse_assembly("\n".join([*declarations, *translation.texts, METADATA, *ATTRIBUTES]))
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=SPEED)
    options.loop_vectorization, options.slp_vectorization = True, False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return module


@functools.cache
def target() -> "TargetMachine":
    """Return the machine for which code is made."""
    return new_target(SPEED)
