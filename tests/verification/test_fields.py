"""Verify that fields of a run agree with its history."""

import functools

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fem.explicit.time_loop import State
from fem.run.observers import SnapshotKeeper
from fem.stability.deformed import element_stress
from postprocess.fields.series import read_fields, write_fields
from tailslap.case.corner import corner_run as corner_run
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact import run as impact_run
from tailslap.case.impact.case import ImpactCase
from tailslap.case.run_fields import field_series
from tailslap.scene.read import read_scene

KEPT = "output.fields=6"


@functools.cache
def corner(*changes):
    return corner_run.attempt(CornerCase(*read_scene("paper-table-3", changes)))


@functools.cache
def impact(*changes):
    return impact_run.attempt(ImpactCase(*read_scene("impact-mash-tl4-sut", changes)))


def series(outcome):
    return field_series(outcome.fe_plan.model, outcome.run.snapshots)


@pytest.mark.parametrize("ran", [corner, impact])
def test_fields_agree_with_the_history(ran):
    """Strain energy and velocity of the centre equal those of the rows."""
    outcome = ran(KEPT)
    fields, history, parameters = series(outcome), outcome.run.history, outcome.fe_plan.model.parameters
    rows = np.searchsorted(history["t"], fields.t - 1e-12)
    assert_allclose(history["t"][rows], fields.t, rtol=0, atol=1e-12)
    assert (fields.t[0], fields.t[-1]) == (0.0, history["t"][-1])
    volumes = parameters.table.weights.sum(axis=0)
    energy = (fields.elemental["strain_energy_density"] * volumes).sum(axis=1)
    # At the tail-slap positions and energy are interpolated apart from each other.
    assert_allclose(energy[:-1], history["strain_energy"][rows][:-1], rtol=1e-9, atol=1e-12)
    share = parameters.mass / parameters.mass.sum()
    assert_allclose(
        np.einsum("n,tnc->tc", share, fields.nodal["velocity"]),
        np.array([history["v_gx"][rows], history["v_gy"][rows]]).T,
        rtol=1e-6,
        atol=1e-6,
    )


@pytest.mark.parametrize("ran", [corner, impact])
def test_a_run_with_fields_has_the_bits_of_one_without(ran):
    with_fields, without = ran(KEPT).run, ran().run
    assert without.snapshots is None
    assert len(with_fields.snapshots.t) == 6
    for name, values in without.history.items():
        assert_array_equal(with_fields.history[name], values, err_msg=name)


def test_displacement_is_rigid_motion_and_what_is_elastic():
    fields = series(corner(KEPT))
    displacement, elastic = fields.nodal["displacement"], fields.nodal["elastic_displacement"]
    rigid = fields.points + displacement - elastic
    lengths = np.linalg.norm(np.diff(rigid[:, [0, -1]], axis=1), axis=-1)
    assert_allclose(lengths, lengths.mean(), rtol=1e-12)
    assert 1e-8 < np.abs(elastic).max() < 1e-4 < np.abs(displacement).max()


def test_a_stretched_plate_has_the_stress_of_the_closed_form(plate_model):
    """A stretch has the Kirchhoff stress F S F'.

    F = diag(1 + a, 1), S by plane stress.
    """
    model, stretch = plate_model(), 1.01
    strain = 0.5 * (stretch**2 - 1.0)
    modulus = 200e9 / (1.0 - 0.3**2)
    stresses = element_stress(model, model.discretisation.positions * [[stretch], [1.0]])
    expected = (modulus * strain * stretch**2, 0.3 * modulus * strain, 0.0, 0.5 * modulus * strain**2)
    for values, value in zip(stresses, expected, strict=True):
        assert_allclose(values, value, rtol=1e-9, atol=1.0)


def test_von_mises_and_principal_stress_of_pure_shear_and_tension():
    stress = series(corner(KEPT)).elemental
    one, two = stress["stress_principal_1"], stress["stress_principal_2"]
    assert (one >= two).all()
    assert_allclose(stress["stress_von_mises"], np.sqrt(one**2 - one * two + two**2), rtol=1e-9, atol=1e-3)


def test_the_file_has_every_bit(tmp_path):
    fields = series(corner(KEPT))
    again = read_fields(write_fields(tmp_path / "fields.npz", fields))
    assert again.cell_type == fields.cell_type == "quad"
    for name in ("points", "cells", "t"):
        assert_array_equal(getattr(again, name), getattr(fields, name))
    for stored, loaded in ((fields.nodal, again.nodal), (fields.elemental, again.elemental)):
        assert stored.keys() == loaded.keys()
        for name in stored:
            assert_array_equal(stored[name], loaded[name])


@pytest.mark.parametrize(
    ("element", "cell_type", "nodes"),
    [("quad9", "quad9", 9), ("tri3", "triangle", 3), ("tri6", "triangle6", 6)],
)
def test_cells_name_their_nodes_in_the_order_of_other_programs(element, cell_type, nodes, plate_model):
    """Corners are counter-clockwise, nodes on sides lie between them."""
    from meshes import plate_mesh

    cells = "quad" if element == "quad9" else "triangle"
    model = plate_model(
        elements=(6, 2), mesh=plate_mesh(10.0, 2.438, (6, 2), cells), plate={"element": element}
    )
    positions = model.discretisation.positions
    from tailslap.case.run_fields import _cells

    kind, connectivity = _cells(model)
    assert (kind, connectivity.shape[1]) == (cell_type, nodes)
    corners = 4 if element == "quad9" else 3
    for k in range(min(corners, nodes - corners)):
        between = positions[:, connectivity[:, [k, (k + 1) % corners]]].mean(axis=-1)
        assert_allclose(positions[:, connectivity[:, corners + k]], between, atol=1e-12)
    for elements in (connectivity, model.discretisation.cells):
        first, second, third = positions[:, elements[:, :3]].transpose(2, 0, 1)
        assert np.linalg.det(np.array([second - first, third - second]).T).min() > 0.0


def test_a_single_instant_is_the_end():
    nodal = (np.zeros((2, 3)), np.ones((2, 3)))
    keeper = SnapshotKeeper(1, 10.0, lambda state: nodal)
    keeper.look(np.zeros((1, 3)), State(*nodal, np.zeros(4), np.zeros(1)))
    assert_array_equal(keeper.finished(np.array([0.0, 1.0]), nodal).t, [1.0])


def test_fields_need_a_plate(refused):
    tables = ("plate=", "material=", "wall=", "output.fields=3")
    assert refused(read_scene, "paper-table-3", tables[:1] + tables[2:]) == "output"
