"""Verify meshes, constraints, patches and threads by runs to the tail-slap."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fem.plate.discretisation import corner_weights, discretise
from fem.run.corner import simulate
from fem.start.inertia_relief import RigidStart
from meshes import plate_mesh
from tailslap.case.corner.corner_case import CornerCase
from tailslap.scene.read import read_scene

THICKNESS = 0.053
START = RigidStart(0.26, 0.707, 25.053)


def worst(result):
    assert result.passed, [check for check in result.checks if not check.passed]
    return max(map(abs, result.difference.values()))


@pytest.mark.parametrize(
    "changes",
    [
        ("plate.distortion=0.2",), ("corner.constraint=exact",), ("corner.patch_length=1",),
        *(
            pytest.param(change, marks=pytest.mark.long)
            for change in (
                ("plate.element=tri3",), ("plate.element=tri6",),
                ("plate.element=quad9", "plate.elements=[8, 3]"),
                ("plate.element=quad4-reduced", "damping.ratio=0.05"), ("material.law=neo-hookean",),
                ("corner.damping_ratio=0.2",), ("damping.bulk_viscosity=0.06",),
                ("damping.ratio=0.05", "damping.bulk_viscosity=0.06", "corner.damping_ratio=0.3"),
                ("plate.element=tri3", "plate.distortion=0.2", "corner.reaction=none"),
            )
        ),
    ],
)  # fmt: skip
def test_every_feature_gives_the_rigid_answer(outcome, changes):
    assert worst(outcome("paper-table-3", *changes)) < 5e-6


def test_a_distorted_mesh_and_triangles_are_told_apart():
    """They are other meshes, not the same one by another name."""
    plain, moved, cut = (
        planned(*change).model for change in ((), ("plate.distortion=0.2",), ("plate.element=tri3",))
    )
    assert np.abs(plain.discretisation.positions - moved.discretisation.positions).max() > 0.05
    assert cut.parameters.table.connectivity.shape == (3, 240)


def test_the_exact_constraint_holds_the_corner_on_the_wall(outcome):
    result = outcome("paper-table-3", "corner.constraint=exact")
    assert np.abs(result.fe_history["gap"]).max() < 1e-14
    assert (result.fe_history["contact_energy"] == 0.0).all()
    assert np.abs(outcome("paper-table-3").fe_history["gap"]).max() > 1e-8


def test_the_penalty_tends_to_the_exact_constraint(outcome):
    """The gap is N/k, and its effect in proportion to 1/k."""
    exact = outcome("paper-table-3", "corner.constraint=exact").fe["t"]
    scales = (f"corner.penalty_scale={scale}" for scale in (0.1, 1.0, 10.0))
    errors = [outcome("paper-table-3", scale).fe["t"] - exact for scale in scales]
    assert_allclose(np.divide(errors[:-1], errors[1:]), 10.0, rtol=0.05)


@pytest.mark.long
def test_a_dashpot_and_bulk_viscosity_take_energy_out(outcome):
    for change in ("corner.damping_ratio=0.2", "damping.bulk_viscosity=0.3"):
        result = outcome("paper-table-3", "corner.reaction=none", "plate.start=unstressed", change)
        assert result.fe_history["damping_work"][-1] < -1e-3
        assert np.abs(result.fe_history["energy_error"]).max() < 1e-9 * result.fe_history["kinetic_energy"][0]


@pytest.mark.parametrize("length", [0.25, 0.8, 1.0, 9.999])
def test_the_patch_s_weighted_mean_is_the_corner_itself(length):
    """Resultant 1 and no moment, also for ends within an element."""
    d = discretise(plate_mesh(10.0, 2.438, (40, 4)), THICKNESS)
    nodes, weights = corner_weights(d, length)
    assert weights.sum() == pytest.approx(1.0, rel=1e-13)
    assert d.positions[:, nodes] @ weights == pytest.approx((0.0, 0.0), abs=1e-13)
    assert d.positions[0, nodes].min() <= -length * (1.0 - 1e-9)


def test_a_point_deflects_without_bound_and_a_patch_converges():
    """Each halving adds a constant deflection at a point alone."""
    held = ("corner.reaction=none", "corner.constraint=exact", "plate.start=unstressed")
    meshes = [f"plate.elements=[{n}, {3 * n // 10}]" for n in (10, 20, 40, 80)]
    patched = (*held, "corner.patch_length=2")
    point = np.diff([planned(*held, mesh).deflection_ratio for mesh in meshes])
    patch = np.diff([planned(*patched, mesh).deflection_ratio for mesh in meshes])
    assert point[2] == pytest.approx(point[1], rel=0.1)
    assert (np.abs(patch[1:] / patch[:-1]) < 0.45).all()
    assert abs(patch[2]) < 0.05 * point[2]


def planned(*changes):
    """Plan a model that does not run."""
    return CornerCase(*read_scene("paper-table-3", changes)).plan()


@pytest.mark.parametrize("threads", [2, pytest.param(3, marks=pytest.mark.long)])
def test_threads_give_the_same_answer_and_repeat_to_the_bit(plate_model, threads):
    model = plate_model(reaction="drag", elements=(30, 8), elastic_rate=1.0)
    alone = simulate(model, START, 0.384)
    first, second = (simulate(model, START, 0.384, threads=threads) for _ in range(2))
    for name, column in first.history.items():
        assert_array_equal(column, second.history[name])
    for name in ("t", "v_gx", "v_gy", "omega", "slide"):
        assert first.strike is not None
        assert alone.strike is not None
        assert first.strike.values[name] == pytest.approx(alone.strike.values[name], rel=1e-8)
