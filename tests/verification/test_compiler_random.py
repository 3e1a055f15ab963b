"""Verify compiled functions on random programs, against Python.

Exact: all numbers are multiples of 1/4 of few digits.
"""

import linecache
import random
from typing import Any

import pytest

from machine_code import folder
from machine_code.compiled import Kernel
from machine_code.values import TranslationError

NAMES, VALUES = "abcde", ("i", "x", "0", "1", "2", "0.5", "-1.25", "n")
INPUTS = ((0, 0.25), (2, -1.5), (3, 2.75))
COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")


class Program:
    """Source of a random function of an integer and a float."""

    def __init__(self, seed: int) -> None:
        self.random, self.count = random.Random(seed), 0

    def text(self) -> str:
        """Return the source."""
        lines = ["def program(n, x):", "    i = 0"]
        lines += [f"    {name} = {self.random.choice(('0', '0.5', 'n', 'x'))}" for name in NAMES[:3]]
        return "\n".join([*lines, *self.block(1, False, 6), "    return a, b, c, i"]) + "\n"

    def block(self, depth: int, is_loop: bool, most: int) -> list[str]:
        """Return the lines of a block."""
        lines = [line for _ in range(self.random.randint(1, most)) for line in self.statement(depth, is_loop)]
        if self.random.random() < 0.6:
            value = self.random.choice(VALUES)
            lines = [f"{'    ' * depth}{self.random.choice(('d = e =', 'e = d ='))} {value}", *lines]
        return lines

    def statement(self, depth: int, is_loop: bool) -> list[str]:
        """Return the lines of a statement."""
        indent, name = "    " * depth, self.random.choice(NAMES)
        kind = self.random.choices(
            ("assign", "add", "swap", "if", "for", "over", "while", "jump"), (6, 4, 1, 3, 2, 1, 1, 1)
        )[0]
        if kind in ("assign", "add") or depth > 3 or (kind == "jump" and not is_loop):
            value = f"min(max({self.expression(2)}, -999), 999)"
            if kind == "assign":
                return [f"{indent}{name} = {value}"]
            return [f"{indent}{name} += {value}", f"{indent}{name} = max(min({name}, 999), -999)"]
        if kind == "swap":
            return [f"{indent}a, {name} = {self.expression(1)}, a"]
        if kind == "jump":
            jump = self.random.choice(("break", "continue"))
            return [f"{indent}if {self.condition()}:", f"{indent}    {jump}"]
        if kind == "if":
            lines = [f"{indent}if {self.condition()}:", *self.block(depth + 1, is_loop, 3)]
            if self.random.random() < 0.5:
                lines += [f"{indent}else:", *self.block(depth + 1, is_loop, 3)]
            return lines
        if kind == "while":
            self.count += 1
            counter = f"k{self.count}"
            head = [f"{indent}{counter} = 0", f"{indent}while {counter} < 3 and ({self.condition()}):"]
            return [*head, f"{indent}    {counter} += 1", *self.block(depth + 1, True, 3)]
        target = self.random.choice(("i", "i", name))
        values = self.random.choice(("range(2)", "range(n)", "range(3, 0, -1)"))
        if kind == "over":
            values = "(0.25, 1.5)" if self.random.random() < 0.5 else "(1, 2, 3)"
        return [f"{indent}for {target} in {values}:", *self.block(depth + 1, True, 3)]

    def expression(self, depth: int) -> str:
        """Return an expression of numbers."""
        if depth == 0 or self.random.random() < 0.3:
            return self.random.choice((*3 * NAMES[:3], *NAMES, *VALUES))
        first, second = self.expression(depth - 1), self.expression(depth - 1)
        form = self.random.choice(
            ("({} + {})", "({} - {})", "min({}, {})", "max({}, {})", "({} * 0.5 - {})", "choice")
        )
        return (
            f"({first} if {self.condition()} else {second})"
            if form == "choice"
            else form.format(first, second)
        )

    def condition(self) -> str:
        """Return a condition."""
        names = (*NAMES[:3], *VALUES)
        simple = [" ".join(map(self.random.choice, (names, COMPARISONS, VALUES))) for _ in range(2)]
        return self.random.choice(
            ("{0}", "not {0}", "{0} and {1}", "{0} or {1}", "not ({0} and {1})")
        ).format(*simple)


def check(seed: int) -> bool:
    """Compare a program with Python.

    Returns False for one that uses a variable without a value.
    """
    text, name = Program(seed).text(), f"<program {seed}>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
    module: dict[str, Any] = {"__name__": "program"}
    exec(compile(text, name, "exec"), module)
    kernel = Kernel(module["program"])
    try:
        expected = [module["program"](n, x) for n, x in INPUTS]
    except NameError:
        return False
    try:
        results = [kernel(n, x) for n, x in INPUTS]
    except TranslationError:  # it is assigned further down
        return False
    assert results == expected, text
    return True


@pytest.mark.parametrize("first", [0, 100_000])
def test_random_programs_have_the_results_of_python(first, tmp_path, monkeypatch):
    monkeypatch.setattr(folder, "cache_folder", lambda: tmp_path / "code")
    assert sum(map(check, range(first, first + 60))) > 20


@pytest.mark.long
def test_many_random_programs_have_the_results_of_python(tmp_path, monkeypatch):
    """The programs are others than those of the short test."""
    monkeypatch.setattr(folder, "cache_folder", lambda: tmp_path / "code")
    assert sum(map(check, range(1_000, 4_000))) > 1_000
