"""Verify that docstrings of public names are complete in numpydoc form."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import pkgutil
import re
import textwrap
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("solver", "meshes", "machine_code", "fem", "postprocess", "tailslap")
MOST_WORDS = 12
HEADING = re.compile(r"^(\S.*)\n(-{3,})$", re.MULTILINE)
ENTRY = re.compile(r"^([\w*][\w, *]*?)(?: : (.+))?$")
NUMBER = re.compile(r"(float|Number|V|Array|ArrayLike|np\.ndarray|NDArray\[.*\])( \| None)?$")
ARRAY = re.compile(r"(Array|ArrayLike|np\.ndarray|NDArray\[.*\])( \| None)?$")
UNIT = re.compile(r"\[[^\]]+\]")
EQUATION = re.compile(r"\bEqs? \d")


def modules() -> Iterator[ModuleType]:
    """The six packages, and the sub-packages of `solver`, `fem` and `postprocess`."""
    for name in PACKAGES:
        package = importlib.import_module(name)
        yield package
        has_parts = name in ("solver", "fem", "postprocess")
        for part in pkgutil.iter_modules(package.__path__, f"{name}.") if has_parts else ():
            if part.ispkg:
                yield importlib.import_module(part.name)


def public() -> dict[str, Any]:
    """Functions and classes in `__all__`, by their full names."""
    objects = {}
    for module in modules():
        for name in getattr(module, "__all__", ()):
            value = getattr(module, name)
            value = getattr(value, "py_func", value)  # of a kernel
            if inspect.isclass(value) or inspect.isroutine(value):
                objects[f"{value.__module__}.{name}"] = value
    return objects


PUBLIC = public()


def sections(text: str) -> dict[str, str]:
    """The text below each underlined heading."""
    parts = HEADING.split(text)
    return {title: body for title, _, body in zip(parts[1::3], parts[2::3], parts[3::3], strict=True)}


def entries(body: str) -> dict[str, str]:
    """Type and description of each parameter, also of several in one entry."""
    descriptions: dict[str, str] = {}
    names: list[str] = []
    for line in body.strip("\n").splitlines():
        entry = ENTRY.match(line)
        if entry:
            names = [name.strip(" *") for name in entry[1].split(",")]
            descriptions |= dict.fromkeys(names, f" : {entry[2] or ''}\n")
        else:
            descriptions |= {name: descriptions[name] + line + "\n" for name in names}
    return descriptions


def own_nodes(function: Any) -> Iterator[ast.AST]:
    """Nodes of a function's body, without those of functions inside it."""
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    assert isinstance(definition, ast.FunctionDef)
    nodes: list[ast.AST] = [*definition.body]
    while nodes:
        node = nodes.pop()
        yield node
        if not isinstance(node, ast.FunctionDef | ast.Lambda):
            nodes += ast.iter_child_nodes(node)


def returns(function: Any) -> bool:
    statements = (node for node in own_nodes(function) if isinstance(node, ast.Return))
    return any(node.value is not None and ast.unparse(node.value) != "None" for node in statements)


def raised(function: Any) -> set[str]:
    """Names of exceptions raised in a function, "" for those of others."""
    exceptions = (node.exc for node in own_nodes(function) if isinstance(node, ast.Raise) and node.exc)
    names = (ast.unparse(node.func if isinstance(node, ast.Call) else node) for node in exceptions)
    return {name if name[0].isupper() else "" for name in names}


def lacking(described: dict[str, str], annotations: dict[str, str]) -> Iterator[str]:
    """Faults of the description of parameters or fields with these types."""
    for name in annotations.keys() - described.keys():
        yield f"{name} is not described"
    for name in described.keys() - annotations.keys():
        yield f"{name} is described, but not there"
    for name in annotations.keys() & described.keys():
        words, annotation = described[name], annotations[name]
        if not words.splitlines()[0].removeprefix(" : "):
            yield f"{name} has no type"
        if NUMBER.match(annotation) and not UNIT.search(words):
            yield f"{name} has no unit ([-] where it is a pure number)"
        if ARRAY.match(annotation) and "shape" not in words and "(" not in words.splitlines()[0]:
            yield f"{name} has no shape"


def function_faults(function: Any) -> Iterator[str]:
    """Yield the missing parts of the docstring of a function or method."""
    text_of = sections(inspect.getdoc(function) or "")
    parameters = inspect.signature(function).parameters.values()
    annotations = {p.name: str(p.annotation) for p in parameters if p.name not in ("self", "cls")}
    yield from lacking(entries(text_of.get("Parameters", "")), annotations)
    if returns(function) and "Returns" not in text_of:
        yield "no section Returns"
    if any(isinstance(node, ast.Yield) for node in own_nodes(function)) and "Yields" not in text_of:
        yield "no section Yields"
    named = raised(function)
    if named and "Raises" not in text_of:
        yield "no section Raises"
    yield from (f"{name} is not in Raises" for name in named if name not in text_of.get("Raises", ""))


def fields_of(kind: type) -> dict[str, str]:
    """Public fields of a record or parameters of a class, annotated."""
    if dataclasses.is_dataclass(kind):
        annotations = {field.name: str(field.type) for field in dataclasses.fields(kind)}
    elif hasattr(kind, "_fields") or hasattr(kind, "model_fields"):
        annotations = {name: str(value) for name, value in inspect.get_annotations(kind).items()}
    else:
        annotations = {p.name: str(p.annotation) for p in inspect.signature(kind).parameters.values()}
    return {name: annotation for name, annotation in annotations.items() if not name.startswith("_")}


def class_faults(kind: type) -> Iterator[str]:
    """Yield faults of a class and its methods without inherited fields."""
    described: dict[str, str] = {}
    for base in kind.__mro__[:-1]:
        text_of = sections(inspect.cleandoc(base.__doc__ or ""))
        described |= entries(text_of.get("Parameters", "")) | entries(text_of.get("Attributes", ""))
    properties = {n for n, value in vars(kind).items() if isinstance(value, property | cached_property)}
    fields = fields_of(kind)
    yield from lacking(
        {n: words for n, words in described.items() if n not in properties - fields.keys()}, fields
    )
    for name, value in vars(kind).items():
        if name.startswith("_"):
            continue
        method = getattr(value, "__func__", value)  # of a class method
        if name in properties and not inspect.getdoc(value):
            yield f"{name} has no docstring"
        if inspect.isfunction(method):
            yield from (f"{name}: {fault}" for fault in function_faults(method))


def long_summaries(path: Path) -> Iterator[str]:
    """Yield first lines of more than twelve words or of two parts."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            summary = (ast.get_docstring(node) or "").partition("\n\n")[0]
            if len(summary.split()) > MOST_WORDS or re.search("[;:]", summary):
                yield f"{path.relative_to(ROOT)}: {summary}"


@pytest.mark.parametrize("folder", [*PACKAGES, "tests", "benchmarks"])
def test_first_lines_are_short(folder):
    """That they begin with a verb is checked by ruff, D401."""
    assert [line for path in sorted((ROOT / folder).rglob("*.py")) for line in long_summaries(path)] == []


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_public_docstring_is_complete(name):
    """Check types, units, shapes, returns, yields, errors and references."""
    value = PUBLIC[name]
    text = inspect.getdoc(value) or ""
    faults = list(class_faults(value) if inspect.isclass(value) else function_faults(value))
    if EQUATION.search(text) and "References" not in sections(text):
        faults.append("equations without References")
    assert text, f"{name} has no docstring"
    assert not faults, f"{name}: {'; '.join(faults)}"


def test_rigid_theory_and_meshes_are_public():
    names = {"solver.motion.tail_slap", "solver.body.RectangularBody", "meshes.rectangle.plate_mesh"}
    assert names <= PUBLIC.keys()


def undescribed(mass: float, times: np.ndarray, count: int) -> float:  # noqa: D417
    """Momentum.

    Parameters
    ----------
    mass : float
        Mass.
    times
        Instants [s].
    other : int
        Nothing.
    """
    if count:
        raise ValueError(count)
    return mass


def test_faults_are_found():
    missing = {f"times has no {what}" for what in ("type", "shape")}
    missing |= {"count is not described", "mass has no unit ([-] where it is a pure number)"}
    missing |= {"no section Returns", "no section Raises", "ValueError is not in Raises"}
    assert set(function_faults(undescribed)) == missing | {"other is described, but not there"}
