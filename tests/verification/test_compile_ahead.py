"""Verify the compilation of the plate beside the rigid vehicle."""

import json
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from fem.run.impact import ImpactStepper
from tailslap.case import resources
from tailslap.case.impact import compile_ahead, plan
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.read import read_scene, shipped_scenes

WHOLE = [name for name in shipped_scenes() if name.startswith("impact-")]

WALL = (
    "wall.length=20m",
    "wall.depth=0.3m",
    "wall.height=1m",
    "wall.elements=[10, 2]",
    "wall.foundation_stiffness=1e9",
)

WAITS = """#!/usr/bin/env python3
import pathlib, sys, time
pathlib.Path(sys.argv[0] + ".txt").write_text(" ".join(sys.argv[1:]) + "\\n" + sys.stdin.read())
pathlib.Path(sys.argv[0] + ".done").touch()
time.sleep(5.0)
pathlib.Path(sys.argv[0] + ".ended").touch()
"""


@pytest.fixture
def first_use(tmp_path, monkeypatch):
    """Program in place of Python that stores its input."""
    program = tmp_path / "python"
    program.write_text(WAITS)
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    monkeypatch.setattr(compile_ahead, "has_machine_code", lambda: False)
    monkeypatch.setattr(resources, "available_cores", lambda: 2)
    return program


def received(program: Path) -> tuple[str, dict[str, object]]:
    """Arguments and scene that the process received."""
    end = time.monotonic() + 60.0
    while not Path(f"{program}.done").exists():
        assert time.monotonic() < end, "no process began"
        time.sleep(0.01)
    words, tables = Path(f"{program}.txt").read_text().split("\n", 1)
    return words, json.loads(tables)


@pytest.mark.parametrize("name", WHOLE)
def test_the_compiled_loop_is_that_of_the_run(name, monkeypatch):
    models: list[Any] = []
    scene = read_scene(name)
    monkeypatch.setattr("fem.run.impact.compile_impact_loop", models.append)
    compile_ahead.compile_plate(scene[1])
    if scene[0].plate is None:
        assert not models
        return
    kernel, arguments = ImpactStepper(plan.make_impact_plan(ImpactCase(*scene)).model).step_call
    ahead, arguments_ahead = ImpactStepper(models[0]).step_call
    assert ahead.path(*arguments_ahead) == kernel.path(*arguments)


def test_the_process_receives_the_scene_and_ends_with_the_block(first_use):
    scene, source = read_scene("impact-mash-tl4-sut", ("impact.speed=60mph",))
    with compile_ahead.plate_compiled_beside(scene, source):
        words, tables = received(first_use)
    assert words == f"-P -m {compile_ahead.__name__}"
    assert tables == source.given
    assert not Path(f"{first_use}.ended").exists()


def interrupted(program: Path) -> None:
    """Interrupt a block whose process has begun."""
    with compile_ahead.plate_compiled_beside(*read_scene("impact-mash-tl4-sut")):
        received(program)
        raise KeyboardInterrupt


def test_the_process_ends_with_an_interrupted_block(first_use):
    with pytest.raises(KeyboardInterrupt):
        interrupted(first_use)
    assert not Path(f"{first_use}.ended").exists()


@pytest.mark.parametrize("changes", [("plate=",), ("plate.elements=[200, 50]",), WALL], ids=" ".join)
def test_no_process_begins_without_need(first_use, changes):
    scene, source = read_scene("impact-mash-tl4-sut", changes)
    with compile_ahead.plate_compiled_beside(scene, source):
        pass
    assert not Path(f"{first_use}.txt").exists()
