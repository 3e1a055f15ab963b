"""Verify the stated error of mesh and spring, and refinement."""

import json
import math

import click
import numpy as np
import pytest

from fem.plate.discretisation import nodal_spin
from postprocess.comparison.quantities import largest
from tailslap.case.corner import decisions
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_checks import rings
from tailslap.case.corner.corner_run import attempt, on_plate, with_damping_of, with_open_damping
from tailslap.case.corner.numerical_error import CORRUPTED
from tailslap.case.impact.case import ImpactCase
from tailslap.case.plate_input import comparable_plate, refined
from tailslap.cli import _status, commands
from tailslap.errors import InputError
from tailslap.scene.read import read_scene


def fe_plan(*changes):
    return CornerCase(*read_scene("paper-abaqus", changes)).plan()


def failed(result):
    return {check.name for check in result.checks if not check.passed}


def test_spring_accounts_for_the_give_beyond_the_exact_constraint(outcome):
    """A spring displaces the plate by N/k, besides the elastic part."""
    penalty, exact = outcome("paper-abaqus").fe_plan, fe_plan("corner.constraint=exact")
    assert penalty.spring_ratio == pytest.approx(penalty.deflection_ratio - exact.deflection_ratio, rel=1e-4)
    assert exact.spring_ratio == 0.0


@pytest.mark.long
def test_soft_spring_is_caught_and_exact_constraint_has_none(outcome):
    soft = ("plate.youngs_modulus=20 MPa", "plate.elements=[10,3]", "corner.reaction=none")
    assert failed(outcome("paper-table-3", *soft, "corner.penalty_scale=0.7")) == {"numerical error"}
    exact = outcome("paper-table-3", *soft, "corner.constraint=exact", "plate.element=quad9")
    assert exact.error.contact_spring == 0.0
    assert failed(exact) == set()


@pytest.mark.long
def test_mesh_that_locks_is_caught(outcome):
    """Linear triangles look rigid where quadratic ones bend."""
    slender = ("vehicle.width=0.2", "plate.youngs_modulus=20 GPa", "damping.ratio=0.2", "plate.element=tri3")
    assert "numerical error" in failed(outcome("paper-abaqus", *slender))


def test_give_of_a_patch_converges_to_that_of_richer_elements():
    gaps = []
    for n in (20, 40, 80):
        changes = ("corner.patch_length=1", "corner.constraint=exact", f"plate.elements=[{n},{3 * n // 10}]")
        case = case_of("paper-abaqus", *changes)
        mesh = decisions.make_mesh(case, case.scene.needed_plate)
        gaps.append(abs(mesh.deflection_ratio - mesh.comparable_ratio) / mesh.deflection_ratio)
    assert gaps[0] < 0.06
    assert np.all(np.diff(np.log2(gaps)) < -1.0)


def test_large_meshes_are_judged_by_a_coarser_one():
    plate = read_scene("paper-abaqus", ("plate.elements=[400,120]",))[0].needed_plate
    assert comparable_plate(plate).elements == (200, 60)
    assert comparable_plate(plate.model_copy(update={"elements": (1600, 625)})).elements == (200, 78)
    quadratic = plate.model_copy(update={"elements": (8, 4), "element": "tri6"})
    assert comparable_plate(quadratic).elements == (16, 8)


def test_a_refined_plate_keeps_all_but_counts_and_kind():
    """Counts are rounded as requested, with a least value."""
    plate = read_scene("paper-abaqus", ("plate.elements=[21,5]", "plate.distortion=0.1"))[0].needed_plate
    assert (refined(plate).counts, refined(plate, 0.5).counts) == ((42, 10), (10, 2))
    assert refined(plate, 1.0 / 1.5, least=4, whole=round).counts == (14, 4)
    other = refined(plate, 1.0, "quad9")
    assert other == plate.model_copy(update={"element": "quad9"})


def test_corrupted_run_is_given_up(outcome):
    """Flutter at 5 000 times the stiffness ends the run."""
    stiff = ("plate.youngs_modulus=1000 TPa", "plate.elements=[6,2]", "damping.kind=none")
    result = outcome("paper-table-3", *stiff)
    (ringing,) = (check.value for check in result.checks if check.name == "friction by ringing")
    assert ringing > CORRUPTED
    assert {"tail-slap reached", "friction by ringing"} <= failed(result)
    assert result.run.steps < 0.9 * result.fe_plan.expected_steps


def test_momentum_closes_with_exact_constraint_and_damping(outcome):
    """The first reaction is that of the velocities of the first step."""
    fast = ("start.omega=7.07", "start.corner_speed=250.53", "vehicle.width=10", "wall.length=1000")
    result = outcome("paper-table-3", *fast, "corner.constraint=exact", "damping.ratio=0.02")
    (momentum,) = (check.value for check in result.checks if check.name == "momentum balance")
    assert momentum < 1e-14


@pytest.mark.parametrize("element", ["quad4", "quad9", "tri3", pytest.param("tri6", marks=pytest.mark.long)])
def test_spin_for_the_pictures_is_that_of_a_rigid_turn(outcome, element):
    """On quadratic triangles too, whose corner functions have no integral."""
    mesh = ("plate.elements=[8,4]", f"plate.element={element}")
    discretisation = outcome("paper-abaqus", *mesh).fe_plan.model.discretisation
    x, y = discretisation.positions
    spin = nodal_spin(discretisation.scalar, discretisation.positions, 0.7 * np.array([-y, x]))
    assert spin.shape == (discretisation.cells.max() + 1,)
    assert spin == pytest.approx(np.full_like(spin, 0.7), rel=1e-12)


def test_a_companion_is_damped_where_the_scene_forbids_it(outcome):
    """The companion of half the mesh size flutters, and is damped."""
    vehicle = ("vehicle.length=14.4", "vehicle.width=3.6", "impact.speed=18", "impact.angle=0.085", "wall=")
    mesh = ("plate.elements=[10, 5]", "plate.lumping=row-sum", "plate.distortion=0.04")
    plate = (*mesh, "impact.friction=0.9")
    soft = ("plate.youngs_modulus=", "plate.first_frequency=92 Hz", "corner.penalty_scale=1")
    rest = ("corner.patch_length=3.6", "impact.restitution=0.19", "damping.kind=none")
    result = outcome("mash-tl4-sut", *vehicle, *plate, *soft, *rest)
    damped = attempt(with_damping_of(result.fe_plan, on_plate(result.fe_plan, refined(result.fe_plan.plate))))
    assert result.fe_plan.model.parameters.elastic_damping is None
    assert rings(damped)
    assert result.passed
    assert result.companions[0].mesh == "quad4, 20 x 10"
    assert largest(result.companions[0].difference) < largest(result.difference) < 2e-4


def test_only_the_kind_of_damping_is_left_open():
    rate = ("damping.kind=elastic-velocity", "damping.rate=20")
    for change, ratio in ((("damping.kind=none",), None), (rate, None), ((*rate, "damping.ratio=0.1"), 0.1)):
        plan = with_open_damping(CornerCase(*read_scene("paper-table-3", change)))
        assert (plan.scene.damping and plan.scene.damping.ratio) == ratio
        assert plan.scene.damping is None or plan.scene.damping.kind is None


SOFT = ("plate.youngs_modulus=20 MPa", "corner.patch_length=1")
COARSE = ("plate.element=quad4", "plate.elements=[10, 3]")


def case_of(name, *changes):
    return CornerCase(*read_scene(name, changes))


def check_of(result):
    (check,) = (check for check in result.checks if check.name == "tolerance")
    return check


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-5])
def test_a_run_whose_error_meets_it_stays_as_it_is(tolerance):
    case = case_of("paper-table-3")
    result = case.run(tolerance)
    assert result.passed
    assert check_of(result).value == result.error.total <= tolerance
    assert result.fe == case.run().fe


def test_meshes_are_doubled_until_the_error_meets_it():
    """The mesh before states an error above the tolerance."""
    case = case_of("paper-table-3", *COARSE)
    errors = [case.varied({"plate.elements": (10 * n, 3 * n)}).run().error.total for n in (1, 2)]
    result = case.run(math.sqrt(errors[0] * errors[1]))
    assert errors[1] < errors[0]
    assert (result.fe_plan.plate.counts, check_of(result).value) == ((20, 6), errors[1])
    assert check_of(result).passed


@pytest.mark.parametrize(("bound", "value"), [("case.MOST_ELEMENTS", 400), ("resources.MAX_SECONDS", 1e-2)])
def test_a_tolerance_out_of_reach_ends_with_a_check_that_fails(monkeypatch, bound, value):
    monkeypatch.setattr(f"tailslap.case.{bound}", value)
    result = case_of("paper-table-3", *COARSE).run(1e-7)
    assert math.prod(result.fe_plan.plate.counts) <= 400
    assert check_of(result).value == result.error.total > 1e-7
    assert not check_of(result).passed
    assert not result.passed


@pytest.mark.long
def test_soft_plate_is_held_against_its_own_limit():
    """The tolerance is met, and the stated error holds."""
    result = case_of("paper-table-3", *SOFT).run(2e-3)
    fine = ("plate.element=quad9", "plate.elements=[40, 12]", "corner.constraint=exact")
    truth = case_of("paper-table-3", *SOFT, *fine).run().fe
    error = max(abs(value / truth[name] - 1.0) for name, value in result.fe.items())
    assert error <= check_of(result).value <= 2e-3
    assert result.passed


@pytest.mark.parametrize("tolerance", [0.0, -1e-3, 1e-9, 1.0, math.nan, math.inf])
def test_tolerances_that_make_no_sense(tolerance):
    with pytest.raises(InputError, match="--tolerance"):
        case_of("paper-table-3").run(tolerance)


@pytest.mark.parametrize(
    ("kind", "scene"), [(CornerCase, "paper-table-3"), (ImpactCase, "impact-mash-tl4-sut")]
)
def test_a_tolerance_below_the_least_is_shown_with_all_of_its_digits(kind, scene):
    """The allowed and the refused value differ as texts."""
    case = kind(*read_scene(scene))
    tolerance = math.nextafter(case.least_tolerance, 0.0)
    with pytest.raises(InputError) as caught:
        case.run(tolerance)
    assert caught.value.allowed == f"allowed is from {case.least_tolerance:g} to below 1"
    assert str(caught.value).startswith(f"--tolerance: given {tolerance!r};")
    (option,) = (parameter for parameter in commands.commands["run"].params if parameter.name == "tolerance")
    assert isinstance(option, click.Option)
    assert isinstance(option.type, click.FloatRange)
    assert (option.type.min, option.type.min_open) == (CornerCase.least_tolerance, False)
    assert f"{ImpactCase.least_tolerance:g}" in (option.help or "")


def test_setting_that_would_flutter_is_damped_by_the_run(monkeypatch):
    changes = ("plate.youngs_modulus=100 TPa", "impact.friction=0.8", "corner.penalty_scale=1")
    result = case_of("paper-table-3", *changes).run(1e-4)
    assert result.passed
    assert result.fe_plan.model.parameters.elastic_damping is not None
    monkeypatch.setattr("tailslap.case.case.MOST_ELEMENTS", 200)
    assert not case_of("paper-table-3", *changes, "damping.kind=none").run(1e-4).passed


def test_scene_that_says_how_its_corner_is_held_keeps_it():
    for constraint in ("penalty", "exact"):
        result = case_of("paper-table-3", f"corner.constraint={constraint}").run(0.1)
        assert result.fe_plan.case.scene.corner.constraint == constraint


def test_a_run_without_a_result_does_not_meet_it():
    result = case_of("paper-table-3").run().with_tolerance(math.nan, 1e-4)
    assert not result.passed
    assert not check_of(result).passed


def test_command_says_whether_it_was_met(tmp_path):
    command = ["run", "paper-abaqus", "--no-pictures", "--tolerance"]
    assert _status([*command, "1e-4", "--out", str(tmp_path / "out")]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["tolerance"], summary["checks"][-1]["name"]) == (1e-4, "tolerance")
    assert "limit: --tolerance" in (tmp_path / "out" / "report.html").read_text()
    assert _status([*command, "1e-9", "--out", str(tmp_path / "no")]) == 2
    assert not (tmp_path / "no").exists()
