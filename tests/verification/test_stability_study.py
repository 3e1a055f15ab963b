"""Verification: the stability study calls each kind of cell by its name, and an interrupted study goes on."""

import contextlib
import json
import math
import operator
import signal
import sqlite3
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from postprocess.report.report import write_report
from tailslap.campaign.engine import run_parts
from tailslap.campaign.records import Journal, count
from tailslap.case.corner.case import CornerCase
from tailslap.case.corner.error import NumericalError
from tailslap.errors import InputError, Interrupted, Verbatim
from tailslap.scene.read import read_scene
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, changed_tables
from tailslap.studies.stability import compute as study
from tailslap.studies.stability.compute import MAP_KINDS, Found, axes_of, base_source, map_cells
from tailslap.studies.stability.report import caught_by, headline, refused_by, report

COARSE = ("plate.elements=[10,3]",)


def verdict(first: str, x: float, second: str, y: float, *changes: str) -> dict[str, Any]:
    scene = read_scene("paper-table-3", (*COARSE, *changes))[0]
    by_name = {axis.name: axis for axis in axes_of(scene, 3)}
    return verdict_of(scene, {**by_name[first].changes(scene, x), **by_name[second].changes(scene, y)})


def verdict_of(scene: Scene, changes: Changes) -> dict[str, Any]:
    tolerance = 1e-2 if scene.contact else 1e-3
    return study.judge(base_source(scene), changes, partial(study.against_rigid, tolerance=tolerance))


def test_eight_axes_with_ten_values_make_2800_cells():
    scene = read_scene("paper-table-3")[0]
    assert len(map_cells(scene, axes_of(scene, 10))[0]) == 28 * 100
    frictionless = read_scene("paper-abaqus", ("corner.constraint=exact",))[0]
    assert {axis.name for axis in axes_of(frictionless, 10)}.isdisjoint({"friction", "penalty"})


def test_cells_of_a_scene_that_starts_with_stage_one_change_its_impact():
    scene = read_scene("mash-tl4-sut")[0]
    base = base_source(scene)
    axes = tuple(axis for axis in axes_of(scene, 3) if axis.name in ("speed", "angle"))
    cells, places = map_cells(scene, axes)
    changes = next(cells[key] for key, place in places.items() if place["first_value"] > 1.0)
    changed = changed_tables(base.given, changes)[0]
    assert changed["impact"]["speed"] == 10.0 * base.given["impact"]["speed"]
    assert changed["impact"]["angle"] == pytest.approx(math.radians(1.0))
    assert "wall" not in changed
    assert 0.2 < base.given["impact"]["angle"] < 0.3


@pytest.mark.parametrize(
    ("cell", "kind"),
    [
        (("stiffness", 1.0, "friction", 0.2), "right"),
        pytest.param(("stiffness", 1e-4, "friction", 0.2), "flexible", marks=pytest.mark.long),
        (("time step", 1.2, "friction", 0.2), "refused"),
        (("stiffness", 1e-4, "penalty", 0.01), "caught"),
    ],
)
def test_each_kind_of_cell(cell, kind):
    assert verdict(*cell)["kind"] == kind


def test_a_soft_slender_plate_follows_its_loads_and_is_confirmed():
    """The damping that its flutter is predicted to take would hold it back by more than a third of its flexibility."""
    scene = read_scene("paper-table-3")[0]
    strip = {"vehicle.width": 0.46415888336127774, "plate.youngs_modulus": 0.000774263682681127 * 2e11}
    found = verdict_of(scene, strip)
    assert found["kind"] == "flexible"
    assert found["difference"] == pytest.approx(0.0358, rel=0.01)
    assert found["error"] < 5e-4


@pytest.mark.long
def test_a_wrong_number_that_no_check_catches_is_wrong(monkeypatch):
    monkeypatch.setattr("tailslap.case.corner.run.evaluated", lambda *arguments: ())
    soft_spring = verdict("stiffness", 1e-4, "penalty", 0.01)
    assert soft_spring["kind"] == "wrong"
    assert "its own numerical error" in soft_spring["reason"]
    monkeypatch.setattr("tailslap.case.corner.checks.Evidence.error", NumericalError(*7 * [0.0]))
    unaware = verdict("stiffness", 1e-4, "penalty", 0.01)
    assert unaware["kind"] == "wrong"
    assert "changes it by" in unaware["reason"]


@pytest.mark.long
def test_a_cell_of_a_scene_that_leaves_mesh_and_constraint_open_is_confirmed():
    scene = read_scene("paper-table-3", ("plate.elements=",))[0]
    assert scene.plate is not None
    assert scene.plate.youngs_modulus is not None
    softer = {"plate.youngs_modulus": 1e-4 * scene.plate.youngs_modulus}
    assert verdict_of(scene, softer)["kind"] == "flexible"


def test_a_program_that_breaks_has_not_refused(monkeypatch):
    def breaks(*arguments: Any) -> None:
        raise ZeroDivisionError("boom")

    monkeypatch.setattr("tailslap.case.corner.run.evaluated", breaks)
    broken = verdict("stiffness", 1.0, "friction", 0.2)
    assert (broken["kind"], broken["reason"]) == ("wrong", "broke: ZeroDivisionError: boom")


TRUCK = "impact-mash-tl4-sut"


def test_axes_of_a_whole_impact_make_a_thousand_cells_and_each_changes_the_scene():
    scene = read_scene(TRUCK)[0]
    axes = {axis.name: axis for axis in axes_of(scene, 6)}
    assert len(map_cells(scene, axes_of(scene, 6))[0]) == 28 * 36
    stiffness = axes["contact stiffness"].values
    assert (stiffness[0], stiffness[-1]) == (pytest.approx(1e4), pytest.approx(1e9))
    ends = [axes[name].values[-1] for name in ("restitution", "friction", "angle")]
    assert ends == [1.0, 2.0, pytest.approx(85.0)]
    assert [next(iter(axis.changes(scene, axis.values[0]))) for axis in axes.values()] == [
        *("contact.stiffness", "contact.restitution", "contact.friction", "impact.angle", "impact.speed"),
        *("plate.youngs_modulus", "time.safety_factor", "vehicle.width"),
    ]
    stiff = read_scene(TRUCK, ("contact.stiffness=", "contact.restitution=", "contact.enforcement=exact"))[0]
    absent = {"contact stiffness", "restitution", "penalty"}
    assert {axis.name for axis in axes_of(stiff, 6)}.isdisjoint(absent)


@pytest.mark.long
def test_a_stiff_plate_s_impact_is_right_and_what_cannot_be_is_refused():
    scene = read_scene(TRUCK)[0]
    right = verdict_of(scene, {})
    assert (right["kind"], right["model"]) == ("right", "quad4 20 x 6")
    assert 1e-4 < right["difference"] < 1e-2
    assert verdict_of(scene, {"contact.restitution": 1.1})["kind"] == "refused"
    assert verdict_of(scene, {"time.safety_factor": 1.2})["kind"] == "refused"


def impact(impulse: float, error: float, passed: bool = True, corner: str = "rear") -> Any:
    """As much of an outcome as is judged."""

    def answer(corner: str, impulse: float) -> Any:
        strikes = [("front", 1.0), (corner, 1.0 + impulse)]
        return SimpleNamespace(
            strikes=[SimpleNamespace(corner=c, impulse=j, peak_force=1.0, duration=1.0) for c, j in strikes]
        )

    plate = SimpleNamespace(element="quad9", counts=(4, 2))
    return SimpleNamespace(
        fe=answer(corner, impulse),
        rigid=answer("rear", 0.0),
        difference={"strike_1.impulse": 0.0, "strike_2.impulse": impulse, "strike_2.duration": 9.0},
        mesh_error={"strike_2.impulse": error},
        passed=passed,
        checks=(SimpleNamespace(name="mesh", passed=passed),),
        fe_plan=SimpleNamespace(plate=plate, case=SimpleNamespace(scene=read_scene(TRUCK)[0])),
    )


@pytest.mark.parametrize(
    ("own", "refined", "kind"),
    [
        (impact(5e-3, 0.0), None, "right"),
        (impact(0.1, 0.0, passed=False), None, "caught"),
        (impact(0.1, 0.0), None, "wrong"),
        (impact(0.1, 0.0), impact(0.1, 0.0), "flexible"),
        (impact(0.1, 0.01), impact(0.14, 0.0), "flexible"),
        (impact(0.1, 0.01), impact(0.16, 0.0), "wrong"),
        (impact(0.1, 0.0), impact(0.1, 0.0, corner="front"), "wrong"),
        (impact(0.0, 0.0, corner="front"), None, "wrong"),
    ],
)
def test_verdicts_on_impacts(own, refined, kind, monkeypatch):
    """Right near the rigid vehicle; beyond, the refined model decides, within tolerance and three claimed errors."""
    monkeypatch.setattr(study, "refined_run", lambda case, changes: refined)
    assert study.against_rigid(own, 1e-2)["kind"] == kind


def test_random_cells_are_of_the_corner_alone(tmp_path):
    case = SimpleNamespace(scene=read_scene(TRUCK)[0])
    with pytest.raises(InputError, match="--random"):
        study.compute(case, tmp_path, None, None, 5, 1, 1)


@pytest.fixture
def journal(tmp_path):
    return lambda **definition: Journal(tmp_path / "out", definition)


def interrupt(journal: Journal, records: dict[str, Any]) -> None:
    with journal as begun:
        for key, record in records.items():
            begun.add(key, record)
        raise KeyboardInterrupt


def test_journal_is_taken_up_after_an_interrupt_and_removed_at_the_end(journal, tmp_path):
    records = {"x": {"value": 1.5}, "y": {"value": float("inf")}}
    with pytest.raises(Interrupted, match="2 parts are kept"):
        interrupt(journal(a=1), records)
    with journal(a=1) as again:
        assert again.records == records
    assert list(tmp_path.iterdir()) == []


def test_journal_of_another_definition_is_begun_anew(journal):
    with pytest.raises(Interrupted):
        interrupt(journal(a=1), {"x": 1})
    with journal(a=2) as other:
        assert other.records == {}


@pytest.mark.parametrize("foreign", [b"", b"diary\n", b"\xff\xfe\n", b"SQLite format 3\0" + bytes(4080)])
def test_a_file_that_is_no_journal_is_refused_and_kept(journal, foreign):
    path = journal(a=1).path
    path.write_bytes(foreign)
    with pytest.raises(InputError, match=r"\.out\.journal.* no journal"), journal(a=1):
        pass
    assert path.read_bytes() == foreign
    assert [found.name for found in path.parent.iterdir()] == [path.name]


def test_a_link_in_the_place_of_the_journal_is_refused(journal, tmp_path):
    with pytest.raises(Interrupted):
        interrupt(journal(a=1), {"x": 1})
    path = journal(a=1).path
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="no journal"), journal(a=1):
        pass
    assert path.is_symlink()


def test_a_journal_is_not_lost_if_it_cannot_be_begun_anew(journal, monkeypatch):
    """Another program writes to it, say."""
    with pytest.raises(Interrupted):
        interrupt(journal(a=1), {"x": 1})
    monkeypatch.setattr("tailslap.campaign.records.PATIENCE_S", 0.1)
    with contextlib.closing(sqlite3.connect(journal(a=1).path)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises((InputError, OSError), match="locked"), journal(a=2):
            pass
    with journal(a=1) as again:
        assert again.records == {"x": 1}


def test_parts_that_the_journal_has_are_not_run_again(journal):
    with journal(a=1) as noted:
        noted.add("seven", "kept")
        run_parts(operator.add, {"seven": (3, 4), "five": (2, 3)}, noted, "adding", workers=1)
        assert noted.records == {"seven": "kept", "five": 5}


def test_page_and_summary_say_what_was_found(tmp_path):
    case = CornerCase(*read_scene("paper-table-3"))
    axes = axes_of(case.scene, 2)[:2]
    cells, places = map_cells(case.scene, axes)
    verdicts = (
        study.verdict("right"),
        study.verdict("caught", failed="energy balance, mesh"),
        study.verdict("refused", reason="k: given 3; allowed less"),
        study.verdict("wrong", reason="x"),
    )
    rows = {key: places[key] | verdict for key, verdict in zip(cells, verdicts, strict=True)}
    found = Found(case, base_source(case.scene), axes, {"tolerance": 1e-3}, MAP_KINDS, cells, rows, 1.0)
    assert "1 are wrong without" in headline(found)
    assert caught_by(found) == {"energy balance": 1, "mesh": 1}
    assert refused_by(found) == {"k: allowed less": 1}
    write_report(report(found), tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["counts"] == {"right": 1, "flexible": 0, "refused": 1, "caught": 1, "wrong": 1}
    assert not summary["passed"]
    assert len(summary["wrong"]) == 1
    page = (tmp_path / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    assert page.count("<svg") == 2  # the map, and what its colours mean
    assert "passed every check, and is not right" in page
    assert next(iter(found.of_kind("wrong"))) in page
    assert "k: allowed less" in page
    assert "a smaller time.safety_factor" in page
    assert "failed</span>" in page
    assert len((tmp_path / "cells.csv").read_text().splitlines()) == 5


@pytest.mark.long
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_study_that_is_ended_keeps_what_was_done_and_leaves_no_process(tmp_path, sent):
    """Two parts sleep for ten minutes; the study ends at once, however it is ended, and its workers with it."""
    code = (
        "import time\n"
        "from pathlib import Path\n"
        "from tailslap.campaign.engine import run_parts\n"
        "from tailslap.campaign.records import Journal\n"
        "if __name__ == '__main__':\n"
        "    parts = {'short': (0.0,), 'long': (600.0,), 'longer': (600.0,)}\n"
        f"    with Journal(Path({str(tmp_path / 'out')!r}), {{}}) as journal:\n"
        "        run_parts(time.sleep, parts, journal, 'x', workers=2)\n"
    )
    script = tmp_path / "script.py"
    script.write_text(code)
    journal = tmp_path / ".out.journal"
    study = subprocess.Popen([sys.executable, str(script)], stderr=subprocess.PIPE, text=True)
    for _ in range(4800):
        if journal.is_file() and count(journal):
            break
        time.sleep(0.05)
    below = children(study.pid)
    assert len(below) >= 2
    began = time.monotonic()
    study.send_signal(sent)
    _, error = study.communicate(timeout=120)
    while any(map(alive, below)):
        assert time.monotonic() - began < 120.0
        time.sleep(0.05)
    assert ("1 parts are kept" in error) == (sent == signal.SIGINT)
    assert count(journal) == 1


def children(pid: int) -> list[int]:
    """Processes that this one has started, and those that they have."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            if int(path.read_text().rpartition(")")[2].split()[1]) == pid:
                found.append(int(path.parent.name))
    return [*found, *(below for child in found for below in children(child))]


def alive(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    return False


@pytest.mark.long
def test_a_part_s_error_is_raised_as_it_was(journal):
    """Also where it was made on another process, and what was done before is kept."""
    for workers in (1, 2):
        with pytest.raises(InputError, match="SCENE: given nothing-1; x"), journal(workers=workers) as noted:
            run_parts(raising, {"a": (0,), "b": (1,)}, noted, "raising", workers)
        with journal(workers=workers) as again:
            assert again.records == {"a": 0}


def raising(number: int) -> int:
    if number:
        time.sleep(1.0)
        raise InputError("SCENE", Verbatim(f"nothing-{number}"), "x")
    return number
