"""Verify errors, fronts, limits and records of the cost study."""

import json
import math

import pytest
from shared_cases import LINEAR_TRUCK

from postprocess.comparison.grid_convergence import Limit, grid_convergence, limit_of
from postprocess.comparison.quantities import largest_relative
from postprocess.report.command_report import write_report
from tailslap.campaign.records import kept
from tailslap.case import case_of
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact.case import ImpactCase
from tailslap.cli import _status
from tailslap.scene.read import read_scene, read_source
from tailslap.scene.vary import vary
from tailslap.studies.cost import cost_settings, cost_study
from tailslap.studies.cost.cost_report import report
from tailslap.studies.cost.cost_settings import EXACT, FE, MODAL, ODE, Setting
from tailslap.studies.cost.cost_study import measure, row_of

TRUTH = {"t": 1.0, "v_gx": 2.0, "v_gy": -4.0, "omega": 0.5, "slide": 8.0}
STUDIED = CornerCase(*read_scene("paper-table-3"))
TODO = [*cost_settings.settings(STUDIED.scene), *cost_settings.soft_settings(STUDIED.scene)]


def record(values, failed=(), steps=9):
    """As a measurement notes it."""
    times = {"setup": [0.2, 0.1], "loop": [0.5, 0.3, 0.4]}
    return {"values": values, **times, "steps": steps, "failed": list(failed)}


def row(label, error, seconds, kind=FE, failed="", choice=False):
    """A row with the entries of fronts and levels."""
    entries = {"label": label, "error": error, "seconds": seconds, "kind": kind, "failed": failed}
    return entries | {"refused": "", "choice": choice}


ROWS = (
    row("slow and exact", 1e-8, 10.0), row("beaten", 1e-4, 3.0), row("middle", 1e-5, 2.0),
    row("quick", 1e-2, 0.1), row("quick but failed", 1e-9, 0.01, failed="mesh"), row("none", math.nan, 0.01),
)  # fmt: skip


def test_front_holds_what_nothing_beats_neither_the_truth_itself_nor_choices_on_one_mesh():
    assert [row["label"] for row in cost_study.front(ROWS)] == ["quick", "middle", "slow and exact"]
    more = row("closed form", 1e-12, 1e-5, EXACT), row("ratio 0.1", 1e-11, 1e-4, choice=True)
    assert cost_study.front((*more, *ROWS)) == cost_study.front(ROWS)


def test_cheapest_for_each_level():
    best = [cost_study.cheapest(ROWS, level) for level in (1.0, 1e-3, 1e-6, 1e-12)]
    assert [row and row["label"] for row in best] == ["quick", "middle", "slow and exact", None]


def test_error_is_the_largest_of_five():
    assert largest_relative(TRUTH, TRUTH) == 0.0
    assert largest_relative(TRUTH | {"v_gy": -4.4, "t": 1.01}, TRUTH) == pytest.approx(0.1)
    assert math.isnan(largest_relative(TRUTH | {"t": math.nan}, TRUTH))


def test_errors_are_from_the_limit_of_the_quadratic_elements():
    """Changes of 4 and 1 per thousand have order 2.

    The limit is 1 - 1/3000, known to 1.25/3000.
    """
    values = [record(dict.fromkeys(cost_study.NAMES, x)) for x in (1.005, 1.001, 1.0)]
    limit = limit_of(values, cost_study.NAMES)
    assert limit.values == {name: pytest.approx(1.0 - 1e-3 / 3.0, rel=1e-12) for name in cost_study.NAMES}
    assert limit.uncertainty == pytest.approx(1.25e-3 / 3.0, rel=1e-9)
    result = row_of(Setting(FE, "quad4", "mesh"), record(dict.fromkeys(cost_study.NAMES, 1.02)), limit)
    assert result["error"] == pytest.approx(1.02 / (1.0 - 1e-3 / 3.0) - 1.0)
    assert [result[name] for name in ("setup_s", "loop_s", "median_s", "steps")] == [0.1, 0.3, 0.4, 9]


def test_no_error_is_below_what_the_limit_is_known_to_and_none_is_told_without_strikes():
    limit, setting = Limit(dict.fromkeys(cost_study.NAMES, 1.0), 1e-3), Setting(FE, "quad4", "mesh")
    assert row_of(setting, record(dict.fromkeys(cost_study.NAMES, 1.0 + 1e-5)), limit)["error"] == 1e-3
    nothing = row_of(setting, record(cost_study.strike_values([])), limit)
    assert math.isnan(nothing["error"])
    assert not cost_study.is_valid(nothing)
    assert all(map(math.isnan, cost_study.strike_values([]).values()))
    assert not cost_study.is_valid(row_of(setting, {"refused": "no"}, limit))


def test_limit_without_convergence_is_the_finest_and_little_known():
    values = [{"values": {k: v * factor for k, v in TRUTH.items()}} for factor in (1.0, 1.1, 1.0)]
    assert limit_of(values) == Limit(TRUTH, pytest.approx(0.3))  # type: ignore[arg-type]
    assert math.isnan(limit_of(values[:2]).uncertainty)


def test_settings_have_names_of_their_own():
    assert len({setting.key for setting in TODO}) == len(TODO)
    both = {"modal model", "time step", "penalty", "damping"}
    groups = {"exact", "RK45", "DOP853", "Radau", "LSODA", "mesh", "exact constraint", "unstressed start"}
    groups |= {"row-sum masses"}
    assert groups | both <= {setting.group for setting in TODO if not setting.soft}
    elements = {"quad4", "quad9", "tri3", "tri6", "quad4-reduced"}
    assert elements | both <= {setting.group for setting in TODO if setting.soft}


def test_the_limit_s_meshes_are_halves_of_each_other():
    case = ImpactCase(*read_scene("impact-mash-tl4-sut"))
    todo, *_ = cost_settings.impact_settings(case)
    meshes = [s.changes["plate.elements"] for s in todo if s.group == "quad9"]
    assert meshes == [(8, 2), (16, 4), (32, 8)]


def test_the_length_of_the_scene_spans_an_element_of_every_mesh_of_the_limit():
    case = ImpactCase(*read_scene("impact-flexible-tl4-sut"))
    todo, changes, length = cost_settings.impact_settings(case)
    assert (length, changes["contact.patch_length"]) == (0.5, 0.5)
    for setting in (s for s in todo if s.group == "quad9"):
        assert case.varied({**changes, **setting.changes}).plan().plate.elements


def test_a_study_without_a_limit_has_a_page():
    case = ImpactCase(*read_scene("impact-flexible-tl4-sut"))
    todo = [Setting("ode", "rigid vehicle", "fixed step"), Setting(FE, "quad4", "8 x 2")]
    records = [record(dict.fromkeys(cost_study.NAMES, 1.0)), {"refused": "no"}]
    rows = [row_of(*pair, cost_study.NO_LIMIT) for pair in zip(todo, records, strict=True)]
    page = report(cost_study.CostResult(case, rows, cost_study.NO_LIMIT, patch=0.5)).page
    assert "the rigid vehicle differs by unknown" in page.headline.answer


def test_rigid_methods_are_as_good_as_they_say():
    exact = measure(STUDIED.source, Setting(EXACT, "exact", "closed form"))
    assert largest_relative(exact["values"], STUDIED.tail_slap) == 0.0
    tight = measure(STUDIED.source, Setting(ODE, "DOP853", "tight", number=1e-11))
    assert largest_relative(tight["values"], STUDIED.tail_slap) < 1e-12
    assert len(tight["loop"]) > 3


def test_finite_elements_are_measured_and_refusals_noted():
    base = read_source("paper-abaqus")
    coarse = measure(base, Setting(FE, "mesh", "6 x 2", {"plate.elements": (6, 2)}))
    assert len(coarse["loop"]) == len(coarse["setup"]) >= 2
    assert coarse["failed"] == []
    run = CornerCase(*read_scene("paper-abaqus", ("plate.elements=[6,2]",))).run()
    assert coarse["values"] == run.fe
    exact = vary(base, {"corner.constraint": "exact"})[1]
    refused = measure(exact, Setting(FE, "p", "p", {"corner.penalty_scale": 3.0}))
    assert "constraint" in refused["refused"]


def test_time_step_converges_with_order_two():
    """Central differences on a mesh whose errors exceed the rounding."""
    values = []
    for factor in (0.225, 0.45, 0.9):
        changes = ("plate.elements=[6,2]", f"time.safety_factor={factor}")
        values.append(CornerCase(*read_scene("paper-abaqus", changes)).run().fe)
    for name in ("t", "slide"):
        coarse, middle, fine = (v[name] for v in values)
        convergence = grid_convergence(coarse, middle, fine)
        assert convergence.order == pytest.approx(2.0, abs=0.1)
        assert convergence.gci_fine < 1e-9


@pytest.mark.parametrize(("patch", "finest"), [(("corner.patch_length=1",), 80), ((), 40)])
def test_patch_converges_with_the_mesh_and_a_point_does_not(patch, finest):
    soft = ("plate.youngs_modulus=1 GPa", "plate.element=quad4", "corner.constraint=exact", *patch)
    values = []
    for n in (finest, finest // 2, finest // 4):
        changes = (*soft, f"plate.elements=[{n},{3 * n // 10}]")
        values.append(CornerCase(*read_scene("paper-abaqus", changes)).run().fe["v_gy"])
    convergence = grid_convergence(*values)
    assert (convergence.behaviour == "converging") == bool(patch)
    if patch:
        assert 1.2 < convergence.order < 2.1
        assert convergence.gci_fine < 5e-4
    else:
        assert convergence.order < 0.3


def test_interrupted_study_measures_only_what_is_missing(tmp_path, monkeypatch):
    measured: list[str] = []

    def noted(source, setting):
        if len(measured) == 5:
            measured.append("stop")
            raise KeyboardInterrupt
        measured.append(setting.key)
        return record(TRUTH)

    monkeypatch.setattr(cost_study, "measure", noted)
    with pytest.raises(KeyboardInterrupt):
        cost_study.compute(STUDIED, tmp_path / "out")
    with kept(tmp_path / "out"):
        study = cost_study.compute(STUDIED, tmp_path / "out")
    assert len(measured) - 1 == len(set(measured)) - 1 == len(study.rows)
    assert list(tmp_path.iterdir()) == []


def made_records(order=2.0, steps=None):
    """Records with errors of 1e-3 times the refinement to -order.

    The number of steps is by label, else by halves; the modal model fails a check.
    """
    records = {}
    for s in TODO:
        fine = max(s.refinement, 0.1)
        values = {k: v * (1.0 + 1e-3 * fine**-order) for k, v in TRUTH.items()}
        entries = record(values, ("linear modes",) if s.kind == MODAL else ())
        entries["steps"] = round(1000 * s.refinement) if steps is None else steps.get(s.label, 1000)
        records[s.key] = entries | {"setup": [0.1], "loop": [0.01 * fine, 0.5]}
    return records


def corner_result(truth, steps=None):
    records, changes = made_records(steps=steps), ("plate.start=inertia-relief",)
    return cost_study.corner_result(STUDIED, TODO, records, changes, truth)


def test_time_steps_that_are_no_halves_have_no_convergence():
    """The least number of steps bounds the step of a soft plate."""
    halves = {"safety factor 0.45": 2000, "safety factor 0.225": 4000}
    assert "time step" in corner_result(TRUTH, halves).convergence
    convergence = corner_result(TRUTH, {}).convergence
    assert "time step" not in convergence
    assert convergence["mesh"]["t"].order == pytest.approx(2.0)


@pytest.mark.long
def test_page_and_summary(tmp_path):
    study_report = report(corner_result(TRUTH))
    write_report(study_report, tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["front"]["flexible"][-1].startswith("soft plate, q")
    assert summary["known"]["rigid"] == cost_study.ROUNDING
    page = (tmp_path / "report.html").read_text()
    assert page.count("<svg") == sum(len(section.figures) for section in study_report.page.sections) > 2
    for words in ("Pareto front", "failed a check", "FE, row-sum masses", "quad9, order 2.0", "known within"):
        assert words in page
    assert len((tmp_path / "points.csv").read_text().splitlines()) == len(TODO) + 1


def test_errors_of_the_soft_plate_are_from_its_limit_and_not_below_what_is_known():
    study = corner_result({k: 1.01 * v for k, v in TRUTH.items()})
    soft = study.rows_of(soft=True)
    assert study.limit.values == pytest.approx(TRUTH, rel=1e-9)
    assert study.limit.uncertainty == pytest.approx(1.25e-3 / 64, rel=1e-3)  # the finest is 8 times finer
    assert study.flexibility == pytest.approx(0.01 / 1.01, rel=1e-6)
    errors = {row["label"]: row["error"] for row in soft if row["group"] == "quad9"}
    assert (errors["10 x 3"], errors["80 x 24"]) == (pytest.approx(1e-3, rel=1e-6), study.limit.uncertainty)
    assert all(row["error"] >= cost_study.ROUNDING for row in study.rows_of(soft=False))
    added = [row["added"] for row in soft if row["group"] == "damping"]
    assert added == sorted(added, reverse=True)


@pytest.mark.parametrize("changes", [
    (),
    ("plate.youngs_modulus=", "plate.first_frequency=5 Hz", "corner.patch_length=1", "damping.ratio=0.1"),
    ("corner.penalty_scale=3", "corner.damping_ratio=0.1", "plate.start=unstressed"),
])  # fmt: skip
def test_soft_plate_keeps_what_the_scene_gives(changes):
    """Frequency and patch are the scene's, the rest suits the modal model."""
    plan = CornerCase(*read_scene("paper-table-3", changes))
    soft, source = vary(plan.source, {**cost_settings.soft_changes(plan), "plate.element": "quad9"})
    fe_plan = case_of(soft, source).plan()
    assert soft.needed_plate.first_frequency is None
    frequency, patch = (5.0, 1.0) if "corner.patch_length=1" in changes else (8.0, 2.0)
    assert fe_plan.first_frequency == pytest.approx(frequency, rel=1e-3)
    assert (soft.corner.patch_length, soft.corner_friction) == (patch, 0.0)
    assert (soft.needed_plate.start, soft.corner.constraint, soft.damping) == (
        "inertia-relief",
        "exact",
        None,
    )


@pytest.mark.long
def test_meshes_of_the_soft_plate_converge_and_a_spring_adds_in_proportion():
    """Meshes of quad9 converge, and a spring adds in proportion."""
    soft = vary(STUDIED.source, cost_settings.soft_changes(STUDIED))[1]
    by_key = {setting.key.removeprefix("soft plate, "): setting for setting in TODO if setting.soft}
    keys = ("quad9: 10 x 3", "quad9: 20 x 6", "quad9: 40 x 12", "penalty: scale 3", "penalty: scale 30")
    coarse, medium, fine, loose, stiff = [measure(soft, by_key[key])["values"] for key in keys]
    assert largest_relative(medium, fine) < 0.5 * largest_relative(coarse, medium)
    assert largest_relative(loose, medium) == pytest.approx(10.0 * largest_relative(stiff, medium), rel=0.05)


@pytest.mark.long
def test_a_study_of_a_whole_impact_on_a_coarse_plate(tmp_path, capsys):
    """Settings are nearer the limit than the rigid vehicle."""
    out = tmp_path / "cost"
    arguments = ["study", "cost", LINEAR_TRUCK, "--set", "plate.elements=[8, 4]", "--out", str(out)]
    soft = ["--set", "plate.first_frequency=20 Hz", "--set", "plate.youngs_modulus="]
    assert _status([*arguments, *soft]) == 0
    assert "Finite elements compute both strikes within " in " ".join(capsys.readouterr().out.split())
    summary = json.loads((out / "summary.json").read_text())
    error = {point["setting"]: point["error"] for point in summary["points"]}
    rigid = error.pop("rigid vehicle: fixed step")
    assert rigid > 0.02
    assert max(error.values()) < rigid
    assert error["quad9: 16 x 8"] <= error["quad9: 8 x 4"] <= error["quad9: 4 x 2"]
    assert error["quad4: 16 x 8"] < 0.4 * error["quad4: 8 x 4"]
    assert summary["known"] < 0.02
