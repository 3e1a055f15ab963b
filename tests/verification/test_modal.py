"""Verify the modal model by rigid motion, conservation and full plates.

The finite-element run of the same scene has its matrices and start, but neither equations of motion nor integration.
"""

import functools
import json
import math

import numpy as np
import pytest
from shared_cases import LINEAR_TRUCK

from fem.modal import modal_model
from fem.modal.modal_model import integrate, modal_plate, modal_start, with_fewer_modes
from fem.modal.motion import ModalMeasures, accelerate, measure_rows
from fem.modal.motion import reaction as corner_reaction
from fem.start.inertia_relief import RigidStart, relieved_fields, to_global
from postprocess.comparison.quantities import KEYS
from tailslap.case import case_of
from tailslap.case.corner.corner_case import CornerCase
from tailslap.cli import DONE, WRONG_INPUT, _status
from tailslap.delivery import CHECK_FAILED
from tailslap.modal_analysis import modes_with_errors
from tailslap.modal_run import modal_run
from tailslap.scene.read import read_scene

SOFT = [pytest.param(modulus, marks=pytest.mark.long) for modulus in ("200 MPa", "20 MPa")]

START = RigidStart(0.26, 0.707, 25.053)
DURATION = 0.3839597
TWENTY_HERTZ = "plate.youngs_modulus=6865876000"
"""Makes the first frequency of the 20 x 6 plate 20 Hz."""


@functools.cache
def plan(name, *changes):
    return CornerCase(*read_scene(name, changes)).plan()


@functools.cache
def run(modes, name, *changes):
    return modal_run(plan(name, *changes), modes)


def motion(plate, modal, steps):
    state = modal_start(plate, modal, START, relieved_fields(plate, START))
    return integrate(modal, state, DURATION, steps)


def largest(values, reference):
    return max(abs(values[name] / reference[name] - 1.0) for name in KEYS)


def states(modes):
    """Positions and velocities of an oscillating plate under tension at its corner."""
    random = np.random.default_rng(1)
    samples = []
    for shapes in random.normal(size=(10, 2, modes)):
        corner = [0.0, random.uniform(1e-4, 1e-3), random.uniform(-0.3, 0.0)]
        samples.append((np.array([*corner, *(0.1 * shapes[0])]), np.array([0.1, 0.01, 0.7, *shapes[1]])))
    return samples


def moved(place, speed, rate, time):
    return place + time * speed + 0.5 * time**2 * rate, speed + time * rate


@pytest.mark.parametrize("reaction", ["drag", "none", pytest.param("signed", marks=pytest.mark.long)])
@pytest.mark.parametrize("constraint", ["penalty", pytest.param("exact", marks=pytest.mark.long)])
@pytest.mark.parametrize("modes", [0, 4])
def test_stiff_plate_moves_as_the_rigid_body(reaction, constraint, modes):
    change = (f"corner.reaction={reaction}", f"corner.constraint={constraint}", "plate.youngs_modulus=1e18")
    result = run(modes, "paper-table-3", *change)
    assert max(map(abs, result.difference.values())) < 1e-11
    assert result.passed


@pytest.mark.parametrize("constraint", ["penalty", "exact"])
def test_energy_is_kept_without_friction(plate_model, constraint):
    """2e-4 of the energy is elastic at 1 Hz."""
    plate = plate_model(plate={"youngs_modulus": 2e7}, corner={"constraint": constraint})
    energy = motion(plate, modal_plate(plate, 6), 200).history["energy"]
    assert np.ptp(energy) < 1e-13 * energy[0]


def test_momentum_is_the_reactions_impulse(plate_model):
    plate = plate_model(reaction="drag", plate={"youngs_modulus": 2e9})
    history = motion(plate, modal_plate(plate, 4), 1600).history
    from scipy.integrate import simpson

    impulse = simpson(history["reaction_normal"][:-1], x=history["t"][:-1])
    change = plate.mass * (history["v_gy"][-2] - history["v_gy"][0])
    assert impulse == pytest.approx(change, rel=1e-8)


def test_spin_of_a_free_plate(plate_model):
    """A plate without a wall rotates steadily, stretched by its spin."""
    plate = plate_model(plate={"youngs_modulus": 2e7})
    modal = modal_plate(plate, 6)
    free = modal.model._replace(compliance=1e300)
    q = 0.707**2 * free.growth / (free.squares - 0.707**2)
    place, speed = np.concatenate([np.zeros(3), q]), np.concatenate([[25.0, 0.0, 0.707], 0.0 * q])
    result = np.empty(9)
    accelerate(place, speed, free, np.empty((2, 6)), result)
    assert np.abs(result[2:]).max() < 1e-12
    lever = free.arm + free.corner @ q
    assert result[:2] / (0.707**2 * lever) == pytest.approx([-1.0, -1.0], rel=1e-9)


@pytest.mark.parametrize("reaction", ["none", "drag", "signed"])
def test_the_energy_changes_by_frictions_work(plate_model, reaction):
    """Power of R at the corner in any state.

    This includes the flexibility of omitted modes.
    """
    plate = plate_model(reaction=reaction, plate={"youngs_modulus": 2e7})
    model, step = modal_plate(plate, 5).model, 1e-5
    for place, speed in states(5):
        result = np.empty(8)
        accelerate(place, speed, model, np.empty((2, 5)), result)
        rows = [np.concatenate([[0.0], *moved(place, speed, result, s)]) for s in (-step, step)]
        measured = np.empty((2, len(ModalMeasures._fields)))
        measure_rows(np.array(rows), model, measured)
        change = dict(zip(ModalMeasures._fields, (measured[1] - measured[0]) / (2.0 * step), strict=True))
        wall = corner_reaction(place, speed, model)
        power = wall.sigma * wall.normal * change["slide"]
        exchanged = np.abs(result[3:] * speed[3:]).sum()
        assert abs(change["energy"] - power) < 1e-6 * (exchanged + abs(power))


def test_newtons_law_on_the_nodes(plate_model):
    """Inertia of all nodes, projected on modes, is reaction less stiffness."""
    plate = plate_model(reaction="drag", plate={"youngs_modulus": 2e7})
    plate_modes, count, step = modal_plate(plate, 5), 5, 2e-4
    model = plate_modes.model._replace(flexibility=np.zeros((3, 3)))
    masses = plate.parameters.mass
    body = plate.discretisation.positions
    body = body - (body @ masses / masses.sum())[:, None]
    shapes = plate_modes.weighted / masses

    def nodes(place):
        shape = body + np.tensordot(place[3:], shapes, 1)
        turn = to_global(-place[2])
        corner = turn @ (model.arm + model.corner @ place[3:])
        return turn @ shape + (place[:2] - corner)[:, None]

    for place, speed in states(count):
        result = np.empty(3 + count)
        accelerate(place, speed, model, np.empty((2, count)), result)
        before, now, after = (nodes(moved(place, speed, result, s)[0]) for s in (-step, 0.0, step))
        inertia = masses * (before - 2.0 * now + after) / step**2
        wall, turn = corner_reaction(place, speed, model), to_global(-place[2])
        force = np.array([wall.sigma * wall.normal, wall.normal])
        in_modes = np.tensordot(shapes, turn.T @ inertia, ((1, 2), (0, 1)))
        expected = model.corner.T @ turn.T @ force - model.squares * place[3:]
        assert in_modes == pytest.approx(expected, rel=1e-4, abs=0.01)
        assert inertia.sum(axis=1) == pytest.approx(force, rel=1e-4, abs=0.01)
        arm = nodes(place) - place[:2, None]
        assert abs((arm[0] * inertia[1] - arm[1] * inertia[0]).sum()) < 1e-4 * np.abs(arm * inertia).sum()


def test_order_in_the_time_step(plate_model):
    plate = plate_model(reaction="drag", plate={"youngs_modulus": 2e7})
    modal = modal_plate(plate, 1)
    exact = motion(plate, modal, 1600).strike
    errors = [largest(motion(plate, modal, steps).strike, exact) for steps in (25, 50, 100)]
    slopes = np.diff(np.log2(errors))
    assert np.all(np.abs(slopes + 4.0) < 0.2), slopes
    assert errors[-1] < 1e-9


def test_modes_taken_out_leave_their_flexibility(plate_model):
    plate = plate_model()
    reduced, few = with_fewer_modes(modal_plate(plate, 9), 4).model, modal_plate(plate, 4).model
    scale = np.sqrt(np.outer(*(2 * [few.flexibility.diagonal()])))
    assert np.abs((reduced.flexibility - few.flexibility) / scale).max() < 1e-9
    assert reduced.squares == pytest.approx(few.squares, rel=1e-12)


def test_all_modes_leave_nothing(plate_model):
    """The flexibility of one of 27 modes has rank one."""
    plate = plate_model(elements=(4, 2))
    remaining, complete = modal_plate(plate, 26).model.flexibility, modal_plate(plate, 0).model.flexibility
    scale = 1.0 / np.sqrt(complete.diagonal())
    sizes = np.linalg.eigvalsh(remaining * np.outer(scale, scale))
    assert sizes[-1] < 0.05
    assert np.abs(sizes[:2]).max() < 1e-12


@pytest.mark.parametrize("modes", [0, 1, 4])
@pytest.mark.parametrize("scene", ["paper-table-3", "paper-abaqus"])
def test_against_the_whole_plate_of_steel(outcome, scene, modes):
    modal, full = run(modes, scene), outcome(scene)
    assert largest(modal.values, full.fe) < 1e-8
    assert max(map(abs, modal.difference.values())) > 2e-6  # the rigid motion is not as near


SIGNED = pytest.param(("corner.reaction=signed",), marks=pytest.mark.long)


@pytest.mark.parametrize("scene", ["paper-table-3", "paper-abaqus"])
@pytest.mark.parametrize(
    "change",
    [(), ("corner.constraint=exact",), ("corner.patch_length=1",), ("plate.lumping=row-sum",), SIGNED],
)
def test_against_the_whole_plate_of_20_hertz(outcome, scene, change):
    modal, full = run(4, scene, TWENTY_HERTZ, *change), outcome(scene, TWENTY_HERTZ, *change)
    assert modal.frequencies[0] == pytest.approx(20.0, rel=2e-2)
    assert largest(modal.values, full.fe) < 5e-7


@pytest.mark.parametrize("scene", ["paper-table-3", "paper-abaqus"])
@pytest.mark.parametrize("modulus", ["200 GPa", "2 GPa", *SOFT])
@pytest.mark.parametrize("modes", [0, 1, 4])
def test_the_estimate_bounds_the_difference(outcome, scene, modulus, modes):
    """It is never below the true difference, nor six times above."""
    change = f"plate.youngs_modulus={modulus}"
    modal, full = run(modes, scene, change), outcome(scene, change)
    difference = largest(modal.values, full.fe)
    assert difference < modal.estimate.total < 6.0 * difference


@pytest.mark.parametrize("modulus", ["2 GPa", "200 MPa", "20 MPa"])
@pytest.mark.parametrize("modes", [0, 1, 2, 4])
def test_the_estimate_of_modes_left_out(modulus, modes):
    """Compare with forty modes at the tail-slap."""
    change = f"plate.youngs_modulus={modulus}"
    few, many = run(modes, "paper-abaqus", change), run(40, "paper-abaqus", change)
    assert largest(few.values, many.values) < 2.0 * few.estimate.modes


def test_it_says_when_more_modes_are_needed():
    changes = ("plate.youngs_modulus=2 GPa", "plate.element=quad4", "corner.constraint=penalty")
    softer = plan("paper-table-3", *changes)
    few, enough = modal_run(softer, 0, tolerance=5e-6), modal_run(softer, 4, tolerance=5e-6)
    assert [check.name for check in few.checks if not check.passed] == ["omitted modes"]
    assert enough.passed
    softest = modal_run(plan("paper-table-3", "plate.youngs_modulus=20 MPa"), 4, tolerance=1e-3)
    assert [check.name for check in softest.checks if not check.passed] == ["linear modes"]
    coarse = modal_run(plan("paper-table-3"), 4, steps=10, tolerance=1e-7)
    assert [check.name for check in coarse.checks if not check.passed] == ["time steps"]


def test_work_does_not_grow_with_stiffness_or_mesh():
    for change in ((), ("plate.youngs_modulus=20 TPa",), ("plate.elements=[40, 12]",)):
        result = run(4, "paper-table-3", *change)
        assert 100 <= result.steps <= 101
        assert result.iterations < 5 * result.steps


def test_a_run_that_does_not_strike(plate_model):
    plate = plate_model(reaction="drag")
    modal = modal_plate(plate, 2)
    state = modal_start(plate, modal, START, relieved_fields(plate, START))
    late = integrate(modal, state, 0.1, 20)
    assert late.strike is None
    assert "within the time limit" in late.end
    state[1][0] = 0.05
    stopped = integrate(modal, state, DURATION, 100)
    assert stopped.strike is None
    assert "stopped" in stopped.end
    state[0][3] = math.nan
    assert "converge" in integrate(modal, state, DURATION, 100).end


REFUSED = [("plate.start=unstressed", "plate.start"), ("damping.ratio=0.1", "damping")]
REFUSED += [("corner.damping_ratio=0.1", "corner.damping_ratio")]


@pytest.mark.parametrize(("change", "key"), REFUSED)
def test_what_it_does_not_have_is_refused(refused, change, key):
    assert refused(run, 4, "paper-table-3", change) == key


def test_command(capsys):
    assert _status(["modal", "paper-table-3"]) == DONE
    text = capsys.readouterr().out
    assert "0.3839597" in text
    assert "Estimated error" in text
    assert _status(["modal", "paper-table-3", "--modes", "1", "--tolerance", "1e-9"]) == CHECK_FAILED
    assert "Failed: omitted modes" in capsys.readouterr().out
    for count in ("0", "9999"):
        assert _status(["modal", "paper-table-3", "--modes", count]) == WRONG_INPUT
    capsys.readouterr()
    assert _status(["modal", "paper-abaqus", "--json", "--modes", "2"]) == DONE
    answer = json.loads(capsys.readouterr().out)
    assert (set(answer["modal"]), answer["cost"]["modes"]) == (set(KEYS), 2)
    assert answer["estimate"]["total"] < 1e-8


SLENDER = ["vehicle.length=20 m", "vehicle.width=1 m"]


@functools.cache
def frequencies(scene, *changes, count=6):
    return modes_with_errors(case_of(*read_scene(scene, changes)), count)[2]


@pytest.mark.parametrize(
    ("scene", "open_mesh"), [("mash-tl4-sut", ("plate.elements=", "wall=")), (LINEAR_TRUCK, ())]
)
def test_frequencies_on_an_automatic_mesh_are_those_of_a_slender_beam(scene, open_mesh):
    """Timoshenko's, and n c/(2 L) except lateral inertia of 1e-4."""
    modes = frequencies(scene, *SLENDER, *open_mesh)
    assert {mode["kind"] for mode in modes} == {"bending", "longitudinal"}
    for mode in modes:
        assert mode["error"] <= 5e-3
        assert abs(mode["difference"]) <= mode["error"] + 3e-4


@pytest.mark.parametrize("element", ["quad4", "tri6"])
@pytest.mark.parametrize(
    "shape", [SLENDER, ["vehicle.length=5 m", "vehicle.width=2 m"]], ids=["slender", "stocky"]
)
def test_stated_errors_bound_the_frequencies_of_a_given_mesh(element, shape):
    """The reference has quadratic elements a third as large."""
    coarse = frequencies(LINEAR_TRUCK, *shape, f"plate.element={element}", "plate.elements=[20, 4]")
    fine = frequencies(LINEAR_TRUCK, *shape, "plate.element=quad9", "plate.elements=[60, 12]")
    for mode, reference in zip(coarse, fine, strict=True):
        assert abs(reference["frequency"] / mode["frequency"] - 1.0) <= mode["error"]


def test_the_command_states_that_its_steps_are_compiled(monkeypatch, capsys):
    compile_once, kernels = modal_model.compile_once, []

    def compiled(compile_all, kernel, *arguments, on_compile):
        kernels.append(kernel)
        on_compile("compiling")
        compile_once(compile_all, kernel, *arguments, on_compile=on_compile)

    monkeypatch.setattr(modal_model, "compile_once", compiled)
    assert _status(["modal", "paper-table-3", "--modes", "1"]) == 0
    assert set(kernels) == {modal_model.run_to_strike}
    assert "tailslap: compiling\n" in capsys.readouterr().err


def test_the_force_has_the_band_of_rigid_vehicles():
    import tailslap

    modal, rigid = (run("paper-table-3").headline for run in (tailslap.modal, tailslap.rigid))
    assert modal.band == rigid.band
    interval = rigid.answer.partition("(")[2].partition(";")[0]
    assert interval.startswith("median ")
    assert interval in modal.answer
