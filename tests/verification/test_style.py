"""Verification: the sources pass linter, formatter and type checker, and texts use the standard words."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest
from wording import PACKAGES, RETIRED, private_words

ROOT = Path(__file__).parents[2]


def found_in(text):
    """List the retired words of a text, code included, each with its standard one."""
    return private_words(text.replace("`", " "), RETIRED)


def sentences(path):
    """Texts of a module that people read: strings of several words, descriptions among them, and comments."""
    text = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            yield node.value
    yield from re.findall(r"#\s(.*)$", text, re.MULTILINE)


DOCUMENTS = [
    *sorted((ROOT / "docs").rglob("*.md")),
    *(ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md")),
    *sorted((ROOT / "examples").glob("*.py")),
    *sorted((ROOT / "tailslap" / "scene" / "shipped").glob("*.toml")),
    *sorted((ROOT / "postprocess" / "templates").glob("*.j2")),
]


@pytest.mark.parametrize("name", [str(path.relative_to(ROOT)) for path in DOCUMENTS])
def test_a_document_uses_standard_words(name):
    assert found_in((ROOT / name).read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("package", PACKAGES)
def test_messages_and_descriptions_use_standard_words(package):
    found = {}
    for path in sorted((ROOT / package).rglob("*.py")):
        if words := [word for text in sentences(path) for word in found_in(text)]:
            found[str(path.relative_to(ROOT))] = words
    assert found == {}


NOTICED = [
    *("The give of the plate is 1e-6", "by the hold of the corner", "a quiet start"),
    *("more damping calms it", "the run was spoilt", "the next rung", "foretold without a run"),
]


@pytest.mark.parametrize("text", NOTICED)
def test_retired_words_are_noticed(text):
    assert len(found_in(text)) == 1


def test_words_in_their_plain_meaning_pass():
    plain = "Numbers hold to rounding; they give the flexibility of all modes; the start is unstressed"
    assert found_in(plain) == []


OPENINGS = re.compile(
    r"(?:What|Whether|Of|The same|Where|How (?:many|far|often|much|long|deep)|Which|Those|As|If|It|When|Not)\b"
    r"|\w+ alike\b"
)
"""Words that a docstring does not begin with: it begins with a verb or the thing itself, and can be read alone."""


def docstrings(path):
    """Docstrings of a module, its classes and functions, and the strings below its constants."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
                yield str(child.value.value)


@pytest.mark.parametrize("package", PACKAGES)
def test_a_docstring_begins_with_a_verb_or_the_thing_itself(package):
    found = []
    for path in sorted((ROOT / package).rglob("*.py")):
        texts = [text.splitlines()[0] for text in docstrings(path) if OPENINGS.match(text)]
        found += [f"{path.relative_to(ROOT)}: {text}" for text in texts]
    assert found == []


ASSERTING = re.compile(r"assert|raises$|warns$|fail$")


def called_names(function):
    """Return the names of the functions that a function calls."""
    for node in ast.walk(function):
        if isinstance(node, ast.Call):
            yield node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")


def without_assertion(trees):
    """Test functions that assert nothing, neither themselves nor by a function of the tests that they call."""
    functions = [f for tree in trees for f in ast.walk(tree) if isinstance(f, ast.FunctionDef)]
    calls = {id(f): set(called_names(f)) for f in functions}
    asserting = {f.name for f in functions if any(isinstance(node, ast.Assert) for node in ast.walk(f))}
    asserting |= {f.name for f in functions if any(map(ASSERTING.search, calls[id(f)]))}
    found = [f.name for f in functions if f.name.startswith("test_") and f.name not in asserting]
    return [f.name for f in functions if f.name in found and not calls[id(f)] & asserting]


def test_each_test_asserts_something():
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in (ROOT / "tests").rglob("*.py")]
    assert without_assertion(trees) == []


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


@pytest.mark.parametrize("command", [("ruff", "check", "."), ("ruff", "format", "--check", "."), ("mypy",)])
def test_sources_are_clean(command):
    done = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
