"""Parts and items of arrays in kernels."""

from machine_code.complex_numbers import is_complex
from machine_code.llvm_text import FunctionText
from machine_code.values import (
    FLOAT,
    INTEGER,
    ITEMS,
    LOGICAL,
    Array,
    Number,
    Record,
    Value,
    as_number,
    real,
    refuse,
)

Index = Number | tuple[Number | None, Number | None]
"""Number of an item, or the first one of a slice and the one behind its last."""


def part_of(code: FunctionText, array: Array, indices: list[Index]) -> Array:
    """Return the part of an array at these first indices.

    One item is an array without dimensions. A check ends the process at an index outside, if the function has checks.
    """
    if len(indices) > len(array.shape):
        refuse(f"{len(indices)} indices of an array with {len(array.shape)} dimensions")
    offset = "0"
    shape: list[str] = []
    strides: list[str] = []
    for index, size, stride in zip(indices, array.shape, array.strides, strict=False):
        if isinstance(index, Number):
            begin = place_in(code, index, size)
        else:
            begin, length = _bounds(code, *index, size)
            shape.append(length)
            strides.append(stride)
        offset = code.sum(offset, code.product(begin, stride))
    data = array.data if offset == "0" else code.item(array.data, ITEMS[array.item], offset)
    rest = len(indices)
    return Array(array.item, data, (*shape, *array.shape[rest:]), (*strides, *array.strides[rest:]))


def place_in(code: FunctionText, index: Number, size: str) -> str:
    """Return the place of an item.

    A negative index counts from the end. A check ends the process at an index outside, if the function has checks.
    """
    place = _from_end(code, index, size)
    code.check(f"icmp ult i64 {place}, {size}")
    return place


def _bounds(code: FunctionText, lower: Number | None, upper: Number | None, size: str) -> tuple[str, str]:
    """Return the first index of a slice and its length.

    A slice ends with the array.
    """
    begin = "0" if lower is None else _clipped(code, lower, size)
    end = size
    if upper is not None:
        end = code.value(f"call i64 @llvm.smin.i64(i64 {_clipped(code, upper, size)}, i64 {size})")
    if begin == "0":
        return begin, end
    length = code.whole("sub", end, begin)
    return begin, code.value(f"call i64 @llvm.smax.i64(i64 {length}, i64 0)")


def _clipped(code: FunctionText, bound: Number, size: str) -> str:
    """Return a bound of a slice that is not negative."""
    place = _from_end(code, bound, size)
    return place if place == bound.operand else code.value(f"call i64 @llvm.smax.i64(i64 {place}, i64 0)")


def _from_end(code: FunctionText, index: Number, size: str) -> str:
    """Return an index, a negative one counted from the end."""
    if index.constant is not None:
        return code.whole("add", size, str(index.constant)) if index.constant < 0 else index.operand
    is_negative = code.value(f"icmp slt i64 {index.operand}, 0")
    return code.value(
        f"select i1 {is_negative}, i64 {code.whole('add', index.operand, size)}, i64 {index.operand}"
    )


def load(code: FunctionText, array: Array, *indices: str) -> Value:
    """Return the part or the number at these first indices."""
    part = part_of(code, array, [Number(INTEGER, index) for index in indices])
    return part if part.shape else load_item(code, part)


def load_item(code: FunctionText, array: Array) -> Value:
    """Return the number in an array without dimensions."""
    kind = ITEMS[array.item]
    if array.item == "D":
        second = code.item(array.data, FLOAT, "1")
        parts = (code.number(FLOAT, f"load double, ptr {place}") for place in (array.data, second))
        return Record(complex, tuple(parts))
    operand = code.value(f"load {kind}, ptr {array.data}")
    if array.item == "?":
        return code.number(LOGICAL, f"trunc i8 {operand} to i1")
    if kind in (FLOAT, INTEGER):
        return Number(kind, operand)
    return code.number(INTEGER, f"sext {kind} {operand} to i64")


def store_item(code: FunctionText, array: Array, value: Value) -> None:
    """Store a number in an array without dimensions."""
    kind = ITEMS[array.item]
    if array.item == "D":
        parts = value.items if isinstance(value, Record) and is_complex(value) else (value, real(0.0))
        for place, part in enumerate(parts):
            operand = code.converted(as_number(part), FLOAT).operand
            code.add(f"store double {operand}, ptr {code.item(array.data, FLOAT, str(place))}")
        return
    number = as_number(value)
    if array.item == "?":
        operand = code.value(f"zext i1 {code.truth(number).operand} to i8")
    elif kind == FLOAT:
        operand = code.converted(number, FLOAT).operand
    else:
        operand = code.converted(number, INTEGER).operand
        operand = operand if kind == INTEGER else code.value(f"trunc i64 {operand} to {kind}")
    code.add(f"store {kind} {operand}, ptr {array.data}")


def fill(code: FunctionText, array: Array, value: Value) -> None:
    """Store a number in all items of an array."""
    with code.loop("0", array.shape[0]) as (i, _, _):
        part = part_of(code, array, [Number(INTEGER, i)])
        (fill if part.shape else store_item)(code, part, value)
