"""Verification: the stability study on whole impacts calls each kind of cell by its name."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest

from tailslap.errors import InputError
from tailslap.scene.read import read_scene
from tailslap.scene.vary import Changes
from tailslap.studies.stability import impact_against_rigid as judge
from tailslap.studies.stability.axes import base_source, impact_axes, map_cells
from tailslap.studies.stability.campaign import run_campaign
from tailslap.studies.stability.verdict import verdict_on
from tailslap.studies.study import Call

pytestmark = pytest.mark.verification

TRUCK = "impact-mash-tl4-sut"


def verdict(changes: Changes) -> dict[str, Any]:
    base = base_source(read_scene(TRUCK)[0])
    verify = partial(judge.impact_against_rigid, tolerance=1e-2)
    return verdict_on(base, changes, verify, judge.IMPACTS)


def test_eight_axes_with_six_values_make_a_thousand_cells() -> None:
    scene = read_scene(TRUCK)[0]
    axes = {axis.name: axis.values for axis in impact_axes(scene, 6)}
    assert len(map_cells(scene, impact_axes(scene, 6))) == 28 * 36
    assert (axes["contact stiffness"][0], axes["contact stiffness"][-1]) == (
        pytest.approx(1e4),
        pytest.approx(1e9),
    )
    assert (axes["restitution"][-1], axes["friction"][-1], axes["angle"][-1]) == (
        1.0,
        2.0,
        pytest.approx(85.0),
    )
    stiff = read_scene(TRUCK, ("contact.stiffness=", "contact.restitution=", "contact.enforcement=exact"))[0]
    assert {axis.name for axis in impact_axes(stiff, 6)}.isdisjoint(
        {"contact stiffness", "restitution", "penalty"}
    )


def test_each_axis_changes_the_scene() -> None:
    scene = read_scene(TRUCK)[0]
    changed = [axis.changes(scene, axis.values[0]) for axis in impact_axes(scene, 3)]
    assert [next(iter(each)) for each in changed] == [
        "contact.stiffness",
        "contact.restitution",
        "contact.friction",
        "impact.angle",
        "impact.speed",
        "plate.youngs_modulus",
        "time.safety_factor",
        "vehicle.width",
    ]


@pytest.mark.long
def test_a_stiff_plate_is_right_and_what_cannot_be_is_refused() -> None:
    right = verdict({})
    assert (right["kind"], right["model"]) == ("right", "quad4 20 x 6")
    assert 1e-4 < right["difference"] < 1e-2
    assert verdict({"contact.restitution": 1.1})["kind"] == "refused"
    assert verdict({"time.safety_factor": 1.2})["kind"] == "refused"


class Outcome(SimpleNamespace):
    """As much of an outcome as is judged."""


def outcome(impulse: float, error: float, passed: bool = True, corner: str = "rear") -> Any:
    strikes = [SimpleNamespace(corner="front", impulse=1.0, peak_force=1.0, duration=1.0)]
    strikes.append(SimpleNamespace(corner=corner, impulse=1.0 + impulse, peak_force=1.0, duration=1.0))
    rigid = [
        SimpleNamespace(corner=name, impulse=1.0, peak_force=1.0, duration=1.0) for name in ("front", "rear")
    ]
    return Outcome(
        fe=SimpleNamespace(strikes=strikes),
        rigid=SimpleNamespace(strikes=rigid),
        difference={"strike_1.impulse": 0.0, "strike_2.impulse": impulse, "strike_2.duration": 9.0},
        mesh_error={"strike_2.impulse": error},
        passed=passed,
        checks=(SimpleNamespace(name="mesh", passed=passed),),
        fe_plan=SimpleNamespace(plate=SimpleNamespace(element="quad9", counts=(4, 2))),
    )


def judged(monkeypatch: pytest.MonkeyPatch, own: Any, refined: Any) -> str:
    monkeypatch.setattr(judge, "_refined", lambda outcome: refined)
    return judge.impact_against_rigid(own, 1e-2).kind


def test_verdicts_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    """Right near the rigid vehicle; beyond, the refined model decides, within tolerance and three claimed errors."""
    assert judged(monkeypatch, outcome(5e-3, 0.0), None) == "right"
    assert judged(monkeypatch, outcome(0.1, 0.0, passed=False), None) == "caught"
    assert judged(monkeypatch, outcome(0.1, 0.0), None) == "wrong"
    assert judged(monkeypatch, outcome(0.1, 0.0), outcome(0.1, 0.0)) == "flexible"
    assert judged(monkeypatch, outcome(0.1, 0.01), outcome(0.14, 0.0)) == "flexible"
    assert judged(monkeypatch, outcome(0.1, 0.01), outcome(0.16, 0.0)) == "wrong"
    assert judged(monkeypatch, outcome(0.1, 0.0), outcome(0.1, 0.0, corner="front")) == "wrong"
    assert judged(monkeypatch, outcome(0.0, 0.0, corner="front"), None) == "wrong"


def test_random_cells_are_of_the_corner_alone() -> None:
    plan = SimpleNamespace(scene=read_scene(TRUCK)[0])
    with pytest.raises(InputError, match="--random"):
        run_campaign(Call(TRUCK, (), plan, None), None, None, 5, 1, 1)
