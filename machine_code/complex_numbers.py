"""Operators of complex numbers in kernels.

A complex number is a `Record` of its two parts.
"""

import ast
import math

from machine_code.arithmetic import FUNCTIONS, binary, unary
from machine_code.llvm_text import FunctionText
from machine_code.values import Number, Record, Value, as_number, real, refuse

Pair = tuple[Number, Number]


def is_complex(value: Value) -> bool:
    """Return True for a complex number."""
    return isinstance(value, Record) and value.kind is complex


def _parts(value: Value) -> Pair:
    """Return real and imaginary part of a number."""
    if isinstance(value, Number):
        return value, real(0.0)
    if not isinstance(value, Record) or value.kind is not complex:
        refuse("a complex number together with another value")
    first, second = map(as_number, value.items)
    return first, second


def complex_binary(code: FunctionText, operator: ast.operator, first: Value, second: Value) -> Value:
    """Return the result of an operator where a number is complex."""

    def product(a: Number, b: Number) -> Number:
        return binary(code, ast.Mult(), a, b)

    def combined(operation: ast.operator, a: Number, b: Number) -> Number:
        return binary(code, operation, a, b)

    (a, b), (c, d) = _parts(first), _parts(second)
    if isinstance(operator, ast.Add | ast.Sub):
        return Record(complex, (combined(operator, a, c), combined(operator, b, d)))
    if isinstance(operator, ast.Mult):
        real_part = combined(ast.Sub(), product(a, c), product(b, d))
        return Record(complex, (real_part, combined(ast.Add(), product(a, d), product(b, c))))
    if not isinstance(operator, ast.Div):
        refuse(f"operator {type(operator).__name__} of complex numbers")
    size = combined(ast.Add(), product(c, c), product(d, d))
    parts = (
        combined(ast.Add(), product(a, c), product(b, d)),
        combined(ast.Sub(), product(b, c), product(a, d)),
    )
    return Record(complex, tuple(combined(ast.Div(), part, size) for part in parts))


def negative(code: FunctionText, value: Value) -> Value:
    """Return a complex number with the opposite sign."""
    return Record(complex, tuple(unary(code, ast.USub(), part) for part in _parts(value)))


def magnitude(code: FunctionText, value: Value) -> Number:
    """Return the absolute value of a complex number."""
    return FUNCTIONS[math.hypot](code, *_parts(value))
