"""Operators and functions of numbers in kernels."""

import ast
import math
from collections.abc import Callable

import numpy as np

from machine_code.llvm_text import FunctionText
from machine_code.values import EXACT, FLOAT, INTEGER, LOGICAL, NAMES, Number, integer, logical, real, refuse

Function = Callable[..., Number]

FLOAT_OPERATIONS: dict[type[ast.operator], str] = {
    ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv",
}  # fmt: skip

INTEGER_OPERATIONS: dict[type[ast.operator], tuple[str, Callable[[int, int], int]]] = {
    ast.Add: ("add", int.__add__), ast.Sub: ("sub", int.__sub__), ast.Mult: ("mul", int.__mul__),
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
    **dict.fromkeys(("sqrt", "sin", "cos", "exp", "log", "fabs", "floor", "ceil", "rint"), 1), "pow": 2,
}  # fmt: skip
"""Functions that LLVM has, with their numbers of arguments."""

LIBRARY = {
    "tan": 1, "asin": 1, "acos": 1, "atan": 1, "sinh": 1, "cosh": 1, "tanh": 1, "asinh": 1, "acosh": 1, "atanh": 1,
    "expm1": 1, "log1p": 1, "log2": 1, "log10": 1, "cbrt": 1, "erf": 1, "erfc": 1, "gamma": 1, "lgamma": 1,
    "atan2": 2, "hypot": 2, "copysign": 2, "fmod": 2,
}  # fmt: skip
"""Functions of the mathematics library of C."""

C_NAMES = {"gamma": "tgamma"}
"""Names of these functions in C where they differ."""

NUMPY_NAMES = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2"} | {
    f"a{name}": f"arc{name}" for name in ("sinh", "cosh", "tanh")
}

DECLARATIONS = [
    "declare i64 @llvm.fptosi.sat.i64.f64(double)",
    *(f"declare i64 @llvm.{name}.i64(i64, i64)" for name in ("smin", "smax")),
    "declare double @llvm.arithmetic.fence.f64(double)",
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
    """Return the type of numbers of which one is chosen.

    Numbers of two types are refused: Python's choice would have the type of the chosen one.
    """
    kinds = sorted({number.kind for number in numbers})
    if len(kinds) > 1:
        refuse(f"{' or '.join(NAMES[kind] for kind in kinds)}, by a choice")
    return kinds[0]


def binary(code: FunctionText, operator: ast.operator, a: Number, b: Number) -> Number:
    """Return the result of an operator on two numbers."""
    kind = type(operator)
    if a.kind == b.kind == LOGICAL and kind in (ast.BitAnd, ast.BitOr):
        return code.number(LOGICAL, f"{INTEGER_OPERATIONS[kind][0]} i1 {a.operand}, {b.operand}")
    if LOGICAL in (a.kind, b.kind):
        refuse(f"operator {kind.__name__} of {NAMES[LOGICAL]}")
    if kind is ast.Pow:
        return _power(code, a, b)
    if kind is ast.Div or FLOAT in (a.kind, b.kind):
        return _of_floats(code, kind, code.converted(a, FLOAT), code.converted(b, FLOAT))
    if kind not in INTEGER_OPERATIONS:
        refuse(f"operator {kind.__name__} of integers")
    return _of_integers(code, kind, a, b)


def _of_floats(code: FunctionText, kind: type[ast.operator], a: Number, b: Number) -> Number:
    """Return the result of an operator on numbers of double precision."""
    if kind not in FLOAT_OPERATIONS:
        refuse(f"operator {kind.__name__} of floats")
    return code.number(FLOAT, f"{FLOAT_OPERATIONS[kind]} {code.floats} double {a.operand}, {b.operand}")


def _of_integers(code: FunctionText, kind: type[ast.operator], a: Number, b: Number) -> Number:
    """Return the result of an operator on integers."""
    name, compute = INTEGER_OPERATIONS[kind]
    if kind in (ast.LShift, ast.RShift) and (b.constant is None or not 0 <= b.constant < 64):
        refuse("a shift by other than a constant from 0 to 63")
    if isinstance(a.constant, int) and isinstance(b.constant, int) and (name or b.constant):
        return integer(compute(a.constant, b.constant))
    if name:
        return code.number(INTEGER, f"{name} i64 {a.operand}, {b.operand}")
    quotient, rest = _quotient(code, a, b)
    other_sign = code.value(f"icmp slt i64 {code.value(f'xor i64 {rest}, {b.operand}')}, 0")
    is_lower = code.value(f"and i1 {code.value(f'icmp ne i64 {rest}, 0')}, {other_sign}")
    if kind is ast.Mod:
        return code.number(INTEGER, f"select i1 {is_lower}, i64 {code.sum(rest, b.operand)}, i64 {rest}")
    return code.number(INTEGER, f"sub i64 {quotient}, {code.value(f'zext i1 {is_lower} to i64')}")


def _quotient(code: FunctionText, a: Number, b: Number) -> tuple[str, str]:
    """Return quotient and rest of integers, rounded towards zero.

    The processor has no quotient by 0 and by -1 of the least integer: the product of both, as of NumPy's integers,
    without a rest.
    """
    if b.constant and b.constant != -1:
        return tuple(code.value(f"{name} i64 {a.operand}, {b.operand}") for name in ("sdiv", "srem"))  # type: ignore[return-value]
    is_odd = code.value(f"icmp ult i64 {code.value(f'add i64 {b.operand}, 1')}, 2")
    divisor = code.value(f"select i1 {is_odd}, i64 1, i64 {b.operand}")
    quotient, rest = (code.value(f"{name} i64 {a.operand}, {divisor}") for name in ("sdiv", "srem"))
    product = code.value(f"mul i64 {a.operand}, {b.operand}")
    return code.value(f"select i1 {is_odd}, i64 {product}, i64 {quotient}"), rest


def _power(code: FunctionText, base: Number, exponent: Number) -> Number:
    """Return a power, by products for a constant integer exponent."""
    count = exponent.constant
    if exponent.kind != INTEGER or count is None or abs(count) > HIGHEST_POWER:
        if base.kind == exponent.kind == INTEGER:
            refuse("an integer to a variable power")
        return call_intrinsic(code, "pow", base, exponent)
    base = code.converted(base, FLOAT) if count < 0 else base
    result = integer(1) if base.kind == INTEGER else real(1.0)
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
    if isinstance(operator, ast.USub) and a.kind != LOGICAL:
        if a.constant is not None:
            return real(-a.constant) if a.kind == FLOAT else integer(-int(a.constant))
        if a.kind == FLOAT:
            return code.number(FLOAT, f"fneg double {a.operand}")
        return _of_integers(code, ast.Sub, integer(0), a)
    return refuse(f"operator {type(operator).__name__} of {NAMES[a.kind]}")


def fenced(code: FunctionText, number: Number) -> Number:
    """Return a float whose origin the compiler does not see.

    LLVM takes min(c, min(x, c)) for min(x, c) where it knows that c is a number; of NaN these are c and NaN.
    """
    return code.number(FLOAT, f"call double @llvm.arithmetic.fence.f64(double {number.operand})")


def compare(
    code: FunctionText, operator: ast.cmpop, a: Number, b: Number, of_extreme: bool = False
) -> Number:
    """Return the truth of a comparison.

    of_extreme: its choice is fenced; otherwise a constant is.
    """
    if type(operator) not in COMPARISONS:
        refuse(f"comparison {type(operator).__name__}")
    of_integers, of_floats, compute = COMPARISONS[type(operator)]
    if a.constant is not None and b.constant is not None:
        return logical(compute(a.constant, b.constant))
    kind = FLOAT if FLOAT in (a.kind, b.kind) else INTEGER
    if kind == FLOAT and not all(number.kind == FLOAT or _is_exact(number) for number in (a, b)):
        refuse("an integer beside a float in a comparison: float(...)")
    a, b = code.converted(a, kind), code.converted(b, kind)
    if kind == FLOAT and not of_extreme:
        a, b = (number if number.constant is None else fenced(code, number) for number in (a, b))
    instruction = f"fcmp {of_floats} double" if kind == FLOAT else f"icmp {of_integers} i64"
    return code.number(LOGICAL, f"{instruction} {a.operand}, {b.operand}")


def _is_exact(number: Number) -> bool:
    """Return True for a constant that a float represents exactly."""
    return number.constant is not None and abs(number.constant) <= EXACT


def select(code: FunctionText, condition: Number, a: Number, b: Number) -> Number:
    """Return the first number where the condition holds, else the second."""
    kind = common_kind(a, b)
    return code.number(kind, f"select i1 {condition.operand}, {kind} {a.operand}, {kind} {b.operand}")


def call_intrinsic(code: FunctionText, name: str, *arguments: Number) -> Number:
    """Return the result of one of LLVM's own functions of floats."""
    return _call(code, f"{code.floats} double @llvm.{name}.f64", arguments)


def _call(code: FunctionText, function: str, arguments: tuple[Number, ...]) -> Number:
    if any(number.kind == LOGICAL for number in arguments):
        refuse(f"a function of {NAMES[LOGICAL]}")
    operands = ", ".join(f"double {code.converted(number, FLOAT).operand}" for number in arguments)
    return code.number(FLOAT, f"call {function}({operands})")


def _extreme(operator: ast.cmpop) -> Function:
    """Return a function for the least or greatest of numbers.

    As in Python, a later number replaces an earlier one where the comparison holds.
    """

    def extreme(code: FunctionText, *numbers: Number) -> Number:
        if len(numbers) < 2:
            refuse("the least or greatest of one value")
        result = numbers[0]
        for later in numbers[1:]:
            common_kind(later, result)
            holds = compare(code, operator, later, result, of_extreme=True)
            if holds.constant is not None:
                result = later if holds.constant else result
            else:
                result = select(code, holds, later, result)
                if result.kind == FLOAT:
                    result = fenced(code, result)
        return result

    return extreme


def absolute(code: FunctionText, a: Number) -> Number:
    if a.kind == FLOAT:
        return call_intrinsic(code, "fabs", a)
    if a.kind == LOGICAL:
        refuse(f"the size of {NAMES[LOGICAL]}")
    return select(code, compare(code, ast.Lt(), a, integer(0)), unary(code, ast.USub(), a), a)


def _truncated(code: FunctionText, a: Number) -> Number:
    """Return the integer towards zero.

    It is the largest one for numbers beyond 64 bits, and 0 for NaN.
    """
    if a.kind != FLOAT:
        return code.converted(a, INTEGER)
    return code.number(INTEGER, f"call i64 @llvm.fptosi.sat.i64.f64(double {a.operand})")


def _rounded(name: str) -> Function:
    """Return a function that rounds to an integer."""
    return lambda code, a: _truncated(code, call_intrinsic(code, name, a) if a.kind == FLOAT else a)


def _whole(name: str) -> Function:
    """Return a function that rounds a float to a float.

    NumPy's result for an integer is an integer, which is refused.
    """

    def whole(code: FunctionText, a: Number) -> Number:
        if a.kind != FLOAT:
            refuse(f"{name} of {NAMES[a.kind]}")
        return call_intrinsic(code, name, a)

    return whole


def _is_nan(code: FunctionText, a: Number) -> Number:
    return code.number(LOGICAL, f"fcmp uno double {code.converted(a, FLOAT).operand}, {real(0.0).operand}")


def _is_finite(code: FunctionText, a: Number) -> Number:
    size = code.value(f"call double @llvm.fabs.f64(double {code.converted(a, FLOAT).operand})")
    return code.number(LOGICAL, f"fcmp olt double {size}, {real(math.inf).operand}")


def _sign(code: FunctionText, a: Number) -> Number:
    """Return 1, 0 or -1, and NaN for NaN."""
    if a.kind == LOGICAL:
        refuse(f"the sign of {NAMES[LOGICAL]}")
    zero, one, minus = (real(float(n)) if a.kind == FLOAT else integer(n) for n in (0, 1, -1))
    result = select(code, compare(code, ast.Eq(), a, zero), zero, a)
    result = select(code, compare(code, ast.Lt(), a, zero), minus, result)
    return select(code, compare(code, ast.Gt(), a, zero), one, result)


EXTREMES: dict[object, Function] = {min: _extreme(ast.Lt()), max: _extreme(ast.Gt())}
"""Functions of any count of numbers."""

FUNCTIONS: dict[object, tuple[int, Function]] = {
    abs: (1, absolute),
    int: (1, _truncated),
    np.int64: (1, _truncated),
    float: (1, lambda code, a: code.converted(a, FLOAT)),
    bool: (1, lambda code, a: code.truth(a)),
    round: (1, _rounded("rint")),
    math.floor: (1, _rounded("floor")),
    math.ceil: (1, _rounded("ceil")),
    np.floor: (1, _whole("floor")),
    np.ceil: (1, _whole("ceil")),
    np.sign: (1, _sign),
    np.isnan: (1, _is_nan),
    math.isnan: (1, _is_nan),
    np.isfinite: (1, _is_finite),
    math.isfinite: (1, _is_finite),
}
"""Functions of numbers with their counts of arguments, by the function of Python or NumPy."""


def call_function(code: FunctionText, function: object, *numbers: Number) -> Number:
    """Return the result of a function of `FUNCTIONS` or `EXTREMES`."""
    if function in EXTREMES:
        return EXTREMES[function](code, *numbers)
    count, add = FUNCTIONS[function]
    if len(numbers) != count:
        refuse(f"{len(numbers)} arguments where {count} are needed")
    return add(code, *numbers)


def _register() -> None:
    """Add the functions of `math` and NumPy to `FUNCTIONS`."""
    for name, count in (INTRINSICS | LIBRARY).items():
        symbol = f"double @llvm.{name}.f64" if name in INTRINSICS else f"double @{C_NAMES.get(name, name)}"

        def function(code: FunctionText, *arguments: Number, symbol: str = symbol) -> Number:
            return _call(code, symbol, arguments)

        for source in (getattr(math, name, None), getattr(np, NUMPY_NAMES.get(name, name), None)):
            if source is not None:
                FUNCTIONS.setdefault(source, (count, function))


_register()
