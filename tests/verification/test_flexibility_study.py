"""Verification: the flexibility study's levels, power laws and numerical error against exact laws, its runs against E t
and the square of the first frequency; what it runs, and the command."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from postprocess.comparison.quantities import largest_relative, relative_difference
from tailslap import cli, errors
from tailslap.campaign.levels import (
    ABOVE_ALL,
    CROSSED,
    NOT_REACHED,
    UNKNOWN,
    Reach,
    Sample,
    jointly,
    lowest_frequency,
    power_law,
)
from tailslap.case.corner.case import CornerCase
from tailslap.scene.read import read_scene
from tailslap.scene.vary import vary
from tailslap.studies.flexibility import compute

SMALL = ("plate.elements=[8,4]",)


def power(frequency: float, error: float = 1e-3, passed: bool = True) -> Sample:
    """A point of 0.04 (f1 / 1 Hz)^-2, with an error that is a fraction of that."""
    return Sample(frequency, 0.04 / frequency**2, error * 0.04 / frequency**2, passed)


SWEEP = tuple(np.geomspace(1000.0, 0.1, 9).tolist())


@pytest.mark.parametrize(("level", "hertz"), [(0.0004, 10.0), (0.01, 2.0), (0.04, 1.0), (0.16, 0.5)])
def test_levels_of_a_power_law_are_exact(level, hertz):
    found = lowest_frequency([power(f) for f in SWEEP], level)
    assert (found.kind, found.frequency) == (CROSSED, pytest.approx(hertz, rel=1e-12))


def test_levels_that_are_not_crossed():
    points = [power(f) for f in SWEEP]
    all_below = lowest_frequency(points[:4], 0.01)
    assert (all_below.kind, all_below.frequency) == (NOT_REACHED, SWEEP[3])
    above = lowest_frequency(points, 1e-12)
    assert (above.kind, above.frequency) == (ABOVE_ALL, SWEEP[0])
    none = lowest_frequency([point._replace(passed=False) for point in points], 0.01)
    assert none.kind == UNKNOWN
    assert math.isnan(none.frequency)


def level(kind: str, frequency: float) -> Reach:
    return Reach(0.01, kind, frequency)


@pytest.mark.parametrize(
    ("levels", "joint"),
    [
        ([level(CROSSED, 4.0), level(NOT_REACHED, 0.1), level(CROSSED, 2.0)], level(CROSSED, 4.0)),
        ([level(CROSSED, 0.2), level(NOT_REACHED, 0.3)], level(NOT_REACHED, 0.3)),
        ([level(CROSSED, 4.0), level(UNKNOWN, 1.0)], level(UNKNOWN, 1.0)),
        ([level(ABOVE_ALL, 1e3), level(UNKNOWN, 1.0), level(CROSSED, 2.0)], level(ABOVE_ALL, 1e3)),
    ],
)
def test_what_holds_for_every_start(levels, joint):
    assert jointly(levels) == jointly(levels[::-1]) == joint
    assert math.isnan(jointly([level(CROSSED, 2.0), level(UNKNOWN, math.nan)]).frequency)


@pytest.mark.parametrize(("share", "kind"), [(0.333, CROSSED), (0.334, UNKNOWN), (math.nan, UNKNOWN)])
def test_a_level_is_known_up_to_a_third_of_it_in_error(share, kind):
    assert lowest_frequency([power(f, share) for f in SWEEP], 0.01).kind == kind


def test_points_below_a_level_must_be_known_to_lie_below_it():
    points = [power(f) for f in SWEEP]
    points[2] = points[2]._replace(error=0.01)
    unknown = lowest_frequency(points, 0.01)
    assert (unknown.kind, unknown.frequency) == (UNKNOWN, SWEEP[2])
    points[2] = points[2]._replace(error=0.0033)
    assert lowest_frequency(points, 0.01).kind == CROSSED


def test_failed_points_say_nothing_of_a_level():
    points = [power(f) for f in SWEEP]
    points[0] = points[0]._replace(passed=False, difference=9.0)
    points[-1] = points[-1]._replace(passed=False, difference=0.0)
    found = lowest_frequency(points, 0.01)
    assert (found.kind, found.frequency) == (CROSSED, pytest.approx(2.0, rel=1e-12))
    below = next(i for i, f in enumerate(SWEEP) if f < 2.0)
    points[below] = points[below]._replace(passed=False)
    assert lowest_frequency(points, 0.01).kind == UNKNOWN  # the crossing lies beside a point that failed


def test_a_power_law_is_followed_to_its_end():
    points = [power(f) for f in SWEEP]
    law = power_law(points)
    assert law
    assert (law.exponent, law.factor) == (pytest.approx(-2.0, abs=1e-12), pytest.approx(0.04, rel=1e-12))
    assert (law.highest, law.lowest) == (SWEEP[0], SWEEP[-1])
    bent = [*points[:6], *(p._replace(difference=3.0 * p.difference) for p in points[6:])]
    law = power_law(bent)
    assert law
    assert law.lowest == SWEEP[5]
    assert law.exponent == pytest.approx(-2.0, abs=1e-12)
    assert power_law([power(f, error=0.5) for f in SWEEP]) is None


def test_the_error_is_a_grid_convergence_index_of_a_believable_order():
    second = [3.0 + 0.01 * h**2 for h in (1.0, 2.0, 4.0)]
    assert compute.convergence_index(*second) * second[0] == pytest.approx(1.25 * 0.01, rel=1e-9)
    lucky = [3.0 + 1e-6 * h**8 for h in (1.0, 2.0, 4.0)]
    assert compute.convergence_index(*lucky) * lucky[0] == pytest.approx(1.25 * 255e-6 / 3.0, rel=1e-9)
    assert compute.convergence_index(1.0, 1.01, 1.0) == pytest.approx(
        0.03
    )  # to and fro: three times the change


@pytest.mark.parametrize(("error", "kind"), [(0.9e-3, CROSSED), (1.0e-3, UNKNOWN)])
def test_what_is_below_a_level_with_its_error_on_top_is_below_it(error, kind):
    """The stiff end, where the error is most of the level and the difference next to nothing."""
    stiff = Sample(1000.0, 0.05e-3, error, True)
    rest = [Sample(frequency, 0.1 / frequency, 1e-6, True) for frequency in (200.0, 80.0)]
    found = lowest_frequency([stiff, *rest], 1e-3)
    assert found.kind == kind
    if kind == CROSSED:
        assert found.frequency == pytest.approx(100.0)


def small_sweep(scene: str) -> compute.Sweep:
    return compute.define(CornerCase(*read_scene(scene, SMALL)))


@pytest.mark.parametrize(
    ("scene", "hertz"), [("paper-table-3", 0.6), ("paper-table-3", 8.0), ("paper-abaqus", 200.0)]
)
def test_thickness_at_constant_mass_does_what_the_modulus_does(scene, hertz):
    sweep = small_sweep(scene)
    base, changes = sweep.case.source, compute.run_changes(sweep, hertz, (8, 4))
    by_modulus = compute.one_run(base, changes)
    by_thickness = compute.one_run(
        base, compute.thickness_changes(changes, by_modulus["youngs_modulus"], sweep.own)
    )
    assert by_thickness["youngs_modulus"] == sweep.own[2]
    ratio = by_modulus["youngs_modulus"] / sweep.own[2]
    assert by_thickness["thickness"] / sweep.own[0] == pytest.approx(ratio, rel=1e-14)
    assert largest_relative(by_thickness["values"], by_modulus["values"]) < 1e-11
    assert by_thickness["stored"] == pytest.approx(by_modulus["stored"], rel=1e-9)


def test_differences_go_with_the_inverse_square_of_the_first_frequency():
    given = (200.0, 100.0, 50.0, 25.0)
    sweep = small_sweep("paper-abaqus")
    runs = [compute.one_run(sweep.case.source, compute.run_changes(sweep, hertz, (8, 4))) for hertz in given]
    assert not any(run["failed"] for run in runs)
    rigid = sweep.case.tail_slap
    sizes = {
        "v_gy": [relative_difference(run["values"], rigid)["v_gy"] for run in runs],
        "v_gx": [relative_difference(run["values"], rigid)["v_gx"] for run in runs],
        "stored": [run["stored"] for run in runs],
    }
    for name, values in sizes.items():
        exponent = np.polyfit(np.log(given), np.log(np.abs(values)), 1)[0]
        assert exponent == pytest.approx(-2.0, abs=0.01), name
    assert all(1e-8 < abs(value) < 1e-4 for value in sizes["v_gy"])


@pytest.mark.long
def test_the_modal_model_is_of_the_same_opinion():
    sweep = small_sweep("paper-table-3")
    base, changes = sweep.case.source, compute.run_changes(sweep, 20.0, (8, 4))
    whole, modal = compute.one_run(base, changes), compute.one_run(base, changes, compute.modal_record)
    flexible = largest_relative(whole["values"], sweep.case.tail_slap)
    assert largest_relative(modal["values"], whole["values"]) < 1e-2 * flexible
    assert modal["estimate"] < 0.1 * flexible
    unstressed = compute.one_run(base, {**changes, "plate.start": "unstressed"}, compute.modal_record)
    assert "unstressed" in unstressed["refused"]


def test_what_each_start_keeps():
    sweep = small_sweep("mash-tl4-sut")
    relief, momenta, unstressed = (
        compute.one_run(sweep.case.source, compute.run_changes(sweep, 2.0, (8, 4), name))["departure"]
        for name in compute.STARTS
    )
    assert relief["v_gy"] > 3e-3 > 1e-5 > max(abs(relief["omega"]), abs(relief["v_p"]))
    assert max(abs(momenta["v_gx"]), abs(momenta["v_gy"])) < 1e-12
    assert momenta["omega"] < -3e-3 < 0.0 < momenta["v_p"]
    assert max(map(abs, unstressed.values())) < 1e-9


def test_the_largest_difference_is_seen_in_any_phase():
    """An oscillating plate strikes close to the rigid velocity here, and was ten times as far off before."""
    sweep = small_sweep("mash-tl4-sut")
    changes = compute.run_changes(sweep, 25.0, (8, 4), "unstressed")
    outcome = sweep.case.varied(changes).run()
    largest, at_strike = compute.largest_difference(outcome), abs(outcome.difference["v_gy"])
    difference = outcome.fe_history["v_gy"] - outcome.rigid_history["v_gy"]
    assert largest > 10.0 * at_strike
    assert largest == pytest.approx(np.nanmax(np.abs(difference)) / abs(outcome.rigid["v_gy"]), rel=1e-12)
    # The impulse of a reaction N (1 - cos w t) is off by N / w. A beam pinned at its end has 0.689 of the first
    # frequency of the free one, (3.927 / 4.730)^2, and without damping N / w is reached.
    impulse = abs(outcome.rigid_history["reaction_normal"][0]) / (2.0 * math.pi * 25.0)
    whole = outcome.fe_plan.model.mass * abs(outcome.rigid["v_gy"])
    assert 0.3 < largest / (impulse / whole) < 1.0 / 0.689


def test_meshes_and_hold():
    scene = read_scene("paper-table-3")[0]
    assert compute.three_meshes(scene) == ((10, 3), (20, 6), (40, 12))
    assert compute.corner_support(scene, (10, 3))["patch"] == 1.0
    assert compute.corner_support(scene, (10, 3))["constraint"] == "exact"
    assert compute.corner_support(scene, (7, 2))["patch"] == pytest.approx(
        10.0 / 7.0
    )  # a tenth, as whole elements
    odd = read_scene("paper-table-3", ("plate.elements=[15,5]",))[0]
    assert compute.three_meshes(odd) == ((15, 5), (30, 10), (60, 20))
    own = read_scene("paper-table-3", ("corner.patch_length=0.6", "corner.penalty_scale=2"))[0]
    assert compute.three_meshes(own)[0] == (20, 6)  # half of it would have elements longer than the patch
    given = {"own_constraint": True, "own_patch": True}
    assert compute.corner_support(own, (20, 6)) == {"constraint": "penalty", "patch": 0.6, **given}


def test_three_starts_whatever_the_scene_has():
    own = ("plate.start=unstressed", "plate.elements=", "verify.tolerance=1e-9")
    sweep = compute.define(CornerCase(*read_scene("mash-tl4-sut", own)))
    assert sweep.meshes[1] == (20, 6)  # what the program chooses where the scene does not
    changes = {name: compute.run_changes(sweep, 50.0, sweep.meshes[0], name) for name in compute.STARTS}
    scenes = {name: vary(sweep.case.source, each)[0] for name, each in changes.items()}
    assert [scene.plate and scene.plate.start for scene in scenes.values()] == list(compute.STARTS)
    assert compute.run_changes(sweep, 50.0, sweep.meshes[0]) == changes[compute.STARTS[0]]
    assert not any(scene.verify or scene.wall for scene in scenes.values())
    for start in (
        compute.STARTS
    ):  # an oscillation has its error from three meshes too, whatever the phase of the strike
        assert [run and run["plate.elements"] for run in compute.mesh_changes(sweep, 50.0, start)] == list(
            sweep.meshes
        )


@pytest.mark.parametrize(
    ("option", "given"),
    [("--lowest", "0"), ("--lowest", "2 kg"), ("--lowest", "2 kHz"), ("--highest", "1 MHz")],
)
def test_wrong_frequencies(option, given):
    values = {"--lowest": "1 Hz", "--highest": "1 kHz"} | {option: given}
    with pytest.raises(errors.InputError) as caught:
        compute.frequencies(values["--lowest"], values["--highest"], 5)
    assert caught.value.key == option


def test_frequencies_are_at_even_ratios_from_stiff_to_soft():
    assert compute.frequencies("1", "1 kHz", 4) == pytest.approx((1000.0, 100.0, 10.0, 1.0), rel=1e-12)


@pytest.mark.long
def test_command(tmp_path, capsys):
    out = tmp_path / "out"
    small = ["--set", "plate.elements=[8,4]", "--points", "4", "--workers", "1", "--out", str(out)]
    given = ["study", "flexibility", "paper-abaqus", *small, "--lowest", "0.05 Hz", "--highest", "50 Hz"]
    assert cli._status(given) == cli.DONE
    printed = capsys.readouterr().out.replace("\N{NO-BREAK SPACE}", " ")
    assert "good to 1 %, at the strike and before, down to a first frequency of 1." in " ".join(
        printed.split()
    )
    assert "Failed: 0.05 Hz: plate.start" in " ".join(printed.split())
    points = json.loads((out / "summary.json").read_text())["points"]
    assert [point["passed"] for point in points] == [True, True, True, False]
    assert [point["thickness_apart"] is not None for point in points].count(True) == 2
    assert max(point["thickness_apart"] or 0.0 for point in points) < 1e-11
    assert [point["half_patch_v_gy"] is not None for point in points] == [False, False, True, False]
    assert (
        1.0 < points[2]["half_patch_v_gy"] / points[2]["difference_v_gy"] < 1.3
    )  # what holds on less gives more
    assert cli._status([*given, "--lowest", "50 Hz"]) == cli.WRONG_INPUT
    assert cli._status(["study", "flexibility", "paper-abaqus", "--points", "3"]) == cli.WRONG_INPUT
