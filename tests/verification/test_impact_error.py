"""Verify the stated errors of strikes by forces of known shape."""

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from postprocess.units import percent_up
from solver.impact import Strike
from tailslap.case.check import evaluated
from tailslap.case.impact import answers, checks, error
from tailslap.case.impact.answers import ImpactAnswer

INTERVAL = 1e-4


def answer(impulse=1.0, duration=0.02, corner="rear", blip=0.0, force=0.0):
    """An impact of a front strike and another one, of even forces.

    The first has 1 N s. A small strike, `blip`, is between them; the stated peak forces equal impulses.
    """
    inputs = [("front", 0.0, 0.02, 1.0), ("front", 0.1, 0.001, blip), (corner, 0.2, duration, impulse)]
    names = ("corner", "start", "duration", "impulse", "peak_force", "end")
    rows = ((c, t, d, j, j, t + d) for c, t, d, j in inputs)
    strikes: Any = (SimpleNamespace(**dict(zip(names, row, strict=True))) for row in rows)
    t, pushes = INTERVAL * np.arange(3001.0), dict[str, np.ndarray]()
    for name, start, length, total in inputs:
        push = np.diff(total * np.clip((t - start) / length, 0.0, 1.0)) / INTERVAL
        pushes[name] = pushes.get(name, 0.0) + push
    history = {"t": t, "force_normal": np.append(0.0, sum(pushes.values())) + force}
    return ImpactAnswer(tuple(strikes), history, pushes=pushes)


def estimated(base, sequence, steps=()):
    """Stated errors, by default without an effect of the time step."""
    return error.estimate(base, sequence, steps or [base, base])


def stated(impulse, *sequence, steps=()):
    """Stated error of the second impulse [N s], without its constant part."""
    meshes, halving = ([answer(companion) for companion in part] for part in (sequence, steps))
    return impulse * (estimated(answer(impulse), meshes, halving)["strike_2.impulse"] - error.RESOLVED)


def test_two_meshes_tell_an_error_with_a_factor_of_three():
    """The stated error is three times that of the finer mesh.

    Results are q + h^p on meshes h = 2 and 1 in units of 0.01. The distance of another run is added.
    """
    coarse, fine = (1.0 + 0.01 * h**error.ORDER for h in (2.0, 1.0))
    assert stated(fine, coarse, fine) == pytest.approx(0.03, rel=1e-12)
    assert stated(1.05, coarse, fine) == pytest.approx(1.05 - fine + 0.03, rel=1e-12)
    assert stated(coarse, coarse, fine) == pytest.approx(coarse - fine + 0.03, rel=1e-12)


@pytest.mark.parametrize("order", [0.6, 1.0, error.ORDER])
def test_three_meshes_tell_an_error_of_any_order_with_a_factor_of_less(order):
    sequence = [1.0 + 0.01 * h**order for h in (4.0, 2.0, 1.0)]
    assert stated(sequence[-1], *sequence) == pytest.approx(0.0125, rel=1e-12)


@pytest.mark.parametrize("sequence", [
    (1.03, 1.02, 1.012), (1.03, 1.01, 1.02),  # too slowly; to and fro
    (1.02, 1.02, 1.01), (1.025, 1.02, 1.01),  # not at first; ever faster away
])  # fmt: skip
def test_three_meshes_that_do_not_converge_tell_no_order(sequence):
    *_, before, last = sequence
    assert stated(last, *sequence) == pytest.approx(3.0 * abs(before - last), rel=1e-9)


def test_luck_counts_as_the_assumed_order():
    """A last step of order 10 is small by chance."""
    assert error.safety(1024.0) == pytest.approx(1.25 / (2.0**error.ORDER - 1.0))


def test_the_time_step_and_the_mesh_do_not_cancel():
    """The effects of mesh and step have opposite signs.

    The stated error is three times that of the finer mesh, and three times that of its step.
    """
    coarse, halved, fine = (1.0 + 0.01 * h**error.ORDER - 0.01 * t**2 for h, t in ((2, 2), (2, 1), (1, 1)))
    assert stated(fine, halved, fine, steps=(coarse, halved)) == pytest.approx(0.03 + 0.03, rel=1e-12)


def test_what_all_meshes_share_comes_on_top():
    assert set(estimated(answer(), [answer()] * 2).values()) >= {error.RESOLVED}
    assert stated(1.0, 1.0, 1.0) == 0.0


def test_a_step_that_is_small_by_chance_counts_as_more():
    """A change of 4 % in duration states 2.8 % elsewhere."""
    errors = estimated(answer(1.0, 0.02), [answer(1.02, 0.0208), answer(1.0, 0.02)])
    factor = 3.0 / (2.0**error.ORDER - 1.0)
    for name in ("impulse", "peak_force"):
        assert errors[f"strike_2.{name}"] == pytest.approx(error.RESOLVED + math.sqrt(0.02 * 0.04) * factor)
    assert errors["strike_2.duration"] == pytest.approx(
        error.RESOLVED + 0.04 * factor + 0.5 * INTERVAL / 0.02
    )
    assert errors["strike_1.impulse"] == error.RESOLVED


def with_pushes(pushes, strikes=None):
    """An impact of these forces, and its strikes by them."""
    force = np.append(0.0, sum(pushes.values()))
    impact = ImpactAnswer((), {"t": INTERVAL * np.arange(force.size), "force_normal": force}, pushes=pushes)
    return dataclasses.replace(impact, strikes=strikes or impact.resampled())


@pytest.mark.parametrize(("touch", "longer"), [(0.0042, 0.5), (0.0058, 0.333), (0.003, 0.0), (0.008, 0.0)])
def test_a_touch_that_just_prolongs_a_strike_or_not_is_unknown_of_its_duration(touch, longer):
    """It is 10 ms after a strike of 20 ms."""
    force = np.zeros(1000)
    force[:200], force[295:300] = 1e3, touch * 200 * 1e3 / 5
    impact = with_pushes({"front": force})
    duration = estimated(impact, [impact, impact])["strike_1.duration"]
    half_row = 0.5 * INTERVAL / impact.strikes[0].duration
    assert duration == pytest.approx(error.RESOLVED + half_row + longer, abs=2e-3)


def test_every_strike_near_the_largest_is_assessed():
    """A third strike counts from nine tenths of the largest."""
    for size, corners in ((0.95, 3), (0.85, 2)):
        force = np.zeros(4000)
        force[:200] = force[1000:1200] = 1e3
        force[2000:2200] = size * 1e3
        assert len(error.assessed_strikes(with_pushes({"front": force}))) == corners


@pytest.mark.parametrize(
    ("rows", "power", "passes"), [(40.3, 1.0, True), (12.5, 0.0, False), (60.5, 0.0, True)]
)
def test_rows_that_do_not_resolve_a_strike_fail(rows, power, passes):
    """A half sine of 40 rows passes, 12 even rows fail."""
    phase = np.clip(np.arange(1001) / rows, 0.0, 1.0)
    force = np.diff(-np.cos(math.pi * phase) if power else phase)
    outcome: Any = SimpleNamespace(fe=with_pushes({"front": force}))
    (check,) = evaluated([checks.CHECKS["sampling"]], outcome)
    assert check.passed == passes, check.value


def test_a_strike_without_weight_is_none():
    """A strike of 4 % of the largest is ignored."""
    light, heavy = (error.assessed_strikes(answer(blip=blip)) for blip in (0.04, 0.06))
    assert [strike.corner for strike in light] == ["front", "rear"]
    assert [strike.corner for strike in heavy] == [
        "front",
        "front",
        "rear",
    ]  # the last is as large as the first
    assert set(estimated(answer(blip=0.04), [answer()] * 2)) == {
        f"strike_{k}.{name}" for k in (1, 2) for name in error.QUANTITIES
    }


@pytest.mark.parametrize("companion", [answer(corner="rear left"), answer(force=math.nan)])
def test_other_corners_or_a_run_that_diverged_bound_nothing(companion):
    for base, other in ((answer(), companion), (companion, answer())):
        assert set(estimated(base, [answer(), other]).values()) == {math.inf}
    assert set(estimated(answer(), [answer()] * 2, [answer(), companion]).values()) == {math.inf}
    assert percent_up(math.inf) == "unknown"


@pytest.mark.parametrize(("judged", "until"), [
    (answer(), 0.27), (answer(duration=0.047), 0.2 + 2.1 * 0.047), (answer(duration=0.09), 0.3),
    (answer(impulse=0.01), 0.3), (answer(impulse=2.0, blip=0.2), 0.27),
])  # fmt: skip
def test_other_meshes_run_as_long_as_a_strike_is_judged(judged, until):
    """Other meshes run to the end of the assessed strikes.

    They include 50 ms or 1.1 durations of the rear strike, and end with the run itself, in particular without a second
    strike. The largest strike counts even behind two assessed ones.
    """
    assert error.judged_until(judged) == pytest.approx(until, rel=1e-12)


def test_no_difference_is_stated_of_a_light_strike():
    """A strike below 5 % of the largest is excluded."""
    differences = {"strike_1.impulse": 0.01, "strike_2.impulse": 0.3, "strike_3.peak_force": -0.02}
    expected = {"strike_1.impulse": 0.01, "strike_3.peak_force": -0.02}
    assert error.of_weight(differences, answer(blip=0.049).strikes) == expected
    assert error.of_weight(differences, answer(blip=0.051).strikes) == differences
    assert error.of_weight({}, ()) == {}


def test_strikes_of_two_models_are_paired_by_their_weight_where_one_bounces_more():
    """A corner rebounds twice in one model and once in the other."""
    fe = [strike("front", 100.0), strike("front", 1.0), strike("rear", 50.0)]
    rigid_vehicle = [strike("front", 101.0), strike("front", 2.0), strike("front", 1.0), strike("rear", 51.0)]
    first = fe[:1] + fe[2:]
    for strikes, impulses in ((fe, {1: 101.0, 2: 2.0, 3: 51.0}), (first, {1: 101.0, 2: 51.0})):
        matched = answers.matched_strikes(strikes, rigid_vehicle)
        assert {k: match.impulse for k, match in matched.items()} == impulses
    assert answers.matched_strikes([strike("rear", 1.0)], rigid_vehicle) == {}
    differences = answers.differences(
        ImpactAnswer(tuple(fe), {}, 2), ImpactAnswer(tuple(rigid_vehicle), {}, 2)
    )
    assert differences["strike_3.impulse"] == pytest.approx(50.0 / 51.0 - 1.0)


def strike(corner, impulse):
    return Strike(corner, 0.0, 0.1, 10.0 * impulse, impulse)
