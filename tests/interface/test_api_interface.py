"""Verify types, descriptions and argument checks of `import tailslap`."""

import doctest
import importlib
import inspect
import os
import pydoc
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, assert_type, get_type_hints

import numpy as np
import pytest

import tailslap
from tailslap import InputError
from tailslap.wall_strength import report as wall_report

FUNCTIONS = (
    "check", "compare", "confirm", "export", "load", "modal", "modes", "new", "paper", "parapet", "rigid", "run",
    "scenes", "study", "sweep", "validate",
)  # fmt: skip


SECTIONS = ("Parameters", "Returns", "Raises", "Examples")


TAKES_NOTHING = ("Returns", "Examples")
"""Sections of a function without parameters, which no input makes fail."""


def test_names_are_listed_for_completion():
    assert {"run", "rigid", "sweep", "load", "InputError"} <= set(dir(tailslap)) == set(tailslap.__all__)


def test_help_begins_with_the_functions():
    """Each function has a line above the classes, without names of files."""
    page = pydoc.plain(pydoc.render_doc(tailslap))
    opening = page[: page.index("PACKAGE CONTENTS")]
    assert [name for name in FUNCTIONS if not re.search(rf"^ +{name}  +\w.*", opening, re.MULTILINE)] == []
    assert not re.search(r"\w\.(md|py|html)\b", opening)


if TYPE_CHECKING:  # by mypy in test_style.py, which also refuses a comment of `ignore` without an error
    assert_type(tailslap.scenes(), dict[str, str])
    tailslap.run("a").history["v_gy"].rolling(5)  # a column has the methods of a series of pandas
    tailslap.walk()  # type: ignore[attr-defined]


UNTYPED: Any = tailslap
"""The package for calls that a type checker refuses too."""


@pytest.mark.parametrize(("call", "kind", "hint"), [
    (lambda: UNTYPED.run("paper-table-3", tolerence=1e-3), TypeError, "tolerance"),
    (lambda: UNTYPED.sweep("paper-table-3", {}, foldr="x"), TypeError, "folder"),
    (lambda: tailslap.rigid("paper-table3"), InputError, "paper-table-3"),
    (lambda: tailslap.rigid("mash-tl4-sut", {"impact": {"sped": 20.0}}), InputError, "impact.speed"),
    (lambda: tailslap.rigid("mash-tl4-sut", {"mass": 20.0}), InputError, "vehicle.mass"),
    (lambda: tailslap.rigid("mash-tl4-sut").plot("v_gz"), InputError, "v_gy"),
    (lambda: tailslap.study("uncertanty", "mash-tl4-sut"), InputError, "uncertainty"),
    (lambda: tailslap.study("uncertainty", "mash-tl4-sut", sample=9), InputError, "samples"),
    (lambda: tailslap.export(tailslap.rigid("mash-tl4-sut"), "cvs"), InputError, "csv"),
    (lambda: tailslap.compare(*2 * [tailslap.rigid("mash-tl4-sut")], only=["v_gys"]), InputError, "v_gy"),
])  # fmt: skip
def test_wrong_names_get_the_nearest(call, kind, hint):
    with pytest.raises(kind, match=rf"; did you mean {re.escape(hint)}\?$"):
        call()


METHODS = tuple(getattr(tailslap.Result, name) for name in ("mesh", "plot", "plot_field", "save"))


TAKEN = [
    (function, name)
    for function in (*(getattr(tailslap, name) for name in FUNCTIONS), *METHODS)
    for name in inspect.signature(function).parameters
    if name not in ("self", "options")
]


VALID = {"scene": "mash-tl4-sut", "name": "uncertainty", "vary": {"impact.speed": [20.0]}, "to": "csv"}
"""Valid values of arguments without default."""


@pytest.mark.parametrize(("function", "name"), TAKEN, ids=lambda part: getattr(part, "__qualname__", part))
@pytest.mark.parametrize("wrong", [object(), b"x", 1j])
def test_an_argument_of_another_type_is_refused_by_its_name(function, name, wrong):
    parameters = inspect.signature(function).parameters
    options = {other: VALID[other] for other in parameters if other in VALID}
    several = parameters[name].kind is inspect.Parameter.VAR_POSITIONAL
    with pytest.raises(InputError) as caught:
        function("x", wrong) if several else function(**options | {name: wrong})
    assert (caught.value.key, caught.value.value) == (name, repr(wrong))
    assert re.search(rf"^ *\*?{name} : {re.escape(caught.value.allowed.removeprefix('allowed is '))}$",
                     inspect.getdoc(function) or "", re.MULTILINE)  # fmt: skip


@pytest.mark.parametrize(("call", "key"), [
    (lambda: UNTYPED.new("\0"), "name"), (lambda: UNTYPED.new("\ud800"), "name"),
    (lambda: UNTYPED.new("\1"), "name"),
    (lambda: UNTYPED.load("\0"), "folder"), (lambda: UNTYPED.load(Path("\0")), "folder"),
    (lambda: UNTYPED.load("\ud800"), "folder"),
    (lambda: UNTYPED.rigid("mash-tl4-sut", [("impact.speed",)]), "changes"),
    (lambda: UNTYPED.rigid("mash-tl4-sut", "impact.speed=20"), "changes"),
    (lambda: UNTYPED.rigid("mash-tl4-sut", {3: 20.0}), "changes"),
    (lambda: UNTYPED.rigid("mash-tl4-sut", units="imperial"), "units"),
    (lambda: UNTYPED.sweep("mash-tl4-sut", {"impact.speed": 20.0}), "vary"),
    (lambda: UNTYPED.run("mash-tl4-sut", tolerance="1 %"), "tolerance"),
    (lambda: UNTYPED.run("mash-tl4-sut", tolerance=True), "tolerance"),
])  # fmt: skip
def test_what_no_argument_can_be_is_refused_by_its_name(call, key):
    with pytest.raises(InputError) as caught:
        call()
    assert caught.value.key == key


def test_tables_are_a_scene_of_every_function(tmp_path):
    """Tables without a name, which pages and results contain as the scene."""
    tables = {
        "vehicle": {"length": "10 m", "width": "2438 mm", "mass": "9979 kg"},
        "impact": {"speed": "56 mph", "angle": "15 deg"},
        "contact": {"stiffness": "2 MN/m", "restitution": 0.2, "friction": 0.35},
    }
    rigid = tailslap.rigid(tables)
    assert rigid.scene == "scene"
    swept = tailslap.sweep(tables, {"contact.friction": [0.2, 0.35]}, folder=tmp_path / "sweep")
    assert swept.history["rigid.peaks.raw"].to_list()[1] == rigid.summary["peaks"]["raw"]
    study = tailslap.study("uncertainty", tables, samples=288, folder=tmp_path / "study")
    assert study.summary["scene"] == "scene"
    for place in ("sweep", "study"):
        assert "speed = &#34;56 mph&#34;" in (tmp_path / place / "report.html").read_text(encoding="utf-8")


def test_a_result_without_a_history_names_what_contains_its_numbers():
    with pytest.raises(InputError, match=r"`tailslap modes` has no history; its numbers are in `summary`"):
        _ = tailslap.modes("paper-table-3", count=1).history


def test_numbers_and_rows_of_numpy_are_taken():
    changes = ["impact.speed=56 mph"]
    assert UNTYPED.modes("paper-table-3", count=np.int64(1)).summary["modes"]
    rigid = UNTYPED.rigid("mash-tl4-sut", np.array(changes))
    assert rigid.summary == tailslap.rigid("mash-tl4-sut", changes).summary


@pytest.mark.parametrize(("options", "why"), [
    ({"samples": 1000.5}, "1000.5 is not a whole number"), ({"samples": 3}, "3 is not in the range"),
    ({"colour": "red"}, "allowed are samples, range, fix"),
])  # fmt: skip
def test_options_of_a_study_have_the_bounds_of_the_command(options, why):
    with pytest.raises(InputError, match=why):
        tailslap.study("uncertainty", "mash-tl4-sut", **options)


def test_unusual_numbers_are_remarked_upon():
    with pytest.warns(UserWarning, match=r"impact.speed = 56 without a unit is 56 m/s"):
        tailslap.rigid("mash-tl4-sut", {"impact.speed": 56})


def test_the_interface_is_complete_and_its_types_are_known():
    assert {*FUNCTIONS, "Columns", "InputError", "Result"} == set(tailslap.__all__)
    stub = (Path(tailslap.__file__).parent / "__init__.pyi").read_text()
    assert [name for name in tailslap.__all__ if f" as {name}\n" not in stub] == []
    for name in FUNCTIONS:
        function = getattr(tailslap, name)
        hints = get_type_hints(function)
        assert {*inspect.signature(function).parameters, "return"} <= hints.keys()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_is_described_with_an_example(name):
    function = getattr(tailslap, name)
    takes_nothing = not inspect.signature(function).parameters
    text, sections = inspect.getdoc(function) or "", TAKES_NOTHING if takes_nothing else SECTIONS
    assert [title for title in sections if f"\n{title}\n{'-' * len(title)}\n" not in text] == []
    assert ">>> " in text


@pytest.mark.parametrize("name", [*FUNCTIONS, "Columns"])
def test_examples_are_right(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(wall_report, "ALLOWED", dict.fromkeys(wall_report.ALLOWED, 0.1))
    value = getattr(tailslap, name)
    module = importlib.import_module(value.__module__)
    tests = doctest.DocTestFinder(recurse=False).find(value, name, globs={**vars(module), "np": np})
    runner = doctest.DocTestRunner(verbose=False)
    assert all(runner.run(test).failed == 0 for test in tests)
    assert sum(len(test.examples) for test in tests) > 0


def test_modules_do_not_hide_the_functions():
    """A module of the same name would replace a function on import."""
    code = "import tailslap.cli as c, tailslap; c.commands.get_command; print(*map(callable, ({})))"
    names = ", ".join(f"tailslap.{name}" for name in FUNCTIONS)
    run = subprocess.run(
        [sys.executable, "-c", code.format(names)], capture_output=True, text=True, check=True, env=os.environ
    )
    assert set(run.stdout.split()) == {"True"}
    folder = Path(tailslap.__file__).parent
    assert [name for name in FUNCTIONS if (folder / name).exists() or (folder / f"{name}.py").exists()] == []
