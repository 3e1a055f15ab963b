"""Verify the stated numerical error by companions, known orders and oscillations."""

import math
from dataclasses import replace

import numpy as np
import pytest
from test_checks import failed, off_by

from tailslap.case.corner import static_models
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_plan import make_corner_plan
from tailslap.case.corner.numerical_error import (
    PART,
    SAFETY,
    Companion,
    distance_in_motion,
    mesh_error,
    numerical_error,
    rate_by_dashpot,
)
from tailslap.scene.read import read_scene


@pytest.fixture
def result(outcome):
    return outcome("paper-table-3")


def test_a_soft_spring_is_stated(result):
    """The error is in proportion to the compliance of the spring."""
    parameters = result.fe_plan.model.parameters
    spring = parameters.corner.constraint._replace(stiffness=1e-4 * parameters.corner.stiffness)
    soft = replace(
        result.fe_plan.model,
        parameters=parameters._replace(corner=parameters.corner._replace(constraint=spring)),
    )
    softened = replace(result, fe_plan=replace(result.fe_plan, model=soft))
    assert failed(softened) >= {"numerical error"}
    assert softened.error.contact_spring == pytest.approx(1e4 * result.error.contact_spring)


SWINGING = ("plate.start=unstressed", "corner.constraint=penalty", "damping.kind=none")


@pytest.mark.parametrize(("reaction", "adds"), [("drag", True), ("none", False)])
def test_a_dashpot_removes_the_oscillation_of_an_unstressed_plate(reaction, adds):
    """An exactly constrained plate has it, and the friction by it."""
    changes = (*SWINGING, f"corner.reaction={reaction}")
    still, free = (
        make_corner_plan(CornerCase(*read_scene("mash-tl4-sut", changes + how)))
        for how in (("corner.damping_ratio=0.1",), ())
    )
    error, without = (numerical_error(plan, {}, ()).damping for plan in (still, free))
    decay = rate_by_dashpot(still)
    lost = static_models.oscillation_lost(still.case, still.elastic_energy, still.model.mass, decay)
    by_friction = static_models.friction_lost(still.case, math.inf)
    assert without == 0.0 < lost
    assert (by_friction > 0.0) is adds
    assert error == pytest.approx(lost + by_friction)


@pytest.mark.parametrize("modulus", ["200 MPa", "2 GPa"])
def test_the_energy_that_a_run_loses_by_its_dashpot(modulus, outcome):
    """It is less than estimated, because a held corner lowers the frequency."""
    changes = (*SWINGING, "corner.damping_ratio=0.3", "corner.reaction=none", "verify.companion=false")
    run = outcome("mash-tl4-sut", *changes, f"plate.youngs_modulus={modulus}")
    lost = -run.history["damping_work"][-1] / run.fe_plan.elastic_energy
    stated = -math.expm1(-rate_by_dashpot(run.fe_plan) * run.history["t"][-1])
    assert 0.3 * stated < lost < stated


def test_a_companion_that_says_otherwise(result):
    """An error is required of a companion, unless the scene refuses it."""
    for companions, failing in (
        (off_by(result, 0.0), set()),
        (off_by(result, 1e-3), {"numerical error"}),
        ((Companion("made up", 2.0, {}),), {"numerical error"}),
        ((), {"numerical error"}),
    ):
        assert failed(result, companions=companions) == failing
    alone = replace(result, companions=())
    assert math.isnan(alone.error.total)
    unwanted = alone.fe_plan.case.with_changes({"verify.companion": False})
    assert failed(replace(alone, fe_plan=replace(alone.fe_plan, case=unwanted))) == set()


@pytest.mark.parametrize("refinements", [(0.5,), (2.0,), (0.5, 2.0), (2.0, 4.0), (0.5, 0.25)])
@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_the_error_of_a_mesh_of_known_order(refinements, order):
    """A value 1 + h**p has a known limit."""
    companions = [Companion("", r, {"omega": r**-order}) for r in refinements]
    stated = mesh_error({"omega": 1.0}, companions, order)
    extrapolated = 1.0 if len(refinements) == 1 else min(1.0, *(r**-order for r in refinements))
    assert stated == pytest.approx(1.0 - extrapolated + SAFETY * extrapolated)


def test_three_meshes_that_show_no_order():
    """A sequence that does not converge has the lowest order."""
    finest, no_order = {"omega": 0.0}, 1.0 / (math.sqrt(2.0) - 1.0)
    for values, expected in (((1.0, -1.0), 1.0), ((1.0, -3.0), 3.0)):
        companions = [Companion("", r, {"omega": value}) for r, value in zip((0.5, 2.0), values, strict=True)]
        assert mesh_error(finest, companions, 1.0) == pytest.approx(expected * (1.0 + SAFETY * no_order))


def test_oscillations_that_agree_by_chance_at_the_strike(result):
    """The second run has the same amplitude and a higher frequency.

    Both are in phase at the strike. The root mean square distance is the amplitude.
    """
    t, end = result.fe_history["t"], result.fe_history["t"][-1]
    slow = 1e-3 * result.rigid["omega"] * np.cos(10.0 * np.pi * (t / end - 1.0) / PART)
    faster = 1e-3 * result.rigid["omega"] * np.cos(14.0 * np.pi * (t / end - 1.0) / PART)
    rigid = result.rigid_history
    histories, companion_histories = (
        ({**rigid, "omega": rigid["omega"] + wave}, rigid) for wave in (slow, faster)
    )
    apart = distance_in_motion(histories, companion_histories, result.rigid, False)
    assert apart == pytest.approx(1e-3, rel=0.02)
    assert distance_in_motion(histories, histories, result.rigid, True) == 0.0
    companion = Companion("made up", 0.5, result.difference, apart)
    assert failed(result, companions=(companion,)) == {"numerical error"}
    broken = {**rigid, "omega": np.full(t.shape, np.nan)}, rigid
    assert distance_in_motion(histories, broken, result.rigid, True) == math.inf


def test_oscillations_that_drift_apart_and_meet_again(result):
    """Twenty and twenty-one periods are in opposite phase in the middle.

    The root mean square distance there is sqrt(2) amplitudes; a decaying part counts with its final amplitude.
    """
    rigid, t = result.rigid_history, result.fe_history["t"]
    share, size = t / t[-1], 1e-3 * result.rigid["omega"]
    for decay in (0.0, 3.0):
        amplitude = np.exp(-decay * share)
        more = lambda swings: size * amplitude * np.cos(2.0 * np.pi * swings * share)  # noqa: B023, E731
        histories, other = (({**rigid, "omega": rigid["omega"] + more(swings)}, rigid) for swings in (20, 21))
        at_end = np.sqrt(2.0) * 1e-3 * np.exp(-decay * 0.95)
        assert distance_in_motion(histories, other, result.rigid, True) == pytest.approx(at_end, rel=0.05)
        assert distance_in_motion(histories, other, result.rigid, False) < 0.3 * at_end
    companion = Companion("made up", 0.5, result.difference, 1e-3)
    assert failed(result, companions=(companion,)) == {"numerical error"}


def test_an_unstressed_plate_is_compared_with_its_companion_over_the_whole_motion(outcome):
    """The two oscillations differ by about one period at the tail-slap."""
    free = ("plate.start=unstressed", "corner.friction=0", "plate.youngs_modulus=153 GPa")
    result = outcome("paper-table-3", *free)
    at_strike = [
        abs(result.difference[name] - value) for name, value in result.companions[0].difference.items()
    ]
    assert result.companions[0].apart > 3.0 * max(at_strike)
    assert result.error.mesh > SAFETY * result.companions[0].apart


def test_runs_that_strike_late_are_compared_while_the_rigid_motion_lasts(result):
    rigid, t = result.rigid_history, result.fe_history["t"]
    ended = {name: np.where(t <= 0.97 * t[-1], column, np.nan) for name, column in rigid.items()} | {"t": t}
    histories, other = (({**rigid, "omega": factor * rigid["omega"]}, ended) for factor in (1.0, 1.001))
    share = np.sqrt(np.mean((rigid["omega"][(t >= 0.9 * 0.97 * t[-1]) & (t <= 0.97 * t[-1])]) ** 2))
    expected = 1e-3 * share / result.rigid["omega"]
    assert distance_in_motion(histories, other, result.rigid, False) == pytest.approx(expected, rel=1e-3)


def test_a_patch_that_no_companion_resolves_is_taken_for_a_point(result):
    """Two elements of a companion are required to resolve a patch."""
    stated = {}
    for patch in (None, 1.9, 2.1):
        case = result.fe_plan.case.with_changes({"corner.patch_length": patch})
        with_patch = replace(
            result, fe_plan=replace(result.fe_plan, case=case), companions=off_by(result, 1e-4)
        )
        stated[patch] = with_patch.error.mesh
    assert stated[None] == stated[1.9] == pytest.approx(SAFETY * 1e-4 / (math.sqrt(2.0) - 1.0))
    assert stated[2.1] == pytest.approx(SAFETY * 1e-4)


def test_a_companion_that_flutters_is_damped_for_its_own_mesh():
    """The finer mesh of an unstressed plate flutters faster than the run.

    With the damping of the run it was off by 1.5e-4, finer ones by 6e-7. A mesh half as fine has no patch.
    """
    changes = (
        "vehicle.length=3.278", "vehicle.width=0.5084", "vehicle.mass=1533", "impact.speed=12.175",
        "impact.angle=0.16434", "impact.friction=0.2666", "impact.restitution=0.5529", "wall=",
        "corner.friction=0.858", "corner.constraint=penalty", "corner.penalty_scale=19.23",
        "corner.damping_ratio=0.254", "corner.patch_length=0.3285", "plate.thickness=0.1144",
        "plate.youngs_modulus=", "plate.first_frequency=45.1", "plate.poissons_ratio=0.3276",
        "plate.start=unstressed", "plate.elements=[18,8]", "plate.element=quad4", "plate.lumping=row-sum",
        "plate.distortion=0.069",
    )  # fmt: skip
    outcome = CornerCase(*read_scene("mash-tl4-sut", changes)).run()
    (companion,) = outcome.companions
    assert companion.refinement == 2.0
    assert max(map(abs, companion.difference.values())) < 1e-5
    assert outcome.passed
