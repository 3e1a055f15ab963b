"""Verification: the runs of the flexibility study against exact laws: E t, the square of the first frequency.

Further: what it runs, and the command.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from postprocess.comparison.comparison import largest_relative, relative_difference
from tailslap.case.corner.case import CornerCase
from tailslap.command_line import DONE, WRONG_INPUT, _status
from tailslap.errors import InputError
from tailslap.scene.read import read_scene
from tailslap.scene.vary import vary
from tailslap.scene_run import run_scene
from tailslap.studies.flexibility.campaign import _runs
from tailslap.studies.flexibility.measure import (
    largest_difference,
    modal_opinion,
    one_run,
    thickness_changes,
)
from tailslap.studies.flexibility.sweep import (
    STARTS,
    Sweep,
    corner_support,
    define,
    frequencies,
    run_changes,
    three_meshes,
)

pytestmark = pytest.mark.verification

SMALL = ("plate.elements=[8,4]",)


def small_sweep(scene: str, *given: float) -> Sweep:
    return define(CornerCase(*read_scene(scene, SMALL)), given)[0]


@pytest.mark.parametrize(
    ("scene", "hertz"), [("paper-table-3", 0.6), ("paper-table-3", 8.0), ("paper-abaqus", 200.0)]
)
def test_thickness_at_constant_mass_does_what_the_modulus_does(scene: str, hertz: float) -> None:
    sweep = small_sweep(scene, hertz)
    base, changes = sweep.plan.source, run_changes(sweep, hertz, (8, 4))
    by_modulus = one_run(base, changes)
    by_thickness = one_run(base, thickness_changes(changes, by_modulus["youngs_modulus"], sweep.own))
    assert by_thickness["youngs_modulus"] == sweep.own.youngs_modulus
    ratio = by_modulus["youngs_modulus"] / sweep.own.youngs_modulus
    assert by_thickness["thickness"] / sweep.own.thickness == pytest.approx(ratio, rel=1e-14)
    assert largest_relative(by_thickness["values"], by_modulus["values"]) < 1e-11
    assert by_thickness["stored"] == pytest.approx(by_modulus["stored"], rel=1e-9)


def test_differences_go_with_the_inverse_square_of_the_first_frequency() -> None:
    given = (200.0, 100.0, 50.0, 25.0)
    sweep = small_sweep("paper-abaqus", *given)
    runs = [one_run(sweep.plan.source, run_changes(sweep, hertz, (8, 4))) for hertz in given]
    assert not any(run["failed"] for run in runs)
    rigid = sweep.plan.tail_slap
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
def test_the_modal_model_is_of_the_same_opinion() -> None:
    sweep = small_sweep("paper-table-3", 20.0)
    base, changes = sweep.plan.source, run_changes(sweep, 20.0, (8, 4))
    whole, modal = one_run(base, changes), modal_opinion(base, changes)
    flexible = largest_relative(whole["values"], sweep.plan.tail_slap)
    assert largest_relative(modal["values"], whole["values"]) < 1e-2 * flexible
    assert modal["estimate"] < 0.1 * flexible
    assert "unstressed" in modal_opinion(base, {**changes, "plate.start": "unstressed"})["refused"]


def test_what_each_start_keeps() -> None:
    sweep = small_sweep("mash-tl4-sut", 2.0)
    relief, momenta, unstressed = (
        one_run(sweep.plan.source, run_changes(sweep, 2.0, (8, 4), name))["departure"] for name in STARTS
    )
    assert relief["v_gy"] > 3e-3 > 1e-5 > max(abs(relief["omega"]), abs(relief["v_p"]))
    assert max(abs(momenta["v_gx"]), abs(momenta["v_gy"])) < 1e-12
    assert momenta["omega"] < -3e-3 < 0.0 < momenta["v_p"]
    assert max(map(abs, unstressed.values())) < 1e-9


def test_the_largest_difference_is_seen_in_any_phase() -> None:
    """An oscillating plate strikes close to the rigid velocity here, and was ten times as far off before."""
    sweep = small_sweep("mash-tl4-sut", 25.0)
    changes = run_changes(sweep, 25.0, (8, 4), "unstressed")
    outcome = run_scene(sweep.plan.varied(changes))
    largest, at_strike = largest_difference(outcome), abs(outcome.difference["v_gy"])
    difference = outcome.fe_history["v_gy"] - outcome.rigid_history["v_gy"]
    assert largest > 10.0 * at_strike
    assert largest == pytest.approx(np.nanmax(np.abs(difference)) / abs(outcome.rigid["v_gy"]), rel=1e-12)
    # The impulse of a reaction N (1 - cos w t) is off by N / w. A beam pinned at its end has 0.689 of the first
    # frequency of the free one, (3.927 / 4.730)^2, and without damping N / w is reached.
    impulse = abs(outcome.rigid_history["reaction_normal"][0]) / (2.0 * math.pi * 25.0)
    whole = outcome.fe_plan.model.mass * abs(outcome.rigid["v_gy"])
    assert 0.3 < largest / (impulse / whole) < 1.0 / 0.689


def test_meshes_and_hold() -> None:
    scene = read_scene("paper-table-3")[0]
    assert three_meshes(scene) == ((10, 3), (20, 6), (40, 12))
    assert corner_support(scene, (10, 3)).patch == 1.0
    assert corner_support(scene, (10, 3)).constraint == "exact"
    assert corner_support(scene, (7, 2)).patch == pytest.approx(10.0 / 7.0)  # a tenth, as whole elements
    odd = read_scene("paper-table-3", ("plate.elements=[15,5]",))[0]
    assert three_meshes(odd) == ((15, 5), (30, 10), (60, 20))
    own = read_scene("paper-table-3", ("corner.patch_length=0.6", "corner.penalty_scale=2"))[0]
    assert three_meshes(own)[0] == (20, 6)  # half of it would have elements longer than the patch
    assert (corner_support(own, (20, 6)).constraint, corner_support(own, (20, 6)).patch) == ("penalty", 0.6)


def test_three_starts_whatever_the_scene_has() -> None:
    own = ("plate.start=unstressed", "plate.elements=", "verify.tolerance=1e-9")
    sweep, fe_plan = define(CornerCase(*read_scene("mash-tl4-sut", own)), (50.0,))
    assert sweep.meshes[1] == (20, 6)  # what the program chooses where the scene does not
    changes = {name: run_changes(sweep, 50.0, sweep.meshes[0], name) for name in STARTS}
    scenes = {name: vary(sweep.plan.source, each)[0] for name, each in changes.items()}
    assert [scene.plate and scene.plate.start for scene in scenes.values()] == list(STARTS)
    assert run_changes(sweep, 50.0, sweep.meshes[0]) == changes[STARTS[0]]
    assert not any(scene.verify or scene.wall for scene in scenes.values())
    for (
        start
    ) in STARTS:  # an oscillation has its error from three meshes too, whatever the phase of the strike
        assert [run["plate.elements"] for run in _runs(sweep, fe_plan, 50.0, start)] == list(sweep.meshes)


@pytest.mark.parametrize(
    ("option", "given"),
    [("--lowest", "0"), ("--lowest", "2 kg"), ("--lowest", "2 kHz"), ("--highest", "1 MHz")],
)
def test_wrong_frequencies(option: str, given: str) -> None:
    values = {"--lowest": "1 Hz", "--highest": "1 kHz"} | {option: given}
    with pytest.raises(InputError) as caught:
        frequencies(values["--lowest"], values["--highest"], 5)
    assert caught.value.key == option


def test_frequencies_are_at_even_ratios_from_stiff_to_soft() -> None:
    assert frequencies("1", "1 kHz", 4) == pytest.approx((1000.0, 100.0, 10.0, 1.0), rel=1e-12)


@pytest.mark.long
def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    small = ["--set", "plate.elements=[8,4]", "--points", "4", "--workers", "1", "--out", str(out)]
    given = ["study", "flexibility", "paper-abaqus", *small, "--lowest", "0.05 Hz", "--highest", "50 Hz"]
    assert _status(given) == DONE
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
    assert _status([*given, "--lowest", "50 Hz"]) == WRONG_INPUT
    assert _status(["study", "flexibility", "paper-abaqus", "--points", "3"]) == WRONG_INPUT
