"""Random kernels compared with Python, and statements outside of their language.

    .venv/bin/python tests/verification/random_kernels.py [--kernels 2000] [--outside 200] [--first 0]

Exact: all numbers are multiples of powers of 1/2 of few digits, or NaN or infinite, so that no result is rounded.
Results have the same type and sign of zero, and arrays the same content. Programs that raise in Python are omitted,
and signs of NaN, which no rule determines.
"""

import linecache
import math
import random
import re
import sys
import tempfile
import warnings
from collections import Counter
from typing import Any, NamedTuple

import numpy as np

from machine_code.compiled import Kernel
from machine_code.system import folder
from machine_code.values import TranslationError

LINE = re.compile(r"(<kernel -?\d+>|.*random_kernels\.py):[1-9]\d*: a kernel cannot have ")
"""Beginning of an error."""

REFUSED = {
    "x = [x]": r"\[x\]",
    "x = np.zeros(3)": "a call of np.zeros",
    "x = x + nowhere": "the name nowhere",
    "x = x.total": "the attribute total",
    "x = math.nothing": "the attribute nothing",
    "x = a[x]": "a float as an index: x",
    "x = a[n > 1]": "a truth value as an index",
    "x = (1.0, 2.0) if n > 1 else 1.0": "tuple of a float, a float or a float, by a condition",
    "x = 1 if n > 1 else 2.0": "an integer or a float, by a condition",
    "x = max(n, x)": "a float or an integer, by a choice",
    "x = max(x)": "the least or greatest of one value",
    "if n > 1: n = 1.0\n    late = n": "n, which is an integer and a float",
    "if n > 1: x = n > 1\n    late = x": "x, which is a float and a truth value",
    "x = n == 'text'": "Known where a number is needed",
    "x = math.hypot(x)": "1 arguments where 2 are needed",
    "n = round(x, 2)": "2 arguments where 1 are needed",
    "n = len(a, a)": "a call of len",
    "x = (1.0, 2.0)[2]": "item 2 of 2",
    "x = x // 2.0": "operator FloorDiv of floats",
    "x = x % 2.0": "operator Mod of floats",
    "n = n << n": "a shift by other than a constant from 0 to 63",
    "n = 1 << 64": "a shift by other than a constant from 0 to 63",
    "n = 2**n": "an integer to a variable power",
    "n = 2**63": "the integer 9223372036854775808, beyond 64 bits",
    "n = -9223372036854775809": "the integer 9223372036854775809, beyond 64 bits",
    "n = n ^ 3": "operator BitXor of integers",
    "n = ~n": "operator Invert of an integer",
    "n = (n > 1) + n": "operator Add of a truth value",
    "n = -(n > 1)": "operator USub of a truth value",
    "x = abs(n > 1)": "the size of a truth value",
    "x = math.sqrt(n > 1)": "a function of a truth value",
    "n = n or 7": "the value of `and` or `or` for an integer: n",
    "x = x and 2.0": "the value of `and` or `or` for a float: x",
    "x = 1.0 if n < x else 2.0": "an integer beside a float in a comparison",
    "x = 1.0 if 2**53 + 1 == x else 2.0": "an integer beside a float in a comparison",
    "x = 1.0 if 0 < n < a.size else 2.0": "a chain of comparisons with more than names",
    "x = 1.0 if n in (1, 2) == True else 2.0": "Record where a number is needed",
    "x = 1.0 if x in (1.0, x) else 2.0": "`in` of a float",
    "x = 1.0 if n is True else 2.0": "`is` with other than None",
    "x, n = a": "an assignment of an array, whose length may vary, to 2 variables",
    "x = y": "the name y",
    "x = late": "the variable late, which may have no value here",
    "if n > 1: y = x\n    x = y": "the variable y, which may have no value here",
    "for y in a: pass\n    x = y": "the variable y, which may have no value here",
    "for k in range(3):\n        if k > 0: x = y\n        y = x": "the variable y, which may have no value here",
    "while n < 9: n += 1\n    else: x = 7.0": "else of a loop",
    "for k in range(3): n += 1\n    else: x = 7.0": "else of a loop",
    "for k in range(0, 9, n): x = 7.0": "a range with a variable step",
    "if n > 1: return": "the result, which is None and a float|the result, which is a float and None",
    "assert x > 0.0": "Assert statement",
    "del x": "Delete statement",
    "global x_of_all": "Global statement",
    "x: float = 2.0": "AnnAssign statement",
    "with x: pass": "With statement",
    "raise ValueError": "Raise statement",
    "import math": "Import statement",
    "def inner(): pass": "FunctionDef statement",
    "match n:\n        case 1: x = 2.0": "Match statement",
    "x = (n := 2) * x": "n := 2",
    "x = sum(a)": "a call of sum",
    "x = print(x)": "a call of print",
    "x = max(*(x, 2.0))": r"\*\(x, 2.0\)",
    "x = recursive(x)": "recursive, which calls itself",
    "x = [1.0][0]": "an item of|1.0",
    "x = f'{x}'": "f'{x}'",
    "x = (lambda: 1.0)()": "lambda: 1.0",
    "x.real = 1.0": "an assignment to x.real",
    "x.real += 1.0": "an operation on x.real",
    "[x, n] = (x, n)": r"an assignment to \[x, n\]",
    "a[:] += 1.0": "an operation on a part of an array",
    "x = a[::2][0]": "a slice with a step",
    "x = a + 1.0": "Array where a number is needed",
    "x = None + 1.0": "Nothing where a number is needed",
    "x = 1.0 if a else 2.0": "Array where a number is needed",
    "a[0] = None": "Nothing where a number is needed",
    "n = int(a)": "Array where a number is needed",
}  # fmt: skip
"""Statements that a kernel of an integer n, a float x and an array a cannot have, with the reasons."""


def recursive(x):
    """Call itself."""
    return recursive(x - 1.0) if x > 0.0 else x


def function_of(text):
    """Return the function `kernel` of a text, as of a file."""
    name = f"<kernel {hash(text)}>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
    module: dict[str, Any] = {"__name__": "program", "np": np, "math": math, "recursive": recursive}
    exec(compile(text, name, "exec"), module)
    return module["kernel"]


class Law(NamedTuple):
    """Record of a number and of an optional part."""

    stiffness: float
    part: Any


INPUTS = (
    (0, 0.25, True, Law(2.0, None)),
    (3, -1.5, False, Law(0.5, 1.0)),
    (-2, math.nan, True, Law(4.0, None)),
    (5, math.inf, False, Law(-0.0, None)),
)
HELPERS = """
def shift(a, x):
    a[0] += min(max(x, -9.0), 9.0)
    return a[0] * 0.5
def pair(n, x):
    if n > 2:
        return n - 1, x
    return n + 1, 0.5 * x
def least(values):
    result = math.inf
    for value in values:
        if value < result:
            result = value
    return result
"""
LEAVES = {
    "float": "x|f|g|t[1]|t[-1]|law.stiffness|0.0|0.25|-1.25|2.0|w[1, 2]|a[{place 4}]|w[{place 2}, {place 3}]"
    "|t[{place 3}]",
    "integer": "n|i|j|0|1|-3|5|len(a)|a.size|w.shape[1]|len(t)|v[{place 3}]",
    "truth": "p|q|f < g|n > 1|law.part is None|law.part is not None|x == 0.25|i in (1, 2, 5)|math.isnan(x)",
    "bounded": "min(max({float}, -999.0), 999.0)",
    "whole": "min(max({integer}, -999), 999)",
    "place 2": "0|1|-1|-2|i % 2|j % 4 - 2|v[1] % 2",
    "place 3": "0|1|-1|-3|i % 3|j % 6 - 3|v[1] % 3",
    "place 4": "0|1|3|-1|-4|i % 4|j % 8 - 4|v[1] % 4|{integer} % 4",
    "slice": "{bound}:{bound}",
    "bound": "||1|-1|2|n|i|-i|9|-9|i % 5",
    "compared": "<|<=|>|>=|==|!=",
    "divisor": "{integer}|({integer} % 4 + 1)|-({integer} % 3 + 1)|3|-2",
}
"""Forms of expressions without others, apart by bars; names in braces are forms again."""
FORMS = {
    "float": "({float} + {float})|({float} - {float})|({float} * 0.5 - {float})|min({float}, {float})|-({float})"
    "|max({float}, {float})|abs({float})|({float} if {truth} else {float})|float({integer})|({float} + {integer})"
    "|{float} / 4.0|{integer} / 4|min({float}, {float}, 3.0)|shift(a, {float})"
    "|math.copysign({float}, max(-999.0, {float}))|np.floor({float})"
    "|law.stiffness if law.part is None else law.part|float(np.sign({float}))"
    "|(({float} + {float}) - {float})",
    "integer": "({integer} + {integer})|({integer} - {integer})|({integer} * {integer}) % 999|{integer} // {divisor}"
    "|{integer} % {divisor}|(({integer}) % 99 << 2)|({integer} >> 1)|({integer} & {integer})|({integer} or_ {integer})"
    "|abs({integer})|min({integer}, {integer})|max({integer}, {integer})|({integer} if {truth} else {integer})"
    "|({integer} % 7) ** 2|-({integer})|int({bounded})|round({bounded})|math.floor({bounded})|int({truth})"
    "|len(a[{slice}])",
    "truth": "{float} {compared} {float}|{integer} {compared} {integer}|{float} < 2|f {compared} g {compared} x"
    "|{integer} in (1, 2, 5)|math.isnan({float})|math.isfinite({float})|p == q|bool({integer})|i < {integer} <= n"
    "|not ({truth})|({truth}) and ({truth})|({truth}) or ({truth})|(({truth}) & ({truth}))|({truth} if {truth} else p)",
}
"""Forms of expressions with others."""
STATEMENTS = """
{x} = {bounded}|{n} = {whole}|{p} = {truth}|f = g = {bounded}|f += {bounded};f = {limited}|i -= {whole};i = i % 99
a[0] += shift(a, {float})|a[{place 4}] -= {bounded}|v[{place 3}] += {whole};v[{place 3}] = {whole}
a[{place 4}] = {bounded}|v[{place 3}] = {whole}|w[{place 2}, {place 3}] = {bounded}|a[{slice}] = {bounded}
w[{place 2}] = {bounded}|w[{place 2}, {slice}] = {bounded}|f, g = {bounded}, f|f, x, g = t|i, f = pair(i, {bounded})
i, a[{place 4}] = {whole}, {bounded}|a[0], a[1] = a[1], a[0]|i, (f, g) = 1, (f, x)|f = shift(a[{slice}], {float})
g = least(a[{slice}])|shift(w[1], f)|t = (f, t[0], t[2])|w[0] = 0.5|x = law.part if law.part is not None else x
"""
"""Statements, apart by bars or lines; semicolons part those of one line."""
HEADS = """
if {truth}:|if {truth}:|if {truth}:|for k in range(3):|for i in range(n):|for j in range(len(t)):|for i in range(1, n):
for k in range(n, -2, -2):|for f in a:|for f in a[{slice}]:|for i in v:|for g in t:|for i, f in ((1, 0.5), (2, -0.25)):
for i in (3, 1):|for f in w[1]:|for row in w:;    g = row[1]|for a[1] in t:|while True:|while {truth}:
"""


class Program:
    """Source of a random kernel `kernel(n, x, p, law, a, v, w)`.

    n, i, j: integers; x, f, g: floats; p, q: truth values; law: record; t: tuple of floats; a, v, w: arrays of four
    floats, of three integers, and of two by three floats.
    """

    def __init__(self, seed: int) -> None:
        self.random, self.count, self.size = random.Random(seed), 0, 0

    def text(self, statement: str = "pass") -> str:
        """Return the source, with a statement at its beginning."""
        head = ["i, j, f, g, q = 1, -2, 0.5, x, False", "t = (0.25, x, -1.5)", statement]
        body = "\n".join(f"    {line}" for line in [*head, *self.block(False, 5), "late = x"])
        result = "    return n, i, j, x, f, g, p, q, late"
        return f"def kernel(n, x, p, law, a, v, w):\n{body}\n{result}{HELPERS}"

    def one_of(self, forms: str) -> str:
        """Return one of forms apart by bars or lines."""
        return self.random.choice(forms.strip("\n").replace("\n", "|").split("|"))

    def expanded(self, form: str, depth: int = 2) -> str:
        """Return a form with an expression for each name in braces."""

        def expression(name: re.Match[str]) -> str:
            names = {"x": "x|f|g", "n": "n|i|j", "p": "p|q", "limited": "max(min(f, 999.0), -999.0)"}
            forms = FORMS.get(name[1]) if depth > 0 and self.random.random() < 0.7 else None
            return self.expanded(
                self.one_of(forms or LEAVES.get(name[1]) or names[name[1]]), depth - (forms is not None)
            )

        return re.sub(r"\{(\w+( \d)?)\}", expression, form).replace("or_", "|")

    def block(self, is_loop: bool, most: int) -> list[str]:
        """Return the lines of a block."""
        return [line for _ in range(self.random.randint(1, most)) for line in self.statement(is_loop)]

    def statement(self, is_loop: bool) -> list[str]:
        """Return the lines of a statement."""
        kind = self.random.random()
        if kind < 0.65 or self.count > 5:
            return self.expanded(self.one_of(STATEMENTS)).split(";")
        if kind < 0.7:
            return [
                self.expanded("if {truth}:"),
                self.expanded("    return n, i, j, {float}, f, g, p, q, 0.5"),
            ]
        if kind < 0.74:
            return [self.expanded("if {truth}:"), "    d = f", self.one_of("x = d|pass|pass")]
        if kind < 0.8 and is_loop:
            return [self.expanded("if {truth}:"), f"    {self.one_of('break|continue')}"]
        return self.nested(self.expanded(self.one_of(HEADS)).split(";"), is_loop)

    def nested(self, head: list[str], is_loop: bool) -> list[str]:
        """Return a branch or a loop of this head."""
        self.count += 1
        counter = f"k{self.count}"
        if head[0].startswith("while"):  # ends after three turns
            turns = [f"    {counter} += 1", f"    if {counter} > 3:", "        break"]
            return [f"{counter} = 0", *head, *turns, *self.inner(True)]
        lines = [*head, *self.inner(is_loop or head[0].startswith("for"))]
        if head[0].startswith("if") and self.random.random() < 0.5:
            lines += (
                [self.expanded("elif {truth}:"), *self.inner(is_loop)] if self.random.random() < 0.3 else []
            )
            lines += ["else:", *self.inner(is_loop)]
        return lines

    def inner(self, is_loop: bool) -> list[str]:
        """Return the lines of a block within a statement."""
        return [f"    {line}" for line in self.block(is_loop, 2)]


def outcome(function: Any, values: tuple[Any, ...]) -> str:
    """Return results of a call with types and signs of zeros."""
    arrays = (
        np.array([1.0, -0.5, 2.0, 4.0]),
        np.array([2, -1, 3]),
        np.array([[0.5, 1.0, -2.0], [3.0, 0.25, -0.0]]),
    )
    results = function(*values, *arrays)
    kinds = ((bool, np.bool_), (int, np.integer), (float, np.floating))
    plain = [
        next(kind for kind, other in kinds if isinstance(value, (kind, other)))(value) for value in results
    ]
    return repr((plain, [array.tolist() for array in arrays]))


def check(seed: int) -> str:
    """Compare a kernel with Python.

    Returns "same", "refused", or "raises" for an error of Python. A difference raises AssertionError.
    """
    text = Program(seed).text()
    program = function_of(text)
    kernel, expected = Kernel(program), []
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        for values in INPUTS:
            try:
                expected.append(outcome(program, values))
            except (IndexError, ZeroDivisionError, ValueError, OverflowError):
                expected.append("")
            except NameError:
                expected.append("unassigned")
    if "" in expected and set(expected) <= {"", "unassigned"}:
        return "raises"
    verdict = "same"
    for values, result in zip(INPUTS, expected, strict=True):
        try:
            is_same = not result or outcome(kernel, values) == result
        except TranslationError as error:
            is_same, verdict = LINE.match(str(error)) is not None, "refused"
        if not is_same:
            raise AssertionError(f"seed {seed}, {values}:\n{text}")
    return verdict


def check_outside(seed: int) -> str:
    """Compile a kernel with a statement outside of the language.

    Raises AssertionError if it is not refused with its line.
    """
    statement = random.Random(seed).choice(list(REFUSED))
    kernel = Kernel(function_of(Program(seed).text(statement)))
    try:
        outcome(kernel, INPUTS[0])
    except TranslationError as error:
        if LINE.match(str(error)):
            return "refused"
    raise AssertionError(f"seed {seed}: {statement} is not refused")


def main() -> int:
    """Print how many kernels are the same, refused, or raise in Python."""
    options = dict(zip(sys.argv[1::2], map(int, sys.argv[2::2]), strict=True))
    first, count = options.get("--first", 0), options.get("--kernels", 2000)
    outcomes: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as place:
        folder.cache_folder = lambda: folder.Path(place, "code")
        for what, function, number in (
            ("", check, count),
            ("outside ", check_outside, options.get("--outside", 200)),
        ):
            for seed in range(first, first + number):
                try:
                    outcomes[what + function(seed)] += 1
                except AssertionError as error:
                    outcomes[what + "DIFFERENT"] += 1
                    print(error)
    print(", ".join(f"{what} {number}" for what, number in sorted(outcomes.items())))
    return int(any("DIFFERENT" in what for what in outcomes))


if __name__ == "__main__":
    sys.exit(main())
