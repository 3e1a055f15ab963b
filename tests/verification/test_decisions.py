"""Verify choices of the program for omitted keys."""

import math
import re
from dataclasses import replace

import pytest

from postprocess.units import SI, US
from tailslap.case.corner import corner_case, corner_run, decisions, numerical_error, static_models
from tailslap.case.corner.corner_plan import make_corner_plan
from tailslap.case.corner.corner_report import CornerReport, flutter_sentence
from tailslap.case.plate_input import Decision
from tailslap.case.resources import loop_seconds
from tailslap.scene.read import read_scene

SOFT = ("plate.youngs_modulus=", "plate.first_frequency=8 Hz")
DAMPED = ("damping.kind=elastic-velocity", "damping.rate=200")
FLUTTERS = ("plate.youngs_modulus=2 TPa", "impact.friction=0.8")


def fe_plan(*changes):
    return corner_case.CornerCase(*read_scene("mash-tl4-sut", ("wall=", *changes))).plan()


def decided(*changes):
    return {decision.key: decision.value for decision in fe_plan(*changes).decisions}


def test_shipped_scene_leaves_nothing_to_decide():
    """Linear elements and the penalty spring suit steel, and nothing grows."""
    assert decided() == {}
    assert fe_plan().model.parameters.elastic_damping is None


@pytest.mark.parametrize(
    ("length", "width"), [("4 m", "1.5 m"), ("10 m", "2438 mm"), ("19 m", "2.7 m"), ("6 m", "6 m")]
)
def test_elements_left_out_are_of_one_proportion(length, width):
    plan = fe_plan("plate.elements=", f"vehicle.length={length}", f"vehicle.width={width}")
    along, across = plan.plate.counts
    body = plan.case.body
    assert 0.8 < (body.length / along) / (body.width / across) < 1.8
    assert 90 <= along * across <= 150


def test_paper_plate_gets_the_paper_mesh():
    assert decided("plate.elements=") == {"plate.elements": (20, 6)}


def test_mesh_that_locks_gets_quadratic_elements():
    """Linear elements of a strip of 10 x 0.1 m lock."""
    strip = ("vehicle.width=0.1", "plate.elements=[20, 6]")
    assert decided(*strip)["plate.element"] == "quad9"
    linear, quadratic = fe_plan(*strip, "plate.element=quad4"), fe_plan(*strip)
    assert quadratic.deflection_ratio > 5.0 * linear.deflection_ratio
    assert linear.plate.element == "quad4"
    assert not any(decision.key == "plate.element" for decision in linear.decisions)
    companions = [
        next(corner_run.companion_plates(fe_plan(*changes)))[0]
        for changes in ((), (*strip, "plate.element=quad4"))
    ]
    assert [plate.element for plate in companions] == ["quad4", "quad9"]


@pytest.mark.long
def test_constraint_left_open_is_exact_where_the_spring_would_be_seen():
    assert decided(*SOFT)["corner.constraint"] == "exact"
    assert decided("plate.start=unstressed")["corner.constraint"] == "exact"
    for change in ("corner.penalty_scale=2", "corner.constraint=penalty", "corner.damping_ratio=0.1"):
        assert "corner.constraint" not in decided(*SOFT, change)
        assert fe_plan(*SOFT, change).model.parameters.corner.stiffness > 0.0


def test_damping_is_decided_unless_the_scene_says_what_it_wants():
    rate = decided(*FLUTTERS)["damping.rate"]
    assert rate > 0.0
    assert "damping.rate" not in decided(*FLUTTERS, "damping.kind=none")
    chosen = fe_plan(*FLUTTERS, "damping.kind=elastic-velocity", "damping.rate=7")
    assert chosen.model.parameters.elastic_damping.rate == 7.0
    assert chosen.decisions == ()
    lighter = decided(*FLUTTERS, "damping.ratio=0.002")["damping.rate"]
    assert 0.0 < lighter < rate  # it takes growth off, and is no word on the rest
    assert decided(*FLUTTERS, "damping.ratio=0.5") == {}


SLENDER = ("vehicle.width=0.6", "plate.youngs_modulus=1e10", "plate.elements=[20, 6]", "impact.friction=0.47")
"""A strip whose first mode, of 3.4 Hz, would not follow its loads with the damping that its flutter would take."""


def test_damping_that_would_hold_a_soft_plate_back_comes_after_a_run_without():
    plan = corner_case.CornerCase(*read_scene("mash-tl4-sut", ("wall=", *SLENDER)))
    first, again = plan.plan(), make_corner_plan(plan, more_damping=4.0)
    assert first.growth.overdamps
    assert first.model.parameters.elastic_damping is None
    assert "sufficient damping would change the result" in first.decisions[-1].text
    assert flutter_sentence(first).startswith("possible")
    assert again.model.parameters.elastic_damping.rate == 4.0 * decisions.suppressing_rate(again.growth)
    assert "the first run oscillated" in again.decisions[-2].text
    assert not decisions.harms(plan, first.plate, first.model, first.growth, deflection_ratio=1e-4)
    unseen = decisions.open_damping(first.original, first.growth)
    assert [decision.key for decision in unseen] == ["damping.kind", "damping.rate"]


def test_damping_that_would_take_an_oscillation_off_comes_after_a_run_without():
    """An unstressed plate of 25 Hz oscillates by 8e-4 of v_GY.

    Damping against flutter halved the oscillation.
    """
    swings = ("plate.first_frequency=25 Hz", "plate.elements=[40, 12]", "plate.start=unstressed")
    soft = fe_plan("plate.youngs_modulus=", *swings, "corner.patch_length=1", "corner.constraint=exact")
    assert soft.growth.rate > 0.0
    assert soft.model.parameters.elastic_damping is None
    steel = ("plate.youngs_modulus=2 TPa", *swings[1:], "corner.patch_length=1", "corner.constraint=exact")
    stiff, rough = fe_plan(*steel), fe_plan(*steel, "corner.friction=0.8")
    assert stiff.growth.rate > 0.0
    assert stiff.model.parameters.elastic_damping is not None
    # The part of friction due to the oscillation would be missing.
    assert rough.model.parameters.elastic_damping is None


@pytest.mark.parametrize("modulus", ["20 GPa", "200 GPa", "2 TPa"])
def test_an_oscillation_adds_friction_however_stiff_the_plate(modulus, outcome):
    """The reaction changes sign, and friction follows its magnitude."""
    swinging = (f"plate.youngs_modulus={modulus}", "plate.start=unstressed", "impact.friction=0.3")
    free, still = (outcome("mash-tl4-sut", *swinging, *how) for how in (("damping.kind=none",), DAMPED))
    added = free.fe_history["normal_impulse_magnitude"][-1] / abs(free.fe_history["normal_impulse"][-1]) - 1.0
    assert 0.06 < added < static_models.ADDED_FRICTION + 0.01
    change = max(abs(free.difference[name] - still.difference[name]) for name in free.difference)
    assert 0.2 < change / still.error.damping < 1.5


def test_what_rang_is_not_held_to_the_friction_of_its_oscillation(outcome):
    """Friction of 0.8 makes the unstressed plate flutter."""
    damped = outcome("paper-table-3", "plate.start=unstressed", "corner.friction=0.8")
    assert damped.attempts == 2
    assert damped.passed
    damped_plan = damped.fe_plan
    assert damped_plan.rang
    quiet = replace(damped_plan, rang=False)
    stated = numerical_error.numerical_error(quiet, damped.difference, damped.companions).damping
    added = static_models.friction_lost(damped_plan.case, damped_plan.model.parameters.elastic_damping.rate)
    assert stated == pytest.approx(damped.error.damping + added)
    assert added > 3e-4


@pytest.mark.parametrize(("law", "adds"), [("drag", True), ("signed", False), ("none", False)])
def test_only_friction_on_the_magnitude_is_added_to(law, adds):
    """Halved as the friction is, as long as that is little."""
    friction = () if law == "none" else ("corner.friction=0.02",)
    lower = ("corner.friction=0.01",) if friction else ()
    scenes = (
        read_scene("paper-table-3", (f"corner.reaction={law}", *change)) for change in (friction, lower)
    )
    plan, less = (corner_case.CornerCase(*scene) for scene in scenes)
    assert (static_models.friction_lost(plan, 1e9) > 0.0) is adds
    twice = 2.0 * static_models.friction_lost(less, 1e9)
    assert static_models.friction_lost(plan, 1e9) == pytest.approx(twice, rel=0.05)
    half = 2.0 * math.log(2.0) / plan.motion.strike.t
    complete = static_models.friction_lost(plan, 1e9)
    assert static_models.friction_lost(plan, half) == pytest.approx(0.5 * complete)


def test_check_says_what_will_come():
    for changes, words in (
        (("corner.reaction=none",), "none"),
        ((), "harmless"),
        (FLUTTERS, "suppressed"),
        ((*FLUTTERS, "damping.kind=none"), "EXPECTED"),
        ((*FLUTTERS, "damping.kind=elastic-velocity", "damping.rate=1"), "EXPECTED"),
        (("impact.speed=0.25", "plate.youngs_modulus=2e12", "corner.reaction=none"), "suppressed"),
    ):
        assert flutter_sentence(fe_plan(*changes)).startswith(words), changes


def test_what_could_not_be_analysed_is_not_called_harmless():
    analysed = fe_plan()
    unknown = replace(
        analysed, growth=replace(analysed.growth, rate=math.nan, exponent=math.nan, by_coarser=True)
    )
    assert flutter_sentence(unknown).startswith("not analysed")
    assert decisions.open_damping(unknown.case, unknown.growth) == ()
    rings = replace(unknown.growth, ripple_rate=3.0)
    assert decisions.suppressing_rate(rings) == 3.0


@pytest.mark.parametrize(("changes", "key"), [
    (("damping.rate=5",), "damping.rate"), (("damping.kind=elastic-velocity",), "damping.rate"),
    (("damping.kind=none", "damping.ratio=0.1"), "damping.ratio"),
    (("damping.kind=viscous",), "damping.kind"),
    (("plate.element=tri6", "plate.lumping=row-sum"), "plate.lumping"),
    (("verify.tolerance=2",), "verify.tolerance"), (("plate.start=loud",), "plate.start"),
])  # fmt: skip
def test_keys_that_exclude_each_other(changes, key, refused):
    assert refused(read_scene, "mash-tl4-sut", changes) == key


def test_the_certainty_tells_flexibility_from_discretisation_error(outcome):
    stiff, bending = outcome("mash-tl4-sut"), outcome("mash-tl4-sut", "wall=", *SOFT, "corner.patch_length=1")
    agree = "Finite elements and rigid-body method agree within 0.00023 %; discretisation error at most"
    assert CornerReport(stiff).headline.certainty.startswith(agree)
    assert stiff.passed
    assert bending.passed
    soft = ("wall=", "plate.youngs_modulus=30 MPa", "corner.patch_length=1")
    softer = outcome("mash-tl4-sut", *soft, "plate.elements=[40, 12]")  # its companion resolves the patch
    assert softer.passed
    sentence = (
        r"Vehicle flexibility changes the motion by at most (\S+) %; discretisation error at most (\S+) %\."
    )
    numbers = re.match(sentence, CornerReport(softer).headline.certainty)
    assert numbers
    assert 0.9 < float(numbers[1]) <= 1.1
    assert float(numbers[2]) < 0.1
    demanded = outcome("mash-tl4-sut", *soft, "verify.tolerance=1e-3")
    assert [check.name for check in demanded.checks if not check.passed] == ["agreement with rigid"]


K102 = (
    *("vehicle.length=12.243098673690618", "vehicle.width=2.58995038378025", "vehicle.mass=8000"),
    *("impact.speed=13.878698517657892", "impact.angle=0.6839370480475161", "impact.friction=0.3"),
    *("impact.restitution=0.2", "plate.thickness=0.05", "plate.youngs_modulus=24359234.755820096"),
    *("plate.start=unstressed", "corner.reaction=none", "corner.patch_length=2.7923951135100524"),
    *("damping.ratio=0.027299117020856925", "plate.element=quad4"),
)
H66 = (
    *("vehicle.length=7.009653309110211", "vehicle.width=6.341072061123666", "vehicle.mass=8000"),
    *("impact.speed=25.60599018560078", "impact.angle=0.16898924044464717", "impact.friction=0.3"),
    *("impact.restitution=0.2", "plate.thickness=0.05", "plate.youngs_modulus=365367219.27131575"),
    *("plate.elements=[16, 4]", "plate.start=unstressed", "plate.element=quad4"),
)


@pytest.mark.long
@pytest.mark.parametrize(
    ("scene", "spring"), [(K102, "3.078623534623418"), (H66, "5.9036618384829245")], ids=["k102", "h66"]
)
def test_spring_that_rings_with_the_plate_does_not_pass(scene, spring):
    """Unstressed plates whose penalty spring changed omega by 1e-2."""
    changes = ("wall=", *scene, f"corner.penalty_scale={spring}")
    plan = corner_case.CornerCase(*read_scene("mash-tl4-sut", changes))
    exact = corner_case.CornerCase(*read_scene("mash-tl4-sut", ("wall=", *scene, "plate.element=quad9")))
    ringing, right = plan.run(), exact.run()
    off = max(abs(value / right.fe[name] - 1.0) for name, value in ringing.fe.items())
    stated = ringing.error.total
    assert right.fe_plan.case.scene.corner.constraint == "exact"
    assert not ringing.passed or off < 1.5 * stated
    assert math.isfinite(stated)


def test_a_costly_material_is_reckoned_with():
    """7.5 ns at nine points of quad9 beside 39 ns an element."""
    laws = (), ("material.law=neo-hookean",)
    linear, neo_hookean = (read_scene("paper-table-3", changes)[0] for changes in laws)
    seconds = [loop_seconds(scene, "quad9", (20, 6), 1000.0) for scene in (linear, neo_hookean)]
    assert seconds == pytest.approx([120e3 * 39e-9, 120e3 * (39.0 + 9 * 7.5) * 1e-9], rel=1e-12)


@pytest.mark.parametrize(("key", "value", "si", "us"), [
    ("contact.patch_length", 1.02, "1.02 m", "3.35 ft"),
    ("trailer.0.hitch_length", 1.0, "1 m", "3.28 ft"),
    ("damping.rate", 123.4, "123 1/s", "123 1/s"),
    ("time.safety_factor", 0.7, "0.7", "0.7"),
    ("plate.elements", (16, 4), "[16, 4]", "[16, 4]"),
])  # fmt: skip
def test_a_decision_states_its_value_with_the_unit(key, value, si, us):
    """Lengths follow the units of the reader."""
    text = Decision(key, value, "the reason").text
    assert SI.rendered(text) == f"{key} = {si}: the reason"
    assert US.rendered(text) == f"{key} = {us}: the reason"
