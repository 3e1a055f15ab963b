"""Verify frequencies, modes and displacements of plates."""

import math
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from fem import cache
from fem.model import plate_model as models
from fem.plate import elastic, multigrid, spectrum, windows
from fem.plate.discretisation import hourglass_matrix
from fem.plate.elastic import ElasticSolver, Inverse
from fem.plate.free_modes import lowest_frequency
from fem.plate.lanczos import extend_by, largest_eigenpair
from fem.plate.spectrum import FREE, Spectrum
from fem.plate.support import corner_support
from fem.plate.windows import Windows
from fem.stability.deformed import deformed_frequency
from fem.start.inertia_relief import RigidStart, relieved_fields

ANGLES = (0.26, 0.13, 0.0)
MESHES = ((6, 3), (10, 3), (20, 6), (3, 12))


def damped_eigenvalue(model, angle, step, damping):
    """Largest eigenvalue with damping of plate and corner.

    The matrix is dt^2 K + 2 dt C.
    """
    masses, corner = model.parameters.mass, model.parameters.corner
    unknowns = np.concatenate([corner.nodes, corner.nodes + masses.size])
    across = np.kron((-np.sin(angle), np.cos(angle)), corner.weights)
    plate = 0.0 if damping is None else damping.toarray()
    matrix = step**2 * model.stiffness.toarray() + 2.0 * step * plate
    spring = step**2 * corner.spring + 2.0 * step * corner.dashpot
    matrix[np.ix_(unknowns, unknowns)] += spring * np.outer(across, across)
    return float(scipy.linalg.eigh(matrix, np.diag(np.tile(masses, 2)), eigvals_only=True)[-1])


@pytest.mark.parametrize("scale", [1e-3, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("elements", MESHES)
def test_bound_is_safe_at_every_angle_and_close(plate_model, elements, scale):
    model = plate_model(elements=elements, corner={"penalty_scale": scale})
    hold = corner_support(model.parameters.corner, ANGLES)
    corner_spectrum, highest = (
        Spectrum(model.stiffness, model.parameters.mass, hold),
        dense_frequency(model, hold),
    )
    assert highest <= corner_spectrum.bound <= (1.0 + spectrum.TOLERANCE) * highest
    assert corner_spectrum.frequency == pytest.approx(highest, rel=1e-5)
    assert model.highest_frequency == pytest.approx(highest, rel=1e-6)


@pytest.mark.parametrize("damping", [{"damping_ratio": 0.2}, {"corner": {"damping_ratio": 0.5}}])
def test_damped_step_is_safe_and_close(plate_model, damping):
    """dt^2 K + 2 dt C has eigenvalues below 4."""
    from fem.plate.discretisation import stiffness_matrix

    model = plate_model(elements=(6, 3), **damping)
    viscosity = model.parameters.viscosity
    matrix = viscosity and stiffness_matrix(model.discretisation.table, viscosity)
    step = model.undamped_time_step
    worst = max(damped_eigenvalue(model, angle, step, matrix) for angle in ANGLES)
    assert 4.0 * (1.0 - 2.0 * spectrum.TOLERANCE) < worst <= 4.0


def test_residual_is_in_the_bound(plate_model, monkeypatch):
    """Lanczos that ends too early has a safe bound."""
    model = plate_model()
    masses = model.parameters.mass
    exact = Spectrum(model.stiffness, masses).frequency
    monkeypatch.setattr(spectrum, "TOLERANCE", 0.03)
    monkeypatch.setattr("fem.plate.lanczos.GROWTH_LIMIT", np.inf)
    rough = Spectrum(model.stiffness, masses)
    assert rough.frequency < (1.0 - 1e-4) * exact
    assert rough.bound >= exact


def test_angles_that_are_lower_are_not_looked_at_closely(plate_model, monkeypatch):
    model, tolerances = plate_model(), []
    plain = Spectrum._largest

    def counted(self, *arguments):
        tolerances.append(arguments[-1])
        return plain(self, *arguments)

    monkeypatch.setattr(Spectrum, "_largest", counted)
    Spectrum(model.stiffness, model.parameters.mass, corner_support(model.parameters.corner, ANGLES))
    assert tolerances == [spectrum.TOLERANCE, spectrum.ROUGH, spectrum.ROUGH]


BASIS = 12


def chain(masses):
    """Unit masses between unit springs, both ends fixed.

    The eigenvalues are 2 - 2 cos(k pi/(n + 1)).
    """

    def product(vector):
        padded = np.pad(vector, 1)
        return np.asarray(2.0 * vector - padded[:-2] - padded[2:])

    return product


def started(size):
    return np.cos(1.7 * np.arange(size)) + 0.1


@pytest.mark.parametrize("masses", [1, 2, 5, 12, 13, 40, 150])
def test_chain(masses):
    value, vector = largest_eigenpair(extend_by(chain(masses)), started(masses), 1e-9, BASIS)
    assert value == pytest.approx(2.0 - 2.0 * math.cos(masses * math.pi / (masses + 1)), rel=1e-12)
    assert np.linalg.norm(chain(masses)(vector) - value * vector) <= 1e-8 * value


def test_start_within_few_unknowns_ends_with_theirs():
    """The start has three uncoupled unknowns, and Lanczos ends after them."""
    start = np.zeros(40)
    start[[3, 9, 20]] = 1.0, 2.0, 3.0
    value, mode = largest_eigenpair(extend_by(lambda vector: np.arange(40.0) * vector), start, 1e-9, BASIS)
    assert (value, abs(mode[20])) == (pytest.approx(20.0, rel=1e-12), pytest.approx(1.0, rel=1e-12))


def test_product_that_is_not_finite_is_an_error():
    with pytest.raises(FloatingPointError):
        largest_eigenpair(extend_by(lambda vector: vector * np.nan), started(30), 1e-4, BASIS)


def test_time_step_has_the_same_digits_whatever_the_rounding(plate_model, monkeypatch):
    """Products differ in the last bit, as with another library."""
    noise, plain = np.random.default_rng(1), extend_by
    meshes = ((6, 3), (20, 6), (40, 12))
    models = [plate_model(elements=elements, damping_ratio=0.05) for elements in meshes]

    def steps():
        spectra = (spectrum.Spectrum(model.stiffness, model.parameters.mass) for model in models)
        return np.array([item.stable_time_step() for item in spectra])

    def noisy(values):
        return values * (1.0 + 2e-16 * noise.choice((-1.0, 1.0), values.size))

    def rounded(product):
        return plain(lambda vector: noisy(product(vector)))

    exact = steps()
    monkeypatch.setattr(spectrum, "extend_by", rounded)
    assert 0.0 < np.abs(steps() / exact - 1.0).max() < 1e-10


START = RigidStart(0.26, 0.707, 25.053)
PLATES: list[dict[str, Any]] = (
    [{}] + [{"element": name} for name in ("quad9", "tri6", "quad4-reduced")] + [{"poissons_ratio": 0.45}]
)


def solver_of(model):
    """A solver of its own, that has solved nothing."""
    return Inverse(model.stiffness, model.parameters.mass, model.discretisation.positions)


@pytest.fixture
def all_large(monkeypatch):
    """Every plate counts as large, and has several levels."""
    monkeypatch.setattr(elastic, "LARGE", 0)
    monkeypatch.setattr(multigrid, "COARSEST", 30)


@pytest.mark.usefixtures("all_large")
@pytest.mark.parametrize("plate", PLATES, ids=str)
def test_iteration_gives_what_a_factorisation_gives(plate_model, plate):
    model = plate_model(elements=(40, 12), plate=plate)
    solver, body = solver_of(model), model.discretisation.positions
    masses = np.tile(model.parameters.mass, 2)
    load = masses * np.sin(3.0 * np.arange(masses.size) / masses.size)
    rigid = elastic.rigid_motions(body)
    load -= masses * (rigid @ np.linalg.solve(rigid.T @ (masses[:, None] * rigid), rigid.T @ load))
    expected, iterated = solver.factorised(load), solver(load)
    assert len(solver.multigrid._levels.levels) > 1
    assert not np.array_equal(iterated, expected)
    np.testing.assert_allclose(iterated, expected, rtol=0.0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.usefixtures("all_large")
def test_iteration_repeats_to_the_bit(plate_model):
    model = plate_model(elements=(40, 12))
    load = model.stiffness @ np.cos(np.arange(2.0 * model.parameters.mass.size))
    np.random.seed(1)  # noqa: NPY002
    first = solver_of(model)(load)
    np.random.seed(2)  # noqa: NPY002
    np.testing.assert_array_equal(first, solver_of(model)(load))


@pytest.mark.parametrize("plate", PLATES, ids=str)
def test_lowest_frequency_by_iteration(plate_model, plate, monkeypatch):
    model = plate_model(elements=(40, 12), plate=plate)
    expected = lowest_frequency(ElasticSolver(solver_of(model), 1.0))
    monkeypatch.setattr(elastic, "LARGE", 0)
    monkeypatch.setattr(Inverse, "factorised", None)
    assert lowest_frequency(ElasticSolver(solver_of(model), 1.0)) == pytest.approx(expected, rel=1e-8)


@pytest.mark.usefixtures("all_large")
def test_without_convergence_a_factorisation_takes_over(plate_model, monkeypatch):
    model = plate_model(elements=(40, 12))
    load = model.stiffness @ np.cos(np.arange(2.0 * model.parameters.mass.size))
    monkeypatch.setattr(multigrid, "MAX_ITERATIONS", 2)
    solver = solver_of(model)
    np.testing.assert_array_equal(solver(load), solver.factorised(load))


def test_start_takes_two_loads_and_statics_none_more(plate_model, monkeypatch):
    from fem.start.inertia_relief import elastic_energy, statics

    loads = []
    plain = Inverse._solved

    def noted(self, load, tolerance):
        loads.append(load)
        return plain(self, load, tolerance)

    monkeypatch.setattr(Inverse, "_solved", noted)
    cache.clear()
    model = plate_model(elements=(10, 3))
    fields = relieved_fields(model, START)
    statics(model, START)
    elastic_energy(model, START)
    assert len(loads) == 2
    span = 1e-4
    states = (RigidStart(0.26 - 0.707 * t, 0.707 + angular(model) * t, 25.053) for t in (span, -span))
    late, early = (relieved_fields(model, state).elastic for state in states)
    rate = (late - early) / (2.0 * span)
    np.testing.assert_allclose(fields.rate, rate, rtol=0.0, atol=1e-5 * np.abs(rate).max())


def angular(model):
    """Angular acceleration of the rigid body at the start [rad/s^2]."""
    from fem.start.inertia_relief import at_corner, rigid_accelerations

    body = model.discretisation.positions - at_corner(model, model.discretisation.positions)
    return rigid_accelerations(model, body, 0.26, 0.707, 25.053).angular


def windows_of(model):
    """The windows of a model's plate."""
    return Windows(
        model.discretisation, model.parameters.mass, model.tangent_moduli, model.parameters.hourglass
    )


def dense_frequency(model, hold=FREE):
    """Highest circular frequency over all angles [rad/s]."""
    masses, unknowns = model.parameters.mass, np.concatenate([hold.nodes, hold.nodes]).astype(int)
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
    """Several windows in a plate that is small enough for dense solutions."""
    monkeypatch.setattr(windows, "SIZE", 5)
    monkeypatch.setattr(windows, "MASS_SPREAD", 0.05)
    monkeypatch.setattr(models, "WINDOWS_FROM", 0)


@pytest.mark.usefixtures("small_windows")
@pytest.mark.parametrize("plate", [{}, {"element": "quad4-reduced"}, {"lumping": "row-sum"}], ids=str)
@pytest.mark.parametrize("scale", [0.0, 0.3, 3.0, 100.0])
@pytest.mark.parametrize("patch", [0.0, 2.0])
def test_bound_is_safe_and_close(plate_model, plate, scale, patch):
    """The bound exceeds the dense frequency by 2 % at most."""
    corner = {"penalty_scale": scale or 1.0, "patch_length": patch}
    model = plate_model(elements=(22, 11), plate=plate, corner=corner)
    hold = corner_support(model.parameters.corner, ANGLES) if scale else FREE
    plate_windows, exact = windows_of(model), dense_frequency(model, hold)
    assert plate_windows.are_representative
    assert len(windows._window_ends(22, np.array([21]))) > 1
    assert exact * (1.0 - 1e-12) <= plate_windows.bound(hold).frequency <= 1.02 * exact


def test_windows_have_the_hourglass_control_of_the_plate(plate_model):
    """A hundred times as stiff it has the highest mode."""
    model = plate_model(plate={"element": "quad4-reduced", "lumping": "row-sum"})
    control = model.parameters.hourglass
    stiff = control._replace(stiffness=100.0 * control.stiffness)
    plate = model.discretisation, model.parameters.mass, model.tangent_moduli
    matrix = model.stiffness + 99.0 * hourglass_matrix(model.discretisation.table, control, plate[1].size)
    exact = Spectrum(matrix, plate[1]).bound
    assert Windows(*plate, stiff).bound().frequency == pytest.approx(exact, rel=1e-6)
    assert exact > 1.5 * windows_of(model).bound().frequency


def test_bound_converges_with_the_size_of_windows(plate_model, monkeypatch):
    """Even row-sum masses leave the error of the windows alone."""
    monkeypatch.setattr(windows, "MASS_SPREAD", 0.05)
    model, errors = plate_model(elements=(40, 16), plate={"lumping": "row-sum"}), []
    exact = dense_frequency(model)
    for size in (2, 4, 8):
        monkeypatch.setattr(windows, "SIZE", size)
        errors.append(windows_of(model).bound().frequency / exact - 1.0)
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2] > 0.0
    assert errors[2] < 1e-3


def test_windows_are_all_of_the_plate(monkeypatch):
    monkeypatch.setattr(windows, "SIZE", 5)
    for count in (1, 4, 7, 11, 33, 58):
        for corner_nodes in ([], [0], [count - 1], list(range(count // 2, count))):
            parts = windows._window_ends(count, np.array(corner_nodes, dtype=int))
            assert [n for start, end in parts for n in range(start, end)] == list(range(count))
            assert len(parts) == 1 or min(end - start for start, end in parts) >= 5
            around = [(start, end) for start, end in parts if any(start <= n < end for n in corner_nodes)]
            first, last = (corner_nodes[0], corner_nodes[-1]) if corner_nodes else (count, 0)
            wide = [start <= max(0, first - 5) and end >= min(count, last + 6) for start, end in around]
            assert all(wide)


@pytest.mark.usefixtures("small_windows")
def test_a_large_uniform_plate_takes_its_step_from_the_bound(plate_model):
    model = plate_model(elements=(22, 11), corner={"penalty_scale": 30.0})
    exact = dense_frequency(model, corner_support(model.parameters.corner, ANGLES))
    most = model.highest_frequency
    assert dense_frequency(model) < 0.5 * exact < exact * (1.0 + 1e-5) < most < 1.02 * exact
    assert model.stable_time_step == pytest.approx(2.0 / model.highest_frequency, rel=1e-15)
    assert deformed_frequency(model, [model.discretisation.positions]) <= model.highest_frequency
    mode, node = model.highest_mode, model.parameters.corner.nodes[0]
    assert np.hypot(*mode[:, node]) > 0.9 * np.linalg.norm(mode) == pytest.approx(0.9, rel=1e-9)


def test_a_window_of_each_size_is_looked_at(plate_model, monkeypatch):
    monkeypatch.setattr(windows, "SIZE", 5)
    model, seen, plain = plate_model(elements=(22, 11)), set(), Windows._highest

    def spied(self, window, hold):
        seen.add((tuple(high - low for low, high in window), bool(hold.nodes)))
        return plain(self, window, hold)

    monkeypatch.setattr(Windows, "_highest", spied)
    windows_of(model).bound(corner_support(model.parameters.corner, ANGLES))
    sizes = {(along, across) for along in (5, 6) for across in (5, 6)}  # 22 = 5 + 5 + 6 + 6, 11 = 5 + 6
    assert seen == {((6, 6), True), *((size, False) for size in sizes)}


@pytest.mark.usefixtures("small_windows")
@pytest.mark.parametrize(
    "damping", [{"damping_ratio": 0.1}, {"bulk_viscosity": 0.06}, {"corner": {"damping_ratio": 0.1}}], ids=str
)
def test_damped_plates_take_theirs_from_lanczos(plate_model, damping, monkeypatch):
    model = plate_model(elements=(22, 11), **damping)
    monkeypatch.setattr(models, "WINDOWS_FROM", 10**9)
    assert model.stable_time_step == plate_model(elements=(22, 11), **damping).stable_time_step


@pytest.mark.usefixtures("small_windows")
def test_uneven_and_distorted_plates_take_theirs_from_lanczos(plate_model, distorted_mesh, monkeypatch):
    monkeypatch.setattr(windows, "MASS_SPREAD", 1e-6)
    uneven, distorted = plate_model(elements=(22, 11)), plate_model(mesh=distorted_mesh)
    monkeypatch.setattr(models, "WINDOWS_FROM", 10**9)
    assert uneven.highest_frequency == plate_model(elements=(22, 11)).highest_frequency
    assert distorted.highest_frequency == plate_model(mesh=distorted_mesh).highest_frequency
