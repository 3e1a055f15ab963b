"""Operators and functions of numbers in kernels."""

import ast
import math
from collections.abc import Callable

import numpy as np

from machine_code.llvm_text import FAST_MATH, FunctionText
from machine_code.values import FLOAT, INTEGER, LOGICAL, RANKS, Number, integer, logical, real, refuse

Function = Callable[..., Number]

FLOAT_OPERATIONS: dict[type[ast.operator], str] = {
    ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv",
}  # fmt: skip

INTEGER_OPERATIONS: dict[type[ast.operator], tuple[str, Callable[[int, int], int]]] = {
    ast.Add: ("add nsw", int.__add__), ast.Sub: ("sub nsw", int.__sub__), ast.Mult: ("mul nsw", int.__mul__),
    ast.BitAnd: ("and", int.__and__), ast.BitOr: ("or", int.__or__), ast.LShift: ("shl", int.__lshift__),
    ast.RShift: ("ashr", int.__rshift__), ast.FloorDiv: ("", int.__floordiv__), ast.Mod: ("", int.__mod__),
}  # fmt: skip

COMPARISONS: dict[type[ast.cmpop], tuple[str, str, Callable[[float, float], bool]]] = {
    ast.Lt: ("slt", "olt", lambda a, b: a < b), ast.LtE: ("sle", "ole", lambda a, b: a <= b),
    ast.Gt: ("sgt", "ogt", lambda a, b: a > b), ast.GtE: ("sge", "oge", lambda a, b: a >= b),
    ast.Eq: ("eq", "oeq", lambda a, b: a == b), ast.NotEq: ("ne", "une", lambda a, b: a != b),
}  # fmt: skip
"""Names of comparisons of integers and of floats, and the same in Python."""

INTRINSICS = {
    "sqrt": 1,
    "sin": 1,
    "cos": 1,
    "exp": 1,
    "log": 1,
    "pow": 2,
    "fabs": 1,
    "floor": 1,
    "ceil": 1,
    "rint": 1,
}
"""Functions that LLVM has, with their numbers of arguments."""

LIBRARY = {
    "tan": 1, "asin": 1, "acos": 1, "atan": 1, "sinh": 1, "cosh": 1, "tanh": 1, "asinh": 1, "acosh": 1, "atanh": 1,
    "expm1": 1, "log1p": 1, "log2": 1, "log10": 1, "cbrt": 1, "erf": 1, "erfc": 1, "gamma": 1, "lgamma": 1,
    "atan2": 2, "hypot": 2, "copysign": 2, "fmod": 2,
}  # fmt: skip
"""Functions of the mathematics library of C."""

C_NAMES = {"gamma": "tgamma"}
"""Names of these functions in C where they differ."""

NUMPY_NAMES = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "pow": "power"} | {
    f"a{name}": f"arc{name}" for name in ("sinh", "cosh", "tanh")
}

DECLARATIONS = [
    *(
        f"declare double @llvm.{name}.f64({', '.join(['double'] * count)})"
        for name, count in INTRINSICS.items()
    ),
    *(
        f"declare double @{C_NAMES.get(name, name)}({', '.join(['double'] * count)}) #1"
        for name, count in LIBRARY.items()
    ),
]

HIGHEST_POWER = 64
"""Largest constant exponent for which a power is a row of products."""


def common_kind(*numbers: Number) -> str:
    """Return the type in which numbers are combined."""
    return max((number.kind for number in numbers), key=lambda kind: RANKS[kind])


def binary(code: FunctionText, operator: ast.operator, a: Number, b: Number) -> Number:
    """Return the result of an operator on two numbers."""
    kind = type(operator)
    if kind is ast.Pow:
        return _power(code, a, b)
    if kind is ast.Div or FLOAT in (a.kind, b.kind):
        return _of_floats(code, kind, code.converted(a, FLOAT), code.converted(b, FLOAT))
    if kind not in INTEGER_OPERATIONS:
        refuse(f"operator {kind.__name__} of integers")
    if a.kind == b.kind == LOGICAL and kind in (ast.BitAnd, ast.BitOr):
        return code.number(LOGICAL, f"{INTEGER_OPERATIONS[kind][0]} i1 {a.operand}, {b.operand}")
    return _of_integers(code, kind, code.converted(a, INTEGER), code.converted(b, INTEGER))


def _of_floats(code: FunctionText, kind: type[ast.operator], a: Number, b: Number) -> Number:
    """Return the result of an operator on numbers of double precision."""
    if kind is ast.Mod:  # with the sign of the divisor
        rest = code.number(FLOAT, f"frem double {a.operand}, {b.operand}")
        shifted = _of_floats(code, ast.Add, rest, b)
        opposite = code.number(FLOAT, f"fmul double {rest.operand}, {b.operand}")
        return select(code, compare(code, ast.Lt(), opposite, real(0.0)), shifted, rest)
    if kind is ast.FloorDiv:
        return call_intrinsic(code, "floor", _of_floats(code, ast.Div, a, b))
    if kind not in FLOAT_OPERATIONS:
        refuse(f"operator {kind.__name__} of floats")
    return code.number(FLOAT, f"{FLOAT_OPERATIONS[kind]} {FAST_MATH} double {a.operand}, {b.operand}")


def _of_integers(code: FunctionText, kind: type[ast.operator], a: Number, b: Number) -> Number:
    """Return the result of an operator on integers."""
    name, compute = INTEGER_OPERATIONS[kind]
    if isinstance(a.constant, int) and isinstance(b.constant, int) and not (name == "" and b.constant == 0):
        return integer(compute(a.constant, b.constant))
    if name:
        return code.number(INTEGER, f"{name} i64 {a.operand}, {b.operand}")
    rest = code.value(f"srem i64 {a.operand}, {b.operand}")
    other_sign = code.value(f"icmp slt i64 {code.value(f'xor i64 {rest}, {b.operand}')}, 0")
    is_lower = code.value(f"and i1 {code.value(f'icmp ne i64 {rest}, 0')}, {other_sign}")
    if kind is ast.Mod:
        return code.number(INTEGER, f"select i1 {is_lower}, i64 {code.sum(rest, b.operand)}, i64 {rest}")
    quotient = code.value(f"sdiv i64 {a.operand}, {b.operand}")
    return code.number(INTEGER, f"sub nsw i64 {quotient}, {code.value(f'zext i1 {is_lower} to i64')}")


def _power(code: FunctionText, base: Number, exponent: Number) -> Number:
    """Return a power, by products for a constant integer exponent."""
    count = exponent.constant
    if exponent.kind != INTEGER or count is None or abs(count) > HIGHEST_POWER:
        return call_intrinsic(code, "pow", base, exponent)
    result = integer(1) if base.kind == INTEGER and count >= 0 else real(1.0)
    square, bits = base, abs(int(count))
    while bits:
        if bits & 1:
            result = square if result.constant == 1 else binary(code, ast.Mult(), result, square)
        bits >>= 1
        square = binary(code, ast.Mult(), square, square) if bits else square
    return result if count >= 0 else binary(code, ast.Div(), real(1.0), result)


def unary(code: FunctionText, operator: ast.unaryop, a: Number) -> Number:
    """Return the result of an operator on one number."""
    if isinstance(operator, ast.Not):
        truth = code.truth(a)
        if truth.constant is not None:
            return logical(not truth.constant)
        return code.number(LOGICAL, f"xor i1 {truth.operand}, true")
    if isinstance(operator, ast.USub):
        if a.constant is not None:
            return real(-a.constant) if a.kind == FLOAT else integer(-int(a.constant))
        if a.kind == FLOAT:
            return code.number(FLOAT, f"fneg {FAST_MATH} double {a.operand}")
        return _of_integers(code, ast.Sub, integer(0), code.converted(a, INTEGER))
    return refuse(f"operator {type(operator).__name__}")


def compare(code: FunctionText, operator: ast.cmpop, a: Number, b: Number) -> Number:
    """Return the truth of a comparison."""
    if type(operator) not in COMPARISONS:
        refuse(f"comparison {type(operator).__name__}")
    of_integers, of_floats, compute = COMPARISONS[type(operator)]
    if a.constant is not None and b.constant is not None:
        return logical(compute(a.constant, b.constant))
    kind = FLOAT if FLOAT in (a.kind, b.kind) else INTEGER
    a, b = code.converted(a, kind), code.converted(b, kind)
    instruction = f"fcmp {FAST_MATH} {of_floats} double" if kind == FLOAT else f"icmp {of_integers} i64"
    return code.number(LOGICAL, f"{instruction} {a.operand}, {b.operand}")


def select(code: FunctionText, condition: Number, a: Number, b: Number) -> Number:
    """Return the first number where the condition holds, else the second."""
    kind = common_kind(a, b)
    a, b = code.converted(a, kind), code.converted(b, kind)
    return code.number(kind, f"select i1 {condition.operand}, {kind} {a.operand}, {kind} {b.operand}")


def call_intrinsic(code: FunctionText, name: str, *arguments: Number) -> Number:
    """Return the result of one of LLVM's own functions of floats."""
    return _call(code, f"{FAST_MATH} double @llvm.{name}.f64", arguments)


def _call(code: FunctionText, function: str, arguments: tuple[Number, ...]) -> Number:
    operands = ", ".join(f"double {code.converted(number, FLOAT).operand}" for number in arguments)
    return code.number(FLOAT, f"call {function}({operands})")


def _extreme(operator: ast.cmpop) -> Function:
    """Return a function for the least or greatest of numbers.

    As in Python, a later number replaces an earlier one where the comparison holds.
    """

    def extreme(code: FunctionText, *numbers: Number) -> Number:
        kind = common_kind(*numbers)
        result = code.converted(numbers[0], kind)
        for number in numbers[1:]:
            later = code.converted(number, kind)
            holds = compare(code, operator, later, result)
            if holds.constant is not None:
                result = later if holds.constant else result
            else:
                result = select(code, holds, later, result)
        return result

    return extreme


def _absolute(code: FunctionText, a: Number) -> Number:
    if a.kind == FLOAT:
        return call_intrinsic(code, "fabs", a)
    return select(code, compare(code, ast.Lt(), a, integer(0)), unary(code, ast.USub(), a), a)


def _truncated(code: FunctionText, a: Number) -> Number:
    if a.kind != FLOAT:
        return code.converted(a, INTEGER)
    return code.number(INTEGER, f"fptosi double {a.operand} to i64")


def _is_nan(code: FunctionText, a: Number) -> Number:
    return code.number(LOGICAL, f"fcmp uno double {code.converted(a, FLOAT).operand}, {real(0.0).operand}")


def _is_finite(code: FunctionText, a: Number) -> Number:
    size = code.value(f"call double @llvm.fabs.f64(double {code.converted(a, FLOAT).operand})")
    return code.number(LOGICAL, f"fcmp olt double {size}, {real(math.inf).operand}")


def _sign(code: FunctionText, a: Number) -> Number:
    below = select(code, compare(code, ast.Lt(), a, integer(0)), integer(-1), integer(0))
    sign = select(code, compare(code, ast.Gt(), a, integer(0)), integer(1), below)
    return code.converted(sign, a.kind)


FUNCTIONS: dict[object, Function] = {
    min: _extreme(ast.Lt()),
    max: _extreme(ast.Gt()),
    abs: _absolute,
    int: _truncated,
    np.int64: _truncated,
    float: lambda code, a: code.converted(a, FLOAT),
    bool: lambda code, a: code.truth(a),
    round: lambda code, a: _truncated(code, call_intrinsic(code, "rint", a)),
    math.floor: lambda code, a: _truncated(code, call_intrinsic(code, "floor", a)),
    math.ceil: lambda code, a: _truncated(code, call_intrinsic(code, "ceil", a)),
    np.sign: _sign,
    np.isnan: _is_nan,
    math.isnan: _is_nan,
    np.isfinite: _is_finite,
    math.isfinite: _is_finite,
}
"""Functions of numbers, by the function of Python or NumPy."""


def _register() -> None:
    """Add the functions of `math` and NumPy to `FUNCTIONS`."""
    for name, count in (INTRINSICS | LIBRARY).items():
        kind = (
            f"{FAST_MATH} double @llvm.{name}.f64"
            if name in INTRINSICS
            else f"double @{C_NAMES.get(name, name)}"
        )

        def function(code: FunctionText, *arguments: Number, kind: str = kind, count: int = count) -> Number:
            if len(arguments) != count:
                refuse(f"{len(arguments)} arguments where {count} are needed")
            return _call(code, kind, arguments)

        for source in (getattr(math, name, None), getattr(np, NUMPY_NAMES.get(name, name), None)):
            if source is not None:
                FUNCTIONS.setdefault(source, function)


_register()
