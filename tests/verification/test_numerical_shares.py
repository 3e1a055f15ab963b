"""Verification: what the mesh and the corner's spring do to the answer is told from what the plate does."""

from typing import Any

import numpy as np
import pytest

from fem.plate.elements import nodal_spin
from postprocess.comparison.quantities import largest
from tailslap.case.corner.case import CornerCase
from tailslap.case.corner.error import CORRUPTED
from tailslap.case.corner.run import attempt, damped_alike, damped_freely, on_plate, rings
from tailslap.case.refine import comparable_plate, refined, second_plates
from tailslap.scene.read import read_scene


def fe_plan(*changes: str) -> Any:
    return CornerCase(*read_scene("paper-abaqus", changes)).plan()


def failed(result: Any) -> set[str]:
    return {check.name for check in result.checks if not check.passed}


def test_spring_accounts_for_the_give_beyond_the_exact_constraint(outcome):
    """A spring of stiffness k moves the whole plate by N/k; the elastic part is that of the exact constraint."""
    result, exact = outcome("paper-abaqus"), fe_plan("corner.constraint=exact")
    (spring,) = (check for check in result.checks if check.name == "contact spring")
    assert spring.value == pytest.approx(result.fe_plan.deflection_ratio - exact.deflection_ratio, rel=1e-4)


@pytest.mark.long
def test_soft_spring_is_caught_and_exact_constraint_has_none(outcome):
    soft = ("plate.youngs_modulus=20 MPa", "plate.elements=[10,3]", "corner.reaction=none")
    assert failed(outcome("paper-table-3", *soft, "corner.penalty_scale=0.7")) == {"numerical error"}
    exact = outcome("paper-table-3", *soft, "corner.constraint=exact", "plate.element=quad9")
    assert "contact spring" not in {check.name for check in exact.checks}
    assert failed(exact) == set()


@pytest.mark.long
def test_mesh_that_locks_is_caught(outcome):
    """Linear triangles a hundred times too stiff in bending look rigid; quadratic ones show that the plate is not."""
    slender = ("vehicle.width=0.2", "plate.youngs_modulus=20 GPa", "damping.ratio=0.2", "plate.element=tri3")
    assert "numerical error" in failed(outcome("paper-abaqus", *slender))


def test_give_of_a_patch_converges_to_that_of_richer_elements():
    changes = ("corner.patch_length=1", "corner.constraint=exact")
    gaps = []
    for n in (20, 40, 80):
        plan = fe_plan(*changes, f"plate.elements=[{n},{3 * n // 10}]")
        gaps.append(abs(plan.deflection_ratio - plan.other_deflection_ratio) / plan.deflection_ratio)
    assert gaps[0] < 0.06
    assert np.all(np.diff(np.log2(gaps)) < -1.0)


def test_large_meshes_are_judged_by_a_coarser_one():
    plate = read_scene("paper-abaqus", ("plate.elements=[400,120]",))[0].plate
    assert plate is not None
    assert comparable_plate(plate).elements == (200, 60)
    assert comparable_plate(plate.model_copy(update={"elements": (1600, 625)})).elements == (200, 78)
    quadratic = plate.model_copy(update={"elements": (8, 4), "element": "tri6"})
    assert comparable_plate(quadratic).elements == (16, 8)


def test_a_refined_plate_keeps_all_but_counts_and_kind():
    """Counts are floored, or rounded as asked, and no less than the least."""
    plate = read_scene("paper-abaqus", ("plate.elements=[21,5]", "plate.distortion=0.1"))[0].plate
    assert plate is not None
    assert refined(plate).counts == (42, 10)
    assert refined(plate, 0.5).counts == (10, 2)
    assert refined(plate, 1.0 / 1.5, least=4, whole=round).counts == (14, 4)
    other = refined(plate, 1.0, "quad9")
    assert other == plate.model_copy(update={"element": "quad9"})


def test_corrupted_run_is_given_up(outcome):
    """Flutter at 5 000 times the stiffness: no use in ringing on to the end."""
    stiff = ("plate.youngs_modulus=1000 TPa", "plate.elements=[6,2]", "damping.kind=none")
    result = outcome("paper-table-3", *stiff)
    (ringing,) = (check.value for check in result.checks if check.name == "friction by ringing")
    assert ringing > CORRUPTED
    assert {"tail-slap reached", "friction by ringing"} <= failed(result)
    assert result.run.steps < 0.9 * result.fe_plan.expected_steps


def test_momentum_closes_with_exact_constraint_and_damping(outcome):
    """The reaction at the first instant is that of the velocities which the first step sees."""
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


def test_a_second_run_is_damped_where_the_scene_forbids_it(outcome):
    """Linear elements run quietly to 2e-5; the quadratic ones flutter, and damping does not change what they tell."""
    vehicle = ("vehicle.length=14.4", "vehicle.width=3.6", "impact.speed=18", "impact.angle=0.085", "wall=")
    plate = (
        "plate.elements=[22, 11]",
        "plate.lumping=row-sum",
        "plate.distortion=0.04",
        "impact.friction=0.9",
    )
    soft = ("plate.youngs_modulus=", "plate.first_frequency=92 Hz", "corner.penalty_scale=0.2")
    rest = ("corner.patch_length=3.6", "impact.restitution=0.19", "damping.kind=none")
    result = outcome("mash-tl4-sut", *vehicle, *plate, *soft, *rest)
    alike = attempt(
        damped_alike(on_plate(result.fe_plan, second_plates(result.fe_plan.plate)[0]), result.fe_plan)
    )
    assert result.fe_plan.model.loop.elastic_damping is None
    assert rings(alike)
    assert result.passed
    assert 1e-5 < largest(result.difference) < 5e-5
    assert largest(result.second.difference) < 1e-6


def test_only_the_kind_of_damping_is_left_open():
    for given, left in (
        (("damping.kind=none",), None),
        (("damping.kind=elastic-velocity", "damping.rate=20"), None),
        (("damping.kind=elastic-velocity", "damping.rate=20", "damping.ratio=0.1"), 0.1),
    ):
        plan = damped_freely(CornerCase(*read_scene("paper-table-3", given)))
        assert (plan.scene.damping and plan.scene.damping.ratio) == left
        assert plan.scene.damping is None or plan.scene.damping.kind is None
