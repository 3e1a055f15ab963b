"""Verify that linter, formatter and type checker pass, and tests assert."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("tailslap", "solver", "meshes", "machine_code", "fem", "postprocess")
ASSERTING = re.compile(r"assert|raises$|warns$|fail$")


def called_names(nodes):
    """Return the names of the functions that are called."""
    functions = [node.func for node in nodes if isinstance(node, ast.Call)]
    return {f.attr if isinstance(f, ast.Attribute) else getattr(f, "id", "") for f in functions}


def without_assertion(trees):
    """Test functions without an assertion, of their own or called."""
    functions = [f for tree in trees for f in ast.walk(tree) if isinstance(f, ast.FunctionDef)]
    nodes = {id(f): [*ast.walk(f)] for f in functions}
    calls = {id(f): called_names(nodes[id(f)]) for f in functions}
    asserting = {f.name for f in functions if any(isinstance(node, ast.Assert) for node in nodes[id(f)])}
    asserting |= {f.name for f in functions if any(map(ASSERTING.search, calls[id(f)]))}
    silent = [f for f in functions if f.name.startswith("test_") and f.name not in asserting]
    return [f.name for f in silent if not calls[id(f)] & asserting]


def test_each_test_asserts_something():
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in (ROOT / "tests").rglob("*.py")]
    assert without_assertion(trees) == []


def test_files_with_long_tests_are_listed_with_the_reason():
    listed = re.findall(
        r"`(test_\w+\.py)`", (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("| reason")[2]
    )
    texts = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("test_*.py")}
    long = [name for name, text in texts.items() if re.search(r"pytest\.mark\.long\b", text)]
    assert sorted(listed) == sorted(long)


def test_a_test_that_asserts_nothing_is_noticed():
    code = """
def demand(x):
    assert x
def test_of_words():
    "Nothing but words."
def test_of_a_call():
    print("words")
def test_by_a_helper():
    demand(3)
def test_of_an_error():
    with pytest.raises(ValueError):
        float("x")
"""
    assert without_assertion([ast.parse(code)]) == ["test_of_words", "test_of_a_call"]


@pytest.mark.parametrize("command", [
    ("ruff", "check", "."), ("ruff", "format", "--check", "."), ("mypy", *PACKAGES),
    pytest.param(("mypy",), marks=pytest.mark.long),
])  # fmt: skip
def test_sources_are_clean(command):
    process = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True)
    assert process.returncode == 0, process.stdout + process.stderr
