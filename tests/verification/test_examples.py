"""Verification: the examples run, and are notebooks in the percent form."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples"
EXAMPLES = sorted(path.name for path in FOLDER.glob("*.py"))
LONG = {"own_vehicle_and_law.py"}
"""A law from outside has the loops compiled anew."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] if name in LONG else []) for name in EXAMPLES]
)
def test_it_runs(name, tmp_path, monkeypatch, capsys):
    """What it claims, it asserts itself; it writes nothing."""
    monkeypatch.chdir(tmp_path)
    try:
        runpy.run_path(str(FOLDER / name), run_name="__main__")
    finally:
        from fem import FRICTION_LAWS

        FRICTION_LAWS.pop("fading", None)
    assert len(capsys.readouterr().out.splitlines()) > 5
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", EXAMPLES)
def test_it_opens_as_a_notebook(name):
    """Cells of Jupytext's percent form: text in comments alone, code that compiles cell by cell."""
    head, *cells = (FOLDER / name).read_text(encoding="utf-8").split("\n# %%")
    assert "format_name: percent" in head
    kinds = {"text": 0, "code": 0}
    for cell in cells:
        title, _, body = cell.partition("\n")
        if title == " [markdown]":
            assert all(line.startswith("#") for line in body.splitlines() if line.strip())
            kinds["text"] += 1
        else:
            assert title == ""
            compile(body, name, "exec")
            kinds["code"] += 1
    assert min(kinds.values()) >= 2


def test_there_are_three():
    assert EXAMPLES == ["flexible_plate.py", "own_vehicle_and_law.py", "table_3.py"]
