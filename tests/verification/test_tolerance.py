"""Verification: `--tolerance` picks a setting that meets it, checks that it did, and refuses what has no answer."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tailslap.case.corner.case import CornerCase
from tailslap.errors import InputError
from tailslap.planning.flexibility import sensitivity
from tailslap.scene.read import read_scene
from tailslap.scene_run import run_scene
from tailslap.tolerance import run_to_tolerance
from tailslap.tolerance.choose import LIMIT, RIGID, Choice, choose
from tailslap.tolerance.refinement_levels import RefinementLevel, refinement_levels
from tailslap.tolerance.verify import verified

pytestmark = pytest.mark.verification

SOFT = ("plate.youngs_modulus=20 MPa", "corner.patch_length=1")


def plan_of(name: str, *changes: str) -> CornerCase:
    return CornerCase(*read_scene(name, changes))


def choice_of(name: str, tolerance: float, *changes: str) -> Choice:
    return choose(plan_of(name, *changes), tolerance)


def check_of(result: Any) -> Any:
    (check,) = (check for check in result.checks if check.name == "tolerance")
    return check


def test_ladder_has_square_elements_and_grows() -> None:
    levels = list(refinement_levels(read_scene("paper-abaqus")[0], "penalty"))
    shapes = [(10.0 / r.elements[0]) / (2.438 / r.elements[1]) for r in levels]
    assert all(0.9 < shape < 1.5 for shape in shapes)
    counts = [r.elements[0] * r.elements[1] for r in levels]
    assert counts == sorted(counts)
    assert {r.element for r in levels} == {"quad4", "quad9"}


def test_half_a_mesh_of_two_is_none() -> None:
    assert RefinementLevel("quad4", (7, 2), "exact").scaled(0.5) is None
    assert RefinementLevel("quad4", (7, 4), "exact").scaled(0.5) == RefinementLevel("quad4", (3, 2), "exact")


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-5])
def test_stiff_plate_is_held_against_the_rigid_motion(tolerance: float) -> None:
    result = run_to_tolerance(plan_of("paper-table-3"), tolerance)
    assert result.choice is not None
    assert result.choice.against == RIGID
    assert result.passed
    assert check_of(result).value == max(map(abs, result.difference.values())) <= tolerance
    assert result.choice.expected_error <= tolerance
    assert result.fe_plan.model.loop.mass.size < 50  # 147 nodes as the scene has it


@pytest.mark.long
def test_soft_plate_is_held_against_its_own_limit() -> None:
    """The error estimated from a second mesh is right to a factor of three, and the tolerance is met."""
    result = run_to_tolerance(plan_of("paper-table-3", *SOFT), 2e-3)
    assert result.choice is not None
    assert result.choice.against == LIMIT
    fine = ("plate.element=quad9", "plate.elements=[40, 12]", "corner.constraint=exact")
    truth = run_scene(CornerCase(*read_scene("paper-table-3", (*SOFT, *fine)))).fe
    error = max(abs(value / truth[name] - 1.0) for name, value in result.fe.items())
    assert error <= 2e-3
    assert error / 3.0 < check_of(result).value < 3.0 * error
    assert result.passed


def test_point_on_a_soft_plate_has_no_limit() -> None:
    with pytest.raises(InputError, match=r"no limit of fine meshes.*corner\.patch_length"):
        choice_of("paper-table-3", 1e-3, "plate.youngs_modulus=20 MPa")
    with pytest.raises(InputError, match=r"moves the result by up to 4\.\de-06"):
        choice_of("paper-table-3", 1e-6)


@pytest.mark.parametrize("tolerance", [0.0, -1e-3, 1e-9, 1.0, math.nan, math.inf])
def test_tolerances_that_make_no_sense(tolerance: float) -> None:
    with pytest.raises(InputError, match="--tolerance"):
        choice_of("paper-table-3", tolerance)


def test_setting_that_would_flutter_is_damped_by_the_run() -> None:
    changes = ("plate.youngs_modulus=100 TPa", "impact.friction=0.8", "corner.penalty_scale=1")
    result = run_to_tolerance(plan_of("paper-table-3", *changes), 1e-4)
    assert result.passed
    assert result.fe_plan.model.loop.elastic_damping is not None
    forbidden = run_to_tolerance(plan_of("paper-table-3", *changes, "damping.kind=none"), 1e-4)
    assert not forbidden.passed


def test_scene_that_says_how_its_corner_is_held_keeps_it() -> None:
    choice = choice_of("paper-table-3", 0.1, *SOFT, "corner.penalty_scale=2")
    assert choice.level.constraint == "penalty"
    assert choice_of("paper-table-3", 0.1, "corner.constraint=exact").level.constraint == "exact"


def test_expectation_that_fails_is_reported() -> None:
    """The check after the run does not trust the expectation: an answer worse than the tolerance fails."""
    plan = CornerCase(*read_scene("paper-table-3"))
    choice = choose(plan, 1e-4)
    result = run_scene(CornerCase(*read_scene("paper-table-3", choice.changes)))
    late = verified(result, replace(choice, tolerance=1e-6), plan)
    assert not late.passed
    assert not check_of(late).passed
    gone = verified(replace(result, difference={}, fe={}), choice, plan)
    assert math.isnan(check_of(gone).value)
    assert not check_of(gone).passed


def test_sensitivity_bounds_what_was_seen() -> None:
    """Largest error over give at 5, 20 and 40 degrees: 0.45, 0.88 and 1.97 (benchmarks/tolerance.py --sensitivity)."""
    for degrees, seen in ((5.0, 0.45), (20.0, 0.88), (40.0, 1.97)):
        assert 1.3 * seen < sensitivity(math.radians(degrees)) < 3.0 * seen


def test_command_writes_what_was_picked(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tailslap.cli", "run", "paper-abaqus", "--no-pictures"]
    done = subprocess.run(
        [*command, "--tolerance", "1e-4", "--out", str(tmp_path / "out")], capture_output=True, text=True
    )
    assert done.returncode == 0
    assert "Picked: plate.element=quad4" in done.stdout
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["tolerance"]["tolerance"] == 1e-4
    assert summary["tolerance"]["against"] == "rigid"
    assert "Picked for a tolerance of 0.0001" in (tmp_path / "out" / "report.html").read_text()
    refused = subprocess.run(
        [*command, "--tolerance", "1e-7", "--out", str(tmp_path / "no")], capture_output=True, text=True
    )
    assert refused.returncode == 2
    assert not (tmp_path / "no").exists()
