"""Verification: the highest frequency of large uniform plates, bounded by windows of them, against dense solutions."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg

from fem.model import plate_model as models
from fem.plate import windows as module
from fem.plate.spectrum import FREE, Hold, hold_of
from fem.plate.windows import Windows, element_stiffness
from fem.stability.deformed import deformed_frequency

ANGLES = (0.26, 0.13, 0.0)


def windows_of(model: Any) -> Windows:
    """The windows of a model's plate."""
    return Windows(model.discretisation, model.loop.mass, model.tangent_moduli, model.loop.hourglass)


def dense(model: Any, hold: Hold = FREE) -> float:
    """Highest circular frequency over all angles [rad/s]."""
    masses, unknowns = model.loop.mass, np.concatenate([hold.nodes, hold.nodes]).astype(int)
    unknowns[len(hold.nodes) :] += masses.size
    squares = []
    for across in hold.across:
        matrix = model.stiffness.toarray()
        matrix[np.ix_(unknowns, unknowns)] += hold.spring * np.outer(across, across)
        root = np.sqrt(np.tile(masses, 2))
        last = [root.size - 1] * 2
        squares.append(scipy.linalg.eigvalsh(matrix / np.outer(root, root), subset_by_index=last)[0])
    return float(np.sqrt(max(squares)))


@pytest.fixture
def small_windows(monkeypatch):
    """Several windows in a plate small enough for a dense solution, and every plate counts as large."""
    monkeypatch.setattr(module, "SIZE", 5)
    monkeypatch.setattr(module, "EVEN", 0.05)
    monkeypatch.setattr(models, "WINDOWS_FROM", 0)


@pytest.mark.parametrize("element", ["quad4", "quad4-reduced", "quad9"])
def test_an_element_s_stiffness_assembled_is_the_plate_s(plate_model, element):
    model = plate_model(elements=(5, 3), plate={"element": element})
    table, loop = model.discretisation.table, model.loop
    one = element_stiffness(table, model.tangent_moduli, loop.hourglass)
    found = module._assembled(one, table.connectivity, loop.mass.size).toarray()
    expected = model.stiffness.toarray()
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.usefixtures("small_windows")
@pytest.mark.parametrize("plate", [{}, {"element": "quad4-reduced"}, {"lumping": "row-sum"}], ids=str)
@pytest.mark.parametrize("scale", [0.0, 0.3, 3.0, 100.0])
@pytest.mark.parametrize("patch", [0.0, 2.0])
def test_bound_is_safe_and_close(plate_model, plate, scale, patch):
    """At most by the unevenness of the masses above, and by what windows of five elements miss."""
    corner = {"penalty_scale": scale or 1.0, "patch_length": patch}
    model = plate_model(elements=(22, 11), plate=plate, corner=corner)
    hold = hold_of(model.loop.corner, ANGLES) if scale else FREE
    windows, exact = windows_of(model), dense(model, hold)
    assert windows.even
    assert len(module._parts(22, np.array([21]))) > 1
    assert exact * (1.0 - 1e-12) <= windows.bound(hold).frequency <= 1.02 * exact


def test_bound_converges_with_the_size_of_windows(plate_model, monkeypatch):
    """Row-sum masses are even: what is left is what windows miss, and it goes."""
    monkeypatch.setattr(module, "EVEN", 0.05)
    model, apart = plate_model(elements=(40, 16), plate={"lumping": "row-sum"}), []
    exact = dense(model)
    for size in (2, 4, 8):
        monkeypatch.setattr(module, "SIZE", size)
        apart.append(windows_of(model).bound().frequency / exact - 1.0)
    assert apart[0] > 3.0 * apart[1] > 9.0 * apart[2] > 0.0
    assert apart[2] < 1e-3


def test_no_node_has_less_mass_than_its_elements_say(plate_model):
    """The elements' masses, less the factor, lie below the exact ones everywhere, and meet them at one node."""
    model = plate_model(elements=(22, 11))
    nodes = model.discretisation.table.connectivity
    shares, surplus = module._element_masses(nodes, model.loop.mass)
    assembled = np.bincount(nodes.ravel(), np.repeat(shares, nodes.shape[1])) / surplus
    assert surplus > 1.001
    assert (assembled / model.loop.mass).max() == pytest.approx(1.0, abs=1e-14)


def test_windows_are_all_of_the_plate(monkeypatch):
    monkeypatch.setattr(module, "SIZE", 5)
    for count in (1, 4, 7, 11, 33, 58):
        for held in ([], [0], [count - 1], list(range(count // 2, count))):
            parts = module._parts(count, np.array(held, dtype=int))
            assert [n for start, end in parts for n in range(start, end)] == list(range(count))
            assert len(parts) == 1 or min(end - start for start, end in parts) >= 5
            around = [(start, end) for start, end in parts if any(start <= n < end for n in held)]
            wide = [
                start <= max(0, held[0] - 5) and end >= min(count, held[-1] + 6)
                for start, end in around
                if held
            ]
            assert all(wide)


@pytest.mark.usefixtures("small_windows")
def test_a_large_uniform_plate_takes_its_step_from_the_bound(plate_model):
    model = plate_model(elements=(22, 11), corner={"penalty_scale": 30.0})
    exact = dense(model, hold_of(model.loop.corner, ANGLES))
    assert dense(model) < 0.5 * exact < exact * (1.0 + 1e-5) < model.highest_frequency < 1.02 * exact
    assert model.stable_time_step == pytest.approx(2.0 / model.highest_frequency, rel=1e-15)
    assert deformed_frequency(model, model.discretisation.positions) <= model.highest_frequency
    mode, node = model.highest_mode, model.loop.corner.nodes[0]
    assert np.hypot(*mode[:, node]) > 0.9 * np.linalg.norm(mode) == pytest.approx(0.9, rel=1e-9)


def test_a_window_of_each_size_is_looked_at(plate_model, monkeypatch):
    monkeypatch.setattr(module, "SIZE", 5)
    model, seen, plain = plate_model(elements=(22, 11)), set(), Windows._highest

    def spied(self: Windows, window: Any, hold: Hold) -> Any:
        seen.add((tuple(high - low for low, high in window), bool(hold.nodes)))
        return plain(self, window, hold)

    monkeypatch.setattr(Windows, "_highest", spied)
    windows_of(model).bound(hold_of(model.loop.corner, ANGLES))
    sizes = {(along, across) for along in (5, 6) for across in (5, 6)}  # 22 = 5 + 5 + 6 + 6, 11 = 5 + 6
    assert seen == {((6, 6), True), *((each, False) for each in sizes)}


@pytest.mark.usefixtures("small_windows")
@pytest.mark.parametrize(
    "given", [{"damping_ratio": 0.1}, {"bulk_viscosity": 0.06}, {"corner": {"damping_ratio": 0.1}}], ids=str
)
def test_damped_plates_take_theirs_from_lanczos(plate_model, given, monkeypatch):
    asked = plate_model(elements=(22, 11), **given)
    monkeypatch.setattr(models, "WINDOWS_FROM", 10**9)
    assert asked.stable_time_step == plate_model(elements=(22, 11), **given).stable_time_step


@pytest.mark.usefixtures("small_windows")
def test_uneven_and_distorted_plates_take_theirs_from_lanczos(plate_model, distorted_mesh, monkeypatch):
    monkeypatch.setattr(module, "EVEN", 1e-6)
    uneven, distorted = plate_model(elements=(22, 11)), plate_model(mesh=distorted_mesh)
    monkeypatch.setattr(models, "WINDOWS_FROM", 10**9)
    assert uneven.highest_frequency == plate_model(elements=(22, 11)).highest_frequency
    assert distorted.highest_frequency == plate_model(mesh=distorted_mesh).highest_frequency
