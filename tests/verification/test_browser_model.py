"""Verify the kernels of a page, natively and as WebAssembly."""

from typing import Any

import numpy as np
import pytest
from web_module import Module
from web_page import random_changes

import tailslap
from postprocess.signals.filters import FILTERS, force_curves
from tailslap.browser import model
from tailslap.case.of_arguments import case_of_scene
from tailslap.errors import InputError
from tailslap.validation.calibration import calibrated_band


def planar(name):
    try:
        model.demand_planar(case_of_scene(name, None))
    except InputError:
        return False
    return True


def calls_of(name: str, changes: Any = None) -> Any:
    """Return kernels and arguments of a scene."""
    case: Any = case_of_scene(name, changes)
    return model.model_of(case).calls


SCENES = [name for name in tailslap.scenes() if planar(name)]

FURTHER = [
    ("impact-mash-tl4-sut", {"vehicle.mass": "2450 lb", "contact.hardening": 4e5, "contact.friction": 0.6}),
    ("impact-mash-tl4-sut", {"vehicle.centre_of_mass": "4.5 m", "vehicle.yaw_inertia": 9e4, "impact.angle": "25 deg"}),
    ("impact-mash-tl3-car", {"contact.unloading_stiffness": "5 MN/m", "contact.restitution": None}),
    ("impact-mash-tl3-pickup", {"vehicle.mass": "5050 lb", "contact.plateau_force": None}),
    ("impact-mash-tl5-tractor-van", {"trailer.0.length": "40 ft", "strip.1.at": "40 ft", "trailer.0.hitch": "6.7 m"}),
    ("impact-mash-tl4-sut", {"strip": [
        {"at": "0 m", "stiffness": "2 MN/m", "plateau": "350 kN"},
        {"at": ["2.6 m", "10 m"], "inset": "0.1 m", "stiffness": "1 MN/m^2", "restitution": 0.1},
        {"at": "10 m", "stiffness": "2 MN/m", "unloading_stiffness": "9 MN/m", "initial_force": "20 kN"},
    ], "contact.stiffness": None, "contact.plateau_force": None}),
]  # fmt: skip


@pytest.mark.parametrize(("name", "changes"), [
    *((name, {}) for name in SCENES[::6]), *FURTHER[:-1], pytest.param(*FURTHER[-1], marks=pytest.mark.long),
])  # fmt: skip
def test_answers_are_those_of_the_functions_of_python(name, changes):
    """Motion, forces and band are those of `tailslap rigid`."""
    case: Any = case_of_scene(name, changes)
    built: Any = model.model_of(case)
    calls = built.calls
    kernel, arguments = calls["motion"]
    reason, _, verdict, count = kernel(*arguments)
    assert (reason, verdict) == (0, 0)
    (motion, paper), answer = arguments[-2:], case.answer
    columns = answer.columns
    assert motion.times[:count] == pytest.approx(columns["t"], rel=1e-15)
    for name, curve in zip(FILTERS, motion.curves, strict=True):
        column = columns["force_normal" if name == "raw" else f"force_normal_{name}"]
        np.testing.assert_allclose(curve[1:count], column[1:], atol=1e-9 * np.abs(column).max())
    assert motion.peaks == pytest.approx(list(answer.peaks.values()), rel=1e-10)
    expected = case.paper_method["mean_50ms"] if case.paper_method else np.nan
    assert paper.mean[0] == pytest.approx(expected, rel=1e-12, nan_ok=True)
    kernel, arguments = calls["band"]
    assert kernel(*arguments)[:3] == (0, 0, 0)
    band, (_, _, _, ranges, _, growth, *_, percentiles) = calibrated_band(case), arguments
    assert percentiles[1] == pytest.approx(band.limits, rel=1e-9)
    fractions = zip((item.key for item in built.ranges), ranges.fractions, strict=True)
    varied = {key: fraction for key, fraction in fractions if key not in band.fixed}
    assert varied == pytest.approx(band.variance_fractions, rel=1e-7)
    assert growth.ratio[0] == pytest.approx(band.growth, rel=1e-9)


@pytest.mark.parametrize(("size", "is_cut"), [(400, False), (257, True)])
def test_filters_of_a_page_are_those_of_signals(size, is_cut):
    """They agree to 1e-12 of the largest force, natively and as WebAssembly."""
    case: Any = case_of_scene("impact-mash-tl3-car", None)
    calls: Any = model.model_of(case).calls
    motion, interval = calls["motion"][1][-2], 2e-4
    force = np.random.default_rng(size).uniform(0.0, 1e5, size)
    force[0], force[-1] = 0.0, 1e4 if is_cut else 0.0
    motion.times[:size] = interval * np.arange(size)
    motion.values[1:size, motion.impulse] = np.cumsum(force[1:]) * interval
    calls = {"fill": (model.kernels.fill_forces, (motion, size, interval))}
    module = Module(calls)
    module.call("fill")
    kernel, arguments = calls["fill"]
    kernel(*arguments)
    raw = motion.curves[0, 1:size]
    for curves in (motion.curves, module["fill.motion.curves"]):
        for name, curve in force_curves(raw, interval).items():
            at = curves[[*FILTERS].index(name), 1:size]
            np.testing.assert_allclose(at, curve, rtol=0.0, atol=1e-12 * raw.max())


@pytest.mark.parametrize(("changes", "rest"), [
    ({"impact.friction": 3.0}, None), ({"impact.friction": 0.0}, 1.0), ({"impact.restitution": 1.0}, None),
])  # fmt: skip
def test_the_paper_s_method_has_an_answer_where_its_rules_hold(changes, rest):
    case: Any = case_of_scene("impact-mash-tl4-sut", changes)
    kernel, arguments = model.model_of(case).calls["motion"]
    kernel(*arguments)
    mean = arguments[-1].mean[0]  # type: ignore[attr-defined]
    assert (case.paper_method is None) == bool(np.isnan(mean)) == (rest is None)
    assert rest is None or mean == pytest.approx(case.paper_method["mean_50ms"], rel=1e-12)


def test_ends_of_ranges_are_those_of_the_command():
    """Ranges follow values that change on the page."""
    case: Any = case_of_scene("impact-mash-tl4-sut", None)
    built: Any = model.model_of(case)
    changes = {"vehicle.mass": 2240.0, "impact.speed": 12.0, "contact.friction": 0.6, "vehicle.length": 9.0}
    kernel, arguments = built.calls["band"]
    nominal, ranges = arguments[0], arguments[3]
    for key, value in changes.items():
        nominal[built.quantities.index(key), 0] = value
    kernel(*arguments)
    other: Any = case_of_scene("impact-mash-tl4-sut", changes)
    expected = {item.key: (item.lower, item.upper) for item in model.planar_ranges.impact_ranges(other)}
    assert np.isnan(ranges.ends[[item.key for item in built.ranges].index("contact.friction")]).all()
    for item, ends in zip(built.ranges, ranges.ends, strict=True):
        if item.key != "contact.friction":
            assert ends == pytest.approx(expected[item.key], rel=1e-12), item.key


@pytest.mark.parametrize(("key", "value", "reason"), [
    ("contact.initial_force", 4e5, model.kernels.PLATEAU), ("contact.restitution", 0.8, model.kernels.LINE),
    ("axle.1.position", 11.0, model.kernels.AXLE), ("axle.1.position", 4.0, model.kernels.AXLE_LOAD),
    ("vehicle.centre_of_mass", 10.5, model.kernels.CENTRE), ("vehicle.yaw_inertia", 10.0, model.kernels.INERTIA),
])  # fmt: skip
def test_impossible_values_are_refused(key, value, reason):
    case: Any = case_of_scene(
        "impact-mash-tl4-sut", {"vehicle.centre_of_mass": 5.0, "vehicle.yaw_inertia": 9e4}
    )
    built: Any = model.model_of(case)
    kernel, arguments = built.calls["motion"]
    arguments[0][built.quantities.index(key), 0] = value
    assert kernel(*arguments)[0] == reason


def motion_of(name: str, values: Any, random: bool = False) -> Any:
    """Return the call of a motion and its answer.

    values: by quantity [SI]; where random, those of a generator.
    """
    case: Any = case_of_scene(name, None)
    built: Any = model.model_of(case)
    kernel, arguments = built.calls["motion"]
    for key, value in (random_changes(values, case) if random else values).items():
        arguments[0][built.quantities.index(key), 0] = value
    while (answer := kernel(*arguments))[2] == model.kernels.MORE_ROWS:
        outcome = arguments[3]
        _, rows, width = outcome.rows.shape
        arguments = (*arguments[:3], outcome._replace(rows=np.zeros((1, 2 * rows, width))), *arguments[4:])
    return kernel, arguments, answer


def numbers_of(motion: Any, count: int) -> Any:
    """Return quantities and forces of a motion, shape (instants, columns)."""
    return np.hstack([motion.values[:count], motion.curves.T[:count]])


def change(numbers: Any, other: Any) -> float:
    """Return the largest difference over the maximum of its column."""
    largest = np.maximum(np.abs(numbers).max(axis=0), 1e-300)
    return float((np.abs(other - numbers).max(axis=0) / largest).max())


def effect_of_rounding(kernel: Any, arguments: Any, answer: Any, expected: Any) -> float:
    """Return the largest change by rounding of every input."""
    values, random, largest = arguments[0].copy(), np.random.default_rng(1), 0.0
    for _ in range(4):
        arguments[0][:] = np.nextafter(values, values * random.choice([0.5, 2.0], size=values.shape))
        assert kernel(*arguments) == answer
        largest = max(largest, change(expected, numbers_of(arguments[-2], answer[3])))
    return largest


def demand_equal(kernel: Any, arguments: Any, answer: Any) -> None:
    """Require the numbers of a motion in WebAssembly.

    To 1e-9 of each maximum, or twice what the last digits of the inputs change here.
    """
    expected = numbers_of(arguments[-2], answer[3])
    module = Module({"motion": (kernel, arguments)})
    module.call("motion")
    assert module.call("motion", 4).view(np.int64).tolist() == list(answer)
    values, curves = (module[f"motion.motion.{name}"] for name in ("values", "curves"))
    off = change(expected, np.hstack([values[: answer[3]], curves.T[: answer[3]]]))
    assert off < 1e-9 or off <= 2.0 * effect_of_rounding(kernel, arguments, answer, expected)


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=() if "3-car" in name or "van" in name else pytest.mark.long) for name in SCENES
])  # fmt: skip
def test_a_motion_in_webassembly_has_the_same_numbers(name):
    kernel, arguments, answer = motion_of(name, {})
    assert answer[:3] == (0, 0, 0)
    demand_equal(kernel, arguments, answer)


@pytest.mark.parametrize(
    ("seed", "count"), [(3, 2), *(pytest.param(seed, 20, marks=pytest.mark.long) for seed in range(10))]
)
def test_random_motions_in_webassembly_have_the_same_numbers(seed, count):
    """Restitutions are 0 to 0.4."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        demand_equal(*motion_of(SCENES[int(random.integers(len(SCENES)))], random, random=True))


@pytest.mark.parametrize("name", ["impact-mash-tl3-pickup", "impact-mash-tl4-sut"])
def test_a_steep_line_of_unloading_does_not_amplify_rounding(name):
    """It is 1/5000 of the crush, and the vehicle bounces."""
    steep = {"contact.restitution": 0.014, "contact.friction": 0.04, "impact.angle": 0.15}
    kernel, arguments, answer = motion_of(name, steep)
    expected = numbers_of(arguments[-2], answer[3])
    assert effect_of_rounding(kernel, arguments, answer, expected) < 2e-10


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=() if "van" in name else pytest.mark.long) for name in SCENES
])  # fmt: skip
def test_a_band_in_webassembly_has_the_same_numbers(name):
    """Its functions of mathematics are calls of Python here, and therefore slow."""
    calls = calls_of(name)
    module = Module(calls)
    kernel, arguments = calls["band"]
    kernel(*arguments)
    module.call("band")
    assert module["band.percentiles"][1] == pytest.approx(arguments[-1][1], rel=1e-9)


@pytest.mark.parametrize("name", [name for name in tailslap.scenes() if name not in SCENES])
def test_scenes_beyond_a_page_are_refused_with_the_command(name):
    with pytest.raises(InputError, match=f"`tailslap (rigid|run) {name}` computes this scene"):
        calls_of(name)
