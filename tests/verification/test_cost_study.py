"""Verification: the cost study's errors, fronts and grid convergence; what it notes, and that it goes on from there."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from postprocess.comparison.comparison import largest_relative
from postprocess.comparison.grid_convergence import grid_convergence
from tailslap.case.corner.case import CornerCase
from tailslap.scene.read import read_scene, read_source
from tailslap.scene.vary import Source, vary
from tailslap.scene_run import run_scene
from tailslap.studies.cost import campaign as survey_module
from tailslap.studies.cost.campaign import campaign
from tailslap.studies.cost.measure import measure
from tailslap.studies.cost.points import Point, cheapest, front
from tailslap.studies.cost.settings import EXACT, FE, ODE, Setting, settings
from tailslap.studies.cost.soft import soft_settings

pytestmark = pytest.mark.verification

TRUTH = {"t": 1.0, "v_gx": 2.0, "v_gy": -4.0, "omega": 0.5, "slide": 8.0}


def point(label: str, error: float, seconds: float, kind: str = FE, failed: tuple[str, ...] = ()) -> Point:
    return Point(Setting(kind, "group", label), error, math.nan, 0.0, seconds, seconds, 0.0, 10, failed)


POINTS = (
    point("slow and exact", 1e-8, 10.0),
    point("beaten", 1e-4, 3.0),
    point("middle", 1e-5, 2.0),
    point("quick", 1e-2, 0.1),
    point("quick but failed", 1e-9, 0.01, failed=("mesh",)),
    point("none", math.nan, 0.01),
)


def test_front_holds_what_nothing_beats() -> None:
    assert [p.setting.label for p in front(POINTS)] == ["quick", "middle", "slow and exact"]


def test_front_holds_neither_the_truth_itself_nor_choices_on_one_mesh() -> None:
    truth = point("closed form", 1e-12, 1e-5, EXACT)
    choice = Setting(FE, "damping", "ratio 0.1", soft=True, choice=True)
    chosen = Point(choice, 1e-11, 1e-11, 0.0, 1e-4, 1e-4, 0.0, 10, ())
    assert front((truth, chosen, *POINTS)) == front(POINTS)


def test_cheapest_for_each_level() -> None:
    named = {level: cheapest(POINTS, level) for level in (1.0, 1e-3, 1e-6, 1e-12)}
    labels = [found.setting.label if found else None for found in named.values()]
    assert labels == ["quick", "middle", "slow and exact", None]


def test_error_is_the_largest_of_five() -> None:
    assert largest_relative(TRUTH, TRUTH) == 0.0
    assert largest_relative(TRUTH | {"v_gy": -4.4, "t": 1.01}, TRUTH) == pytest.approx(0.1)
    assert math.isnan(largest_relative(TRUTH | {"t": math.nan}, TRUTH))


def test_settings_have_names_of_their_own() -> None:
    scene = read_scene("paper-table-3")[0]
    rigid, flexible = settings(scene), soft_settings(scene)
    assert len({setting.key for setting in (*rigid, *flexible)}) == len(rigid) + len(flexible)
    wanted = {"exact", "RK45", "DOP853", "Radau", "LSODA", "mesh", "exact constraint", "modal model"}
    wanted |= {"time step", "penalty", "damping", "unstressed start", "row-sum masses", "single precision"}
    assert wanted <= {setting.group for setting in rigid}
    wanted = {
        "quad4",
        "quad9",
        "tri3",
        "tri6",
        "quad4-reduced",
        "penalty",
        "damping",
        "time step",
        "modal model",
    }
    assert wanted <= {setting.group for setting in flexible}


def test_rigid_methods_are_as_good_as_they_say() -> None:
    plan = CornerCase(*read_scene("paper-table-3"))
    exact = measure(plan.source, Setting(EXACT, "exact", "closed form"))
    assert largest_relative(exact["values"], plan.tail_slap) == 0.0
    tight = measure(plan.source, Setting(ODE, "DOP853", "tight", rtol=1e-11))
    assert largest_relative(tight["values"], plan.tail_slap) < 1e-12
    assert len(tight["loop"]) > 3


def test_finite_elements_are_measured_and_refusals_noted() -> None:
    base = read_source("paper-abaqus")
    found = measure(base, Setting(FE, "mesh", "6 x 2", {"plate.elements": (6, 2)}))
    assert len(found["loop"]) == len(found["setup"]) >= 2
    assert found["failed"] == []
    own = run_scene(CornerCase(*read_scene("paper-abaqus", ("plate.elements=[6,2]",))))
    assert found["values"] == own.fe
    exact = vary(base, {"corner.constraint": "exact"})[1]
    refused = measure(exact, Setting(FE, "p", "p", {"corner.penalty_scale": 3.0}))
    assert "constraint" in refused["refused"]


def test_time_step_converges_with_order_two() -> None:
    """Central differences, on a mesh where the step is long enough to be seen above the rounding."""
    values = []
    for factor in (0.225, 0.45, 0.9):
        changes = ("plate.elements=[6,2]", f"time.safety_factor={factor}")
        values.append(run_scene(CornerCase(*read_scene("paper-abaqus", changes))).fe)
    for name in ("t", "slide"):
        found = grid_convergence(tuple(v[name] for v in values), (2.0, 2.0))  # type: ignore[arg-type]
        assert found.order == pytest.approx(2.0, abs=0.1)
        assert found.gci_fine < 1e-9


@pytest.mark.parametrize(("patch", "converges"), [(("corner.patch_length=1",), True), ((), False)])
def test_patch_converges_with_the_mesh_and_a_point_does_not(patch: tuple[str, ...], converges: bool) -> None:
    soft = ("plate.youngs_modulus=1 GPa", "plate.element=quad4", "corner.constraint=exact", *patch)
    values = []
    for n in (80, 40, 20):
        changes = (*soft, f"plate.elements=[{n},{3 * n // 10}]")
        values.append(run_scene(CornerCase(*read_scene("paper-abaqus", changes))).fe["v_gy"])
    found = grid_convergence((values[0], values[1], values[2]), (2.0, 2.0))
    assert (found.behaviour == "converging") == converges
    if converges:
        assert 1.2 < found.order < 2.1
        assert found.gci_fine < 5e-4
    else:
        assert found.order < 0.3


def test_interrupted_study_measures_only_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = CornerCase(*read_scene("paper-table-3"))
    done: list[str] = []

    def noted(source: Source, setting: Setting) -> dict[str, Any]:
        if len(done) == 5:
            done.append("stop")
            raise KeyboardInterrupt
        done.append(setting.key)
        return {"values": TRUTH, "setup": [0.1], "loop": [0.2], "steps": 1, "failed": []}

    monkeypatch.setattr(survey_module, "measure", noted)
    with pytest.raises(KeyboardInterrupt):
        campaign(plan, tmp_path / "out")
    found = campaign(plan, tmp_path / "out")
    assert len(done) - 1 == len(set(done)) - 1 == len(found.points)
    assert list(tmp_path.iterdir()) == []


def records_of(found: list[Setting], steps: dict[str, int]) -> dict[str, Any]:
    """Values that converge, and steps by group."""
    return {
        s.key: {
            "values": {k: v + 0.1 * s.refinement**-2 for k, v in TRUTH.items()},
            "steps": steps.get(s.label, 1000),
        }
        for s in found
    }


def test_time_steps_that_are_no_halves_have_no_convergence() -> None:
    """On a soft plate the least number of steps stands against the safety factor: that is not a settled value."""
    found = settings(read_scene("paper-table-3")[0])
    halves = {"safety factor 0.45": 2000, "safety factor 0.225": 4000}
    assert "time step" in survey_module._convergence(found, records_of(found, halves))
    soft = survey_module._convergence(found, records_of(found, {}))
    assert "time step" not in soft
    assert soft["mesh"]["t"].order == pytest.approx(2.0)
