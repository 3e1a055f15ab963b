"""Verify FE trains of scenes against the rigid train."""

import functools
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from shared_cases import LINEAR_TRAIN, LINEAR_TRUCK, changed

from tailslap.case.impact import case as impact_case
from tailslap.case.impact import checks, error, plan, report, report_tables, run
from tailslap.case.impact.answers import ImpactAnswer
from tailslap.case.run_report import plate_sentence
from tailslap.cli import _status
from tailslap.errors import InputError
from tailslap.scene.read import read_scene
from tailslap.studies.stability import cell_verdicts, stability_study

NOT_REACHED = 1e9
"""Plateau of the crush [N]."""
TRAILER = {"length": 14.6, "width": 2.59, "mass": 27770.0, "centre_of_mass": 8.0, "yaw_inertia": 497057.0}
TRAILER |= {"hitch": 5.6, "kingpin": 0.9}
TRACTOR = {"length": 6.9, "width": 2.44, "mass": 8200.0, "centre_of_mass": 2.9, "yaw_inertia": 34621.0}


def case(**changes):
    """The train of another code's trial, with four linear elements across.

    With a plateau, which no force reaches, its compiled loop is that of shipped trains.
    """
    keys: dict[str, Any] = {f"vehicle.{key}": value for key, value in TRACTOR.items()}
    keys |= {"impact.test_level": None, "contact.plateau_force": NOT_REACHED}
    keys |= {"trailer": [TRAILER], "plate.elements": (10, 4), "plate.element": "quad4", "impact.speed": 22.35}
    return changed(LINEAR_TRUCK, **keys | changes)


@functools.cache
def attempted():
    return run.attempt(case())


def test_a_train_of_plates_strikes_as_the_rigid_one():
    outcome = attempted()
    corners = ["front", "trailer front", "rear", "front", "trailer rear"]
    for answer in (outcome.fe, outcome.rigid):
        assert [strike.corner for strike in answer.strikes[:5]] == corners
    assert np.abs([value for key, value in outcome.difference.items() if "duration" not in key]).max() < 0.02
    assert len(outcome.difference) == 15
    assert outcome.run.history["t"][-1] >= outcome.fe.strikes[4].end + 0.1
    (fe,), (rigid,) = outcome.fe.hinges, outcome.rigid.hinges
    assert fe["largest_angle"] == pytest.approx(rigid["largest_angle"], rel=5e-3)
    assert fe["peak_force"] > rigid["peak_force"]  # plates ring


def test_columns_of_the_plates_are_those_of_the_rigid_train():
    history, rigid = report.ImpactReport(attempted()).histories.values()
    assert {name for name in rigid if name[-2:] in ("_1", "_2")} <= set(history)
    for name in ("theta", "theta_2", "y_g", "y_g_2", "articulation_1"):
        assert history[name] == pytest.approx(rigid[name], abs=0.05 * np.abs(rigid[name]).max())
    for force in ("force_normal", "force_tangential"):
        assert history[f"{force}_1"] + history[f"{force}_2"] == pytest.approx(history[force])
    momentum = TRACTOR["mass"] * history["v_gy"] + TRAILER["mass"] * history["v_gy_2"]
    error = momentum - momentum[0] - history["normal_impulse"]
    assert np.abs(error).max() < 1e-9 * np.abs(momentum[0])


def test_a_train_passes_its_checks_and_one_that_jack_knifes_does_not():
    outcome = attempted()
    failed = [check.name for check in checks.impact_checks(outcome) if not check.passed]
    assert set(failed) <= set(checks.MESH_CHECKS.values())  # a single run states no error
    history = dict(outcome.fe.history) | {"articulation_1": outcome.fe.history["articulation_1"] + 1.4}
    jack_knifed = checks.impact_checks(replace(outcome, fe=replace(outcome.fe, history=history)))
    assert "articulation" in [check.name for check in jack_knifed if not check.passed]


def test_the_set_up_counts_the_elements_of_both_plates():
    plan = attempted().fe_plan
    sentence = plate_sentence(plan)
    assert sentence.startswith(
        f"Hinged plates of {plan.model.parameters.table.connectivity.shape[1]} {plan.plate.element} "
    )
    assert sentence.endswith(f"{plan.first_frequency:.4g} Hz.")


@pytest.mark.long
def test_the_error_of_the_first_two_strikes_and_of_those_near_the_largest_is_stated():
    outcome = case(plate__elements=(6, 2), plate__element="quad9", time__end=1.0).run()
    corners = [strike.corner for strike in error.assessed_strikes(outcome.fe)]
    assert corners == ["front", "trailer front", "rear", "trailer rear"]  # the third presses with the second
    (hinge,), table = outcome.hinge_error, report_tables.hinges_table(outcome)
    assert 1e-3 < hinge < 0.05
    assert report.ImpactReport(outcome).summary(pictures=False)["numerical_error"]["hinges"] == [hinge]
    assert [(row["model"], row["error"]) for row in table.rows] == [("FE", hinge), ("rigid", None)]
    quadratic = {"plate__elements": (12, 4), "plate__element": "quad9"}
    finer = case(**quadratic, time__end=1.0, verify__companion=False).run()
    mean, finer_mean = (result.fe.hinges[0]["mean_50ms"] for result in (outcome, finer))
    assert abs(finer_mean / mean - 1.0) < hinge
    assert {name.split(".")[0] for name in outcome.mesh_error} == {f"strike_{k}" for k in range(1, 5)}
    (advice,) = {check.advice for check in outcome.checks if check.name in checks.MESH_CHECKS.values()}
    assert "hitch_length" in advice
    assert [check.name for check in outcome.checks if not check.passed] == []


def hinged(delay=0.0, interval=1e-4, force=1e6):
    """A train of two units with a pulse of the hinge force.

    The force is one minus cosine over 0.4 s after a delay.
    """
    t = np.arange(0.0, 0.6, interval)
    angle = 2.0 * np.pi * np.clip(t - delay, 0.0, 0.4) / 0.4
    size = 0.4 * force * np.diff(angle - np.sin(angle), prepend=0.0) / (2.0 * np.pi * interval)
    history = {"t": t, "hinge_force_x_1": 0.6 * size, "hinge_force_y_1": 0.8 * size}
    return ImpactAnswer((), history | {"articulation_1": 0.0 * t}, units=2)


def test_a_small_step_of_a_hinges_force_is_bounded_by_the_curves_about_its_peak():
    """Another mesh has the same peak 10 ms later, on other rows."""
    answer, late = hinged(), hinged(0.01, 0.7e-4)
    ((changed,),) = error.hinge_changes(answer, [late])
    assert abs(changed) < 1e-4
    part = np.sin(np.pi * 0.05 / 0.4) / (np.pi * 0.05 / 0.4)
    early, late_by = np.cos(2.0 * np.pi * np.array([0.025, 0.035]) / 0.4)
    bound = part * (early - late_by) / (1.0 + part)
    expected = error.RESOLVED + bound / (2.0**error.ORDER - 1.0)
    same = answer, answer
    assert error.hinge_errors(answer, [late, answer], same) == pytest.approx([expected], rel=5e-3)
    third = error.hinge_errors(answer, [hinged(0.02), answer, late], same)
    assert third == pytest.approx([error.RESOLVED + bound * error.safety(0.0) / error.TWO_MESHES], rel=5e-3)
    stronger = hinged(force=1.03e6)
    assert error.hinge_errors(answer, [stronger, answer], same)[0] > 0.03  # a step that is none of chance
    (halved,) = error.hinge_errors(answer, same, (stronger, answer))
    assert halved == pytest.approx(error.RESOLVED + 0.03)


def test_a_hinge_of_a_short_history_is_judged_over_the_whole_of_it():
    short = hinged(interval=1e-5)
    rows = {name: column[:2001] for name, column in short.history.items()}
    answer = ImpactAnswer((), rows, units=2)
    assert error.hinge_errors(answer, [answer, answer], [answer, answer]) == [error.RESOLVED]


def test_a_train_whose_hinge_is_not_known_fails():
    stated = {f"strike_1.{name}": 1e-3 for name in error.QUANTITIES}
    sure = replace(attempted(), mesh_error=stated, hinge_error=[1e-3, 0.0312])
    outcome = replace(sure, checks=checks.impact_checks(sure))
    (failed,) = [check for check in outcome.checks if not check.passed]
    assert (failed.name, failed.value, failed.limit) == ("error of hinge force", 0.0312, 0.02)
    assert "trailer.hitch_length" in failed.advice
    assert checks.failed_but_mesh(outcome) == ()
    assert "hinge forces to 3.2 % (limit 2 %)" in report.ImpactReport(outcome).headline.certainty
    assert outcome.stated_error == 0.0312
    unknown = checks.impact_checks(replace(sure, hinge_error=[]))
    assert [check.name for check in unknown if not check.passed] == ["error of hinge force"]


def test_a_third_mesh_is_run_for_a_hinge_alone(monkeypatch):
    """The hinge alone decides, unless the finer mesh differs too much."""
    start = attempted()
    meshes = []

    def on(outcome, plate, computed, part=1.0):
        meshes.append((plate.counts, part))
        return outcome.fe

    monkeypatch.setattr(run, "_on", on)
    monkeypatch.setattr(error, "estimate", lambda *by: dict.fromkeys(error.QUANTITIES, 1e-3))
    monkeypatch.setattr(
        error, "hinge_errors", lambda answer, answers, _: [0.05 if len(answers) < 3 else 0.01]
    )
    assert run.with_errors(start).hinge_error == [0.01]
    assert [part for _, part in meshes] == [1.0, 0.5, 1.0, 1.0]
    monkeypatch.setattr(error, "hinge_changes", lambda answer, answers: [[0.0, 0.03]])
    assert run.with_errors(start).hinge_error == [0.05]
    assert len(meshes) == 7


def test_a_hinge_that_cannot_be_spread_is_refused_by_its_key():
    with pytest.raises(InputError, match="does not lie between") as caught:
        case(trailer=[TRAILER | {"hitch_length": 9.0}]).plan()
    assert caught.value.key == "trailer.0.hitch_length"


OPEN = {"plate__elements": None, "plate__element": None}
WITHOUT_CRUSH = {f"contact__{key}": None for key in ("stiffness", "restitution", "plateau_force")}


@pytest.mark.parametrize(("changes", "keys"), [
    (OPEN, {"contact.patch_length", "trailer.0.hitch_length"}),
    (OPEN | {"contact__patch_length": 0.9}, {"trailer.0.hitch_length"}),
    (OPEN | {"trailer": [TRAILER | {"hitch_length": 1.5}]}, {"contact.patch_length"}),
    (OPEN | WITHOUT_CRUSH, {"trailer.0.hitch_length"}),
    ({}, set()),
])  # fmt: skip
def test_a_train_without_elements_spreads_the_forces_whose_length_is_left_out(changes, keys):
    """Forces are spread over half the width, as by given lengths."""
    open_train = case(**changes)
    lengths = dict.fromkeys(keys, 1.22)
    assert plan.chosen_lengths(open_train.scene) == lengths
    chosen = open_train.plan()
    decisions = {decision.key: decision.value for decision in chosen.decisions}
    assert {key: value for key, value in decisions.items() if key.endswith("_length")} == lengths
    mesh = {"plate.elements": chosen.plate.counts, "plate.element": chosen.plate.element}
    same = open_train.varied(lengths | mesh).plan()
    for part in ("contact", "hinges"):
        open_part, same_part = (getattr(fe_plan.model.parameters, part) for fe_plan in (chosen, same))
        assert open_part.nodes.tolist() == same_part.nodes.tolist()
        assert open_part.weights.tolist() == same_part.weights.tolist()


def test_a_trailer_that_is_shorter_than_half_the_width_bounds_the_length():
    short = TRAILER | {"length": 1.1, "centre_of_mass": 0.5, "yaw_inertia": 2e3, "mass": 3e3, "kingpin": 0.1}
    lengths = plan.chosen_lengths(case(**OPEN, trailer=[short]).scene)
    assert set(lengths.values()) == {1.1}
    case(**OPEN, trailer=[short]).plan()


def test_finer_meshes_of_a_tolerance_keep_the_chosen_lengths(monkeypatch):
    cases = []

    def coarse(self):
        cases.append(self)
        error = 0.1 if len(cases) < 2 else 0.0
        return SimpleNamespace(
            fe_plan=self.plan(), stated_error=error, with_tolerance=lambda *arguments: None
        )

    monkeypatch.setattr(impact_case, "_run", coarse)
    case(**OPEN).run(tolerance=0.02)
    _, finer = cases
    assert (finer.scene.plate.elements, finer.scene.plate.element) == ((24, 8), "quad9")
    assert finer.scene.contact.patch_length == 1.22
    assert finer.scene.trailer[0].hitch_length == 1.22


def test_a_drawbar_at_a_tow_ball_and_a_third_unit_run():
    trailer = TRAILER | {"kingpin": -1.0, "hitch": 7.0}
    strips = [{"at": place, "unit": 2, "stiffness": 1e6} for place in (0.0, TRAILER["length"])]
    changes = {"trailer": [trailer, TRAILER | {"hitch": 13.0}], "strip": strips}
    outcome = run.attempt(case(**changes, time__end=0.3))
    assert outcome.fe.units == 3
    assert outcome.run.group.tolist() == list(range(12))
    assert outcome.run.unit.tolist() == [0] * 4 + [1] * 4 + [2] * 4
    law = outcome.fe_plan.model.parameters.contact.law
    assert law.stiffness.tolist() == [2e6] * 4 + [1e6] * 4 + [2e6] * 4
    failed = [check.name for check in checks.impact_checks(outcome) if not check.passed]
    assert set(failed) <= set(checks.MESH_CHECKS.values())


SMALL = ("plate.elements=[6, 2]", "plate.element=quad9", f"contact.plateau_force={NOT_REACHED}")


def test_a_result_of_a_train_is_exported_and_compared(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = [
        part
        for change in (*SMALL, "output.fields=2", "verify.companion=false", "time.end=0.4 s")
        for part in ("--set", change)
    ]
    assert _status(["run", LINEAR_TRAIN, "--out", "one", "--no-pictures", *options]) == 0
    for kind in ("csv", "vtu", "xdmf"):
        assert _status(["export", "one", "--to", kind]) == 0
    assert _status(["compare", "one", "one/history.csv", "--out", "two"]) == 0


@pytest.mark.parametrize("changes", [
    {"contact.stiffness": 1e5}, pytest.param({"contact.stiffness": 1e9}, marks=pytest.mark.long),
])  # fmt: skip
def test_no_cell_of_the_study_of_stability_is_wrong(changes):
    """Soft crush is right, and 1 GN/m is caught by the mesh."""
    base = stability_study.base_source(read_scene(LINEAR_TRAIN, SMALL)[0])
    verdict = cell_verdicts.judge(base, changes, partial(cell_verdicts.against_rigid, tolerance=0.01))
    expected = cell_verdicts.RIGHT if changes["contact.stiffness"] < 1e9 else cell_verdicts.CAUGHT
    assert verdict["kind"] == expected


@pytest.mark.long
@pytest.mark.parametrize("study", ["flexibility --points 4", "cost"])
def test_studies_of_a_train_run(study, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = [part for change in SMALL for part in ("--set", change)]
    assert _status(["study", *study.split(), LINEAR_TRAIN, *options]) == 0
