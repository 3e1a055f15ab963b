"""Operators of complex numbers in kernels.

A complex number is a `Record` of its two parts.
"""

import ast
import math

from machine_code.arithmetic import absolute, binary, call_function, compare, select, unary
from machine_code.llvm_text import FunctionText
from machine_code.values import FLOAT, Number, Record, Value, as_number, real, refuse

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

    (a, b), (c, d) = _parts(first), _parts(second)
    if isinstance(operator, ast.Add | ast.Sub):
        return Record(complex, (binary(code, operator, a, c), binary(code, operator, b, d)))
    if isinstance(operator, ast.Mult):
        real_part = binary(code, ast.Sub(), product(a, c), product(b, d))
        return Record(complex, (real_part, binary(code, ast.Add(), product(a, d), product(b, c))))
    if not isinstance(operator, ast.Div):
        refuse(f"operator {type(operator).__name__} of complex numbers")
    return Record(complex, _quotient(code, (a, b), (c, d)))


def _quotient(code: FunctionText, first: Pair, second: Pair) -> Pair:
    """Return a quotient without squares, which may overflow (Smith 1962)."""
    a, b, c, d = (code.converted(number, FLOAT) for number in (*first, *second))
    is_swapped = compare(code, ast.Lt(), absolute(code, c), absolute(code, d))
    large, small = select(code, is_swapped, d, c), select(code, is_swapped, c, d)
    p, q = select(code, is_swapped, b, a), select(code, is_swapped, a, b)
    ratio = binary(code, ast.Div(), small, large)
    size = binary(code, ast.Add(), large, binary(code, ast.Mult(), small, ratio))
    real_part = binary(code, ast.Add(), p, binary(code, ast.Mult(), q, ratio))
    other_part = binary(code, ast.Sub(), q, binary(code, ast.Mult(), p, ratio))
    other_part = select(code, is_swapped, unary(code, ast.USub(), other_part), other_part)
    return binary(code, ast.Div(), real_part, size), binary(code, ast.Div(), other_part, size)


def negative(code: FunctionText, value: Value) -> Value:
    """Return a complex number with the opposite sign."""
    return Record(complex, tuple(unary(code, ast.USub(), part) for part in _parts(value)))


def magnitude(code: FunctionText, value: Value) -> Number:
    """Return the absolute value of a complex number."""
    return call_function(code, math.hypot, *_parts(value))
