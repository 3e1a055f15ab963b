"""Verify that compiled functions have the results of Python.

Exact: integers, truth values, and arithmetic without rounding are equal; functions of floats agree to rounding. Control
flow, variables and indices are those of random programs (`test_compiler_random.py`).
"""

import copy
import math
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from random_kernels import LINE, REFUSED, function_of

from machine_code.compiled import Kernel, by_law, chosen, compact, compiled, implements, inlined
from machine_code.object_code import UnknownTypeError
from machine_code.values import Array, TranslationError

pytestmark = pytest.mark.usefixtures("keeping")

ROTATION, TURNED, HUGE = 0.6 + 0.8j, 2.0j, 1e200 - 3e200j


class Spring(NamedTuple):
    """Constants of a linear spring."""

    stiffness: float
    force: float = 2.0


class Dashpot(NamedTuple):
    """Constants of a dashpot."""

    damping: float


class Part(NamedTuple):
    """Constants, an optional part and a row."""

    spring: Spring
    extra: Any
    row: np.ndarray


def integers(a, b):
    """Operators of integers, whose division rounds down."""
    shifted = (a & 12) >> 1
    return a // b, a % b, a + b, a - b, a * b, -a, abs(b), min(a, b, 3), max(a, b, -2), shifted, a**3


def floats(x, y):
    """Operators of floats."""
    return (
        x + y,
        x - y,
        x * y,
        x / y,
        -x,
        abs(x),
        min(x, y),
        max(x, y),
        x**2,
        1.0 / x**3,
        x**-1,
    )


def mixed(i, x):
    """Integers become floats beside floats."""
    total, flag = 0.0, i > 2
    for k in range(i):
        total += k * x
    return (
        total,
        i / 2,
        i + x,
        int(flag) + 1,
        (i, x)[1],
        not flag,
        int(-x),
        float(i),
        i**-2,
        2**53 + 1 == 9007199254740992.0,
    )


def special(x, y):
    """NaN, infinity, signs of zero and errors of sums are kept."""
    total = x + y
    part = total - x
    error = (x - (total - part)) + (y - part)
    zero = x if x == 0.0 else 0.0
    signs = math.copysign(1.0, zero), math.copysign(1.0, zero + 0.0), math.copysign(1.0, -zero), np.sign(x)
    return (x + 1.0) - x, x - x, total, error, signs


def renamed(values):
    """A name has values of several types, one after the other."""
    total = 0.0
    for j in range(3):
        total += j
    i, j = 1.5, 2.5  # type: ignore[assignment]
    for k in range(2):
        w, j = 2.0 * k, j + k
        j, w = w, j  # type: ignore[assignment]
        total += 10.0 * j + w
    for j in values:
        total += j
    return total, i


def functions(x, y):
    """Functions of the mathematics library."""
    return (
        math.sqrt(x), math.sin(x), math.cos(x), math.exp(y), math.log(x), math.atan(y), math.atan2(y, x),
        math.hypot(x, y), math.tanh(y), math.expm1(y), math.log1p(x), math.floor(y), math.ceil(y), round(10.0 * y),
        math.isfinite(x), math.isnan(y), math.copysign(x, y), math.gamma(x), math.erf(y), math.pi, x**y,
        float(np.sqrt(x)), float(np.arctan2(y, x)), float(np.hypot(x, y)), bool(np.isnan(x)), float(np.sign(y)),
        float(np.floor(y)), float(np.arcsin(y / 10.0)),
    )  # fmt: skip


def numbers(x, y):
    """Complex numbers."""
    z = ROTATION * x
    z = z + y - z / (z * z + 2.0)
    z *= 1.0 + 0.5j
    turned, small = z / TURNED, 1e200 * z / HUGE
    return abs(z), z.real, (-z).imag, turned.real, turned.imag, small.real, small.imag


def records(part):
    """Fields, items, slices and lengths of tuples."""
    spring, first = part.spring, Spring(3.0)
    moved = Spring(force=1.0, stiffness=spring.stiffness)
    tail = (1, 2.0, 3)[1:]
    total = 0.0
    for i in range(len(tail)):
        total += tail[i] * part.row[-1]
    extra = 0.0 if part.extra is None else part.extra.damping
    return total, first.force + moved.force + moved.stiffness, extra, len(part), (4.0, 5.0)[-2], moved


CASES: dict[Callable[..., Any], list[tuple[Any, ...]]] = {
    integers: [
        *((7, 3), (-7, 3), (7, -3), (-7, -3), (0, 5)),
        *((np.int64(a), np.int64(b)) for a in (7, -(2**63)) for b in (0, -1)),
    ],
    floats: [(7.5, 2.0), (-7.5, 2.0), (7.5, -2.0), (-0.5, -2.0)],
    mixed: [(1, 2.0), (5, -2.5), (3, 0.0)],
    special: [(x, y) for x in (1.5, -0.0, 1e17, math.nan, math.inf, -math.inf) for y in (1.0, -0.0, 0.1)],
    renamed: [(np.array([0.5, 0.25]),)],
    functions: [(2.5, -0.75), (0.5, 1.5)],
    numbers: [(1.5, -2.0)],
    records: [(Part(Spring(4.0), extra, np.arange(3.0)),) for extra in (None, Dashpot(0.5))],
}


@pytest.mark.parametrize("function", CASES, ids=lambda function: function.__name__)
def test_results_are_those_of_python(function):
    for arguments in CASES[function]:
        result = compiled(function)(*copy.deepcopy(arguments))
        with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore"):
            same(result, function(*copy.deepcopy(arguments)))


def same(result, expected):
    """Types are equal, and numbers to rounding."""
    if isinstance(expected, float) and math.isnan(expected):
        assert math.isnan(result)
    elif isinstance(expected, tuple):
        assert type(result) is type(expected)
        for item, expected_item in zip(result, expected, strict=True):
            same(item, expected_item)
    elif isinstance(expected, float) and isinstance(result, float):
        assert result == pytest.approx(expected, rel=4e-16, abs=1e-300)
    else:
        assert float(result) == float(expected)


def write(target, source, index):
    """Parts of arrays are views."""
    rows, row = target[1:, 1:], target[0]
    rows[0, 0] = source[index, -1]
    rows[-1, :] = 2.0
    row[index:] = source[0, 1]
    part = target[:, 2]
    part[2] += 0.5 * source[1, 0]
    first, second, third = part[0], part[1], part[2]
    target[2, 0] = first + 10.0 * second + 100.0 * third + target.size + source.shape[1]
    for line in source[:2]:
        target[1, 3] += line[0]


@pytest.mark.parametrize("dtype", ["f8", "i8", "i4"])
@pytest.mark.parametrize("order", ["C", "F", "sliced"])
def test_arrays_are_those_of_python(dtype, order):
    """Of any type and layout, as source and as target."""
    source = np.arange(12).reshape(3, 4).astype(dtype)
    source = np.repeat(source, 2, axis=1)[:, ::2] if order == "sliced" else np.array(source, order=order)
    targets = [np.array(np.zeros((3, 4)), order="F" if order == "F" else "C") for _ in range(2)]
    compiled(write)(targets[0], source, 2)
    write(targets[1], source, 2)
    np.testing.assert_array_equal(targets[0], targets[1])


@pytest.mark.parametrize("dtype", ["f8", "i8", "i4", "?", "c16"])
def test_stored_numbers_have_the_type_of_the_array(dtype):
    def store(target, numbers):
        for i in range(target.size):
            target[i] = numbers[i]

    values = np.array([1.0, 0.0, 5.0]) if np.dtype(dtype).kind in "fc" else np.array([1, 0, 5])
    target = np.zeros(3, dtype=dtype)
    compiled(store)(target, values)
    np.testing.assert_array_equal(target, values.astype(dtype))


def test_functions_are_chosen_by_the_types_of_arguments():
    """By constants of a law, types of parts, and values."""

    class Laws:
        def by_type(self, kind):
            return {Spring: SpringLaw, Dashpot: DashpotLaw}.get(kind)

    class SpringLaw:
        inlined = ()
        force = staticmethod(lambda law, x: -law.stiffness * x)

    class DashpotLaw:
        inlined = ("force",)
        force = staticmethod(lambda law, x: law.damping * x)

    force = by_law(Laws(), "force")

    def energy(law, x):
        raise NotImplementedError

    @implements(energy, Spring, merged=True)
    def _(law, x):
        return 0.5 * law.stiffness * x * x

    def item(values, i):
        raise NotImplementedError

    @chosen(item)
    def _item(values, i):
        return (lambda values, i: values[i]) if isinstance(values, Array) else (lambda values, i: values)

    def use(law, extra, values, x):
        return force(law, x), energy(extra, x), item(values, 1) + item(x, 1)

    kernel = compiled(use)
    assert kernel(Spring(3.0), Spring(2.0), np.array([1.0, 5.0]), 2.0) == (-6.0, 4.0, 7.0)
    assert kernel(Dashpot(3.0), Spring(4.0), np.array([1.0, 5.0]), 2.0) == (6.0, 8.0, 7.0)
    with pytest.raises(TranslationError, match="a call of force"):
        kernel(Part(Spring(1.0), None, np.zeros(1)), None, np.zeros(2), 2.0)


@pytest.mark.parametrize("decorate", [compiled, compact, inlined])
def test_compiled_functions_call_each_other(decorate):
    """Merged or not, a function has its own variables."""

    @decorate
    def add(values, x):
        total = x
        for value in values:
            total += value
        return total

    def twice(values, x):
        total = 100.0
        x = add(values, x) + add(values, total)
        return x, total

    values = np.arange(4.0)
    assert compiled(twice)(values, 1.0) == (113.0, 100.0)


@pytest.mark.parametrize("statement", REFUSED)
def test_what_a_kernel_cannot_have_is_named_with_its_line(statement):
    kernel = function_of(f"def kernel(n, x, a):\n    {statement}\n    late = x\n    return x * late\n")
    with pytest.raises(TranslationError, match=REFUSED[statement]) as caught:
        Kernel(kernel)(2, 1.5, np.arange(3.0))
    assert LINE.match(str(caught.value))


@pytest.mark.parametrize(("text", "message"), [
    ("def kernel(n):\n    if n > 1:\n        return 1.0\n", "an end of kernel without return"),
    ("def kernel(n, *x):\n    return n\n", "parameters with defaults, by name alone, or in any number"),
])  # fmt: skip
def test_a_function_that_cannot_be_a_kernel_is_named_with_its_line(text, message):
    with pytest.raises(TranslationError, match=message) as caught:
        Kernel(function_of(text))(2)
    assert LINE.match(str(caught.value))


@pytest.mark.parametrize("dtype", ["f4", "i2", "i1", "u1", "u8", "f2"])
def test_arrays_of_numbers_with_another_arithmetic_are_refused(dtype):
    with pytest.raises(UnknownTypeError):
        compiled(write)(np.zeros((3, 4)), np.zeros((3, 4), dtype), 2)


def test_a_function_without_source_is_refused():
    names: dict[str, Any] = {"__name__": "unknown"}
    exec("def unknown(x):\n    return x\n", names)
    with pytest.raises(TranslationError, match="the source of unknown is not available"):
        compiled(names["unknown"])(1.0)


def test_lambdas_in_a_line_are_told_apart():
    """Also those with variables of their surroundings."""
    factor = 3.0
    twice, thrice = (lambda x: 2.0 * x), (lambda x: factor * x)
    assert (compiled(twice)(5.0), compiled(thrice)(5.0)) == (10.0, 15.0)


INDEXED = """
import numpy as np
from machine_code.compiled import compiled

@compiled
def read(values, i, end):
    total = values[i]
    for value in values[i:end]:
        total += value
    return total

print(read(np.arange(5.0), {i}, {end}))
"""


@pytest.mark.parametrize(("i", "end", "checks", "printed"), [
    (2, 5, "1", "11.0"), (5, 5, "1", ""), (-6, 5, "1", ""), (-1, 6, "1", "8.0"), (3, 2, "1", "3.0"), (2, 5, "", "11.0"),
])  # fmt: skip
def test_an_index_outside_an_array_ends_the_process_if_checked(tmp_path, python, i, end, checks, printed):
    """SIGILL or SIGTRAP, by processor."""
    (tmp_path / "indexed.py").write_text(INDEXED.format(i=i, end=end))
    process = python("import indexed", cwd=tmp_path, env={"PATH": "", "TAILSLAP_CHECK_INDICES": checks})
    assert process.returncode in ((0,) if printed else (-4, -5))
    assert process.stdout.strip() == printed


def least_again(x):
    """The least of a number and the least of two."""
    return min(-1.5, min(x, -1.5)), max(2.0, max(x, 2.0))


def least_by_expressions(x):
    """The same as a choice of two values."""
    least = 1.0 if x > 1.0 else x
    return least if least < 1.0 else 1.0


def least_by_statements(x):
    """The same as two conditions."""
    least, result = x, 1.0
    if least > 1.0:
        least = 1.0
    if least < 1.0:
        result = least
    return result


@pytest.mark.parametrize("function", [least_again, least_by_expressions, least_by_statements])
@pytest.mark.parametrize("x", [math.nan, -9.0, 0.5, 7.0, math.inf])
def test_the_least_with_a_constant_twice_is_that_of_python(function, x):
    """LLVM drops the second comparison, which matters for NaN."""
    assert repr(Kernel(function)(x)) == repr(function(x))
