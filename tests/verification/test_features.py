"""Verification: the study `features`: its bare loop against the program's, its bookkeeping and its verdicts on made-up
times, whose ratios are known. No test looks at real times."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fem.constitutive.materials import NeoHookean
from fem.contact.constraints import DampedPenalty, Exact, Penalty
from fem.contact.friction import Drag
from fem.explicit.simulate import Stepper
from fem.explicit.time_loop import copy_state
from fem.start.rigid_state import RigidStart
from meshes import distorted, plate_mesh
from postprocess.report.report import write_report
from tailslap.command_line import _status
from tailslap.planning.plan import make_plan
from tailslap.scene.read import read_scene
from tailslap.studies import study_names
from tailslap.studies.features import costs as costs_module
from tailslap.studies.features import loops as loops_module
from tailslap.studies.features.bare import advance_bare, bare_parameters, bare_scratch
from tailslap.studies.features.costs import find_costs
from tailslap.studies.features.loops import Loop, difference
from tailslap.studies.features.parts import PLAIN, fe_plan_of, parts_of, plain_scene
from tailslap.studies.features.proof import COSTS, FREE, UNSETTLED, Proof, prove
from tailslap.studies.features.report import conclusion, costs_report, headline, sentences
from tailslap.studies.features.timing import Ratio, ratio, spread, take_turns

pytestmark = pytest.mark.verification

SCENE = "paper-table-3"
START = RigidStart(0.26, 0.707, 25.053)
STEPS = 300


def scene_of(*changes: str) -> Any:
    return read_scene(SCENE, changes)[0]


@pytest.mark.parametrize(
    "kind", ["quad4", *(pytest.param(kind, marks=pytest.mark.long) for kind in ("tri3", "distorted"))]
)
def test_the_bare_loop_computes_what_the_program_s_does(plate_model: Callable[..., Any], kind: str) -> None:
    """Positions and velocities to rounding, on lattices and on elements that are looked up, over a time that shows."""
    mesh = distorted(plate_mesh(10.0, 2.438, (8, 4)), 0.2, (8, 4)) if kind == "distorted" else None
    model = plate_model((8, 4), mesh=mesh, plate={"element": "tri3"} if kind == "tri3" else None)
    stepper = Stepper(model)
    start = stepper.start(START, "inertia-relief")
    later, mine = stepper.advance(start, STEPS), copy_state(start)
    force, scratch = np.zeros_like(mine.positions), bare_scratch(model.loop)
    bare = bare_parameters(model.loop)
    advance_bare(mine.positions, mine.velocities, STEPS, bare, force, scratch)
    assert np.abs(later.positions - start.positions).max() > 0.1
    np.testing.assert_allclose(mine.positions, later.positions, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(mine.velocities, later.velocities, rtol=0.0, atol=1e-9)
    other = copy_state(start)
    softer = bare._replace(stiffness=0.5 * bare.stiffness)
    advance_bare(other.positions, other.velocities, STEPS, softer, force, scratch)
    assert np.abs(other.positions - later.positions).max() > 1e-8


@pytest.mark.parametrize(
    "changes",
    [
        {"reaction": "drag"},
        {"corner": {"constraint": "exact"}},
        {"corner": {"damping_ratio": 0.2}},
        {"corner": {"patch_length": 3.0}},
        {"damping_ratio": 0.02},
        {"plate": {"element": "quad4-reduced"}},
    ],
)
def test_the_bare_loop_refuses_what_it_has_no_code_for(
    plate_model: Callable[..., Any], changes: dict[str, Any]
) -> None:
    with pytest.raises(ValueError, match="bare loop"):
        bare_parameters(plate_model((8, 4), **changes).loop)


def test_each_part_is_added_alone() -> None:
    """Whatever parts the scene itself has, a model has the one of its name and no other."""
    scene = scene_of(
        "damping.ratio=0.1", "corner.patch_length=2", "material.law=neo-hookean", "time.threads=3"
    )
    parts = {part.name: part for part in parts_of(scene)}
    found = {}
    for name, part in parts.items():
        loop = fe_plan_of(part).model.loop
        found[name] = {
            label
            for label, there in (
                ("friction", isinstance(loop.friction, Drag)),
                ("damping", loop.viscosity is not None),
                ("dashpot", isinstance(loop.corner.constraint, DampedPenalty)),
                ("exact constraint", isinstance(loop.corner.constraint, Exact)),
                ("patch", loop.corner.nodes.size > 1),
                ("neo-Hookean", isinstance(loop.material, NeoHookean)),
                ("hourglass control", loop.hourglass is not None),
            )
            if there
        }
    given = found.pop("the scene as given")
    assert given == {"friction", "damping", "patch", "neo-Hookean"}
    assert found.pop("one-point elements") == {"hourglass control"}
    assert found.pop("two threads", set()) == found.pop(PLAIN) == set()
    assert found == {name: {name} for name in found}
    assert len(found) == 7
    assert isinstance(fe_plan_of(parts[PLAIN]).model.loop.corner.constraint, Penalty)
    assert "0.1" in parts["damping"].what
    assert "2" in parts["patch"].what


def test_a_plain_scene_has_nothing_but_itself() -> None:
    plain = plain_scene(scene_of())
    assert plain_scene(plain) == plain
    assert "the scene as given" not in {part.name for part in parts_of(plain)}


def test_turns_go_forwards_and_back() -> None:
    order: list[int] = []
    shares: list[float] = []
    runs = [lambda i=i: float(order.append(i) or 10 * len(order) + i) for i in range(3)]  # type: ignore[func-returns-value]
    table = take_turns(runs, 3, shares.append)
    assert order == [0, 1, 2, 2, 1, 0, 0, 1, 2]
    assert table.tolist() == [[10, 21, 32], [60, 51, 42], [70, 81, 92]]
    assert shares == pytest.approx([1 / 3, 2 / 3, 1.0])


def test_a_slow_machine_cancels_turn_by_turn() -> None:
    """Times that double half-way, and one that is hit a hundredfold: the ratio stays what it is, to the digit."""
    slow = np.where(np.arange(40) < 20, 1.0, 2.0)
    found = ratio(1.3 * slow, slow)
    assert (found.median, found.low, found.high) == pytest.approx((1.3, 1.3, 1.3), abs=1e-15)
    hit = 1.3 * slow
    hit[7] *= 100.0
    assert ratio(hit, slow).high == pytest.approx(1.3, abs=1e-15)


def test_the_interval_of_a_ratio_covers_the_truth_as_often_as_it_says() -> None:
    """300 samples of 40 turns with 10 % noise: the bootstrap of a median covers 95 %, within its own noise."""
    random = np.random.default_rng(1)
    covered = 0
    for _ in range(300):
        times = 1.2 * np.exp(0.1 * random.normal(size=40))
        found = ratio(times, np.exp(0.1 * random.normal(size=40)))
        covered += found.low <= 1.2 <= found.high
    assert 0.91 <= covered / 300 <= 0.99


def test_spread_of_known_times() -> None:
    found = spread(np.array([5.0, 1.0, 2.0, 4.0, 3.0]))
    assert vars(found) == {"best": 1.0, "median": 3.0, "lower_quartile": 2.0, "upper_quartile": 4.0}


def times(factor: float, noise: float, seed: int) -> np.ndarray:
    return factor * np.exp(noise * np.random.default_rng(seed).normal(size=40))


@pytest.mark.parametrize(
    ("factor", "noise", "verdict"),
    [
        (1.00, 0.005, FREE),
        (1.03, 0.005, FREE),
        (1.08, 0.005, COSTS),
        (1.30, 0.1, COSTS),
        (1.00, 0.8, UNSETTLED),
        (1.00, 0.02, FREE),
    ],
)
def test_verdicts_on_made_up_times(factor: float, noise: float, verdict: str) -> None:
    plain, again, bare = times(factor, noise, 1), times(factor, noise, 2), times(1.0, noise, 3)
    proof = prove(plain, again, bare, 1e-14, 1000)
    assert proof.verdict == verdict
    assert proof.passed == (verdict != COSTS)
    words = {FREE: "costs no measurable", COSTS: "FAILED: a part left out costs", UNSETTLED: "too noisy"}
    assert words[verdict] in conclusion(proof)


def test_a_noisy_machine_widens_the_limit() -> None:
    """7 % against the bare loop is not told from the 9 % of the same loop against itself; nor is it nothing."""
    quiet, loud = Ratio(1.0, 0.99, 1.01), Ratio(1.04, 0.99, 1.09)
    program = Ratio(1.07, 1.06, 1.08)
    assert Proof(program, quiet, 0.0, 1).verdict == COSTS
    assert Proof(program, loud, 0.0, 1).verdict == UNSETTLED


@pytest.mark.parametrize("apart", [2e-9, math.nan])
def test_loops_that_compute_different_things_prove_nothing(apart: float) -> None:
    same = Ratio(1.0, 1.0, 1.0)
    proof = Proof(same, same, apart, 1000)
    assert not proof.passed
    assert "FAILED: the two loops do not compute the same" in conclusion(proof)
    assert not Proof(Ratio(math.nan, math.nan, math.nan), same, 0.0, 1).passed


FAKE = {
    "friction": 1.1,
    "damping": 1.5,
    "bare loop": 1.0,
    "one-point elements": 0.5,
    "hourglass control": 0.7,
}
"""Times over the plain loop's, which takes 20 ns an element update."""


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """The study with loops whose times are made up; models, set-up and files are real."""

    def fake(name: str, plain: float) -> Loop:
        update = 20e-9 * (plain if name.startswith("plain") else FAKE[name])
        return Loop(name, lambda steps: update * 120 * steps, 120, 0.25)

    def prepare(plain: float = 1.0) -> None:
        monkeypatch.setattr(costs_module, "program_loop", lambda name, fe_plan, part: fake(name, plain))
        monkeypatch.setattr(costs_module, "bare_loop", lambda name, fe_plan: fake(name, plain))
        monkeypatch.setattr(costs_module, "rows_of_history", lambda fe_plan, rows: lambda: rows * 10e-6)
        wanted = {PLAIN, "friction", "damping", "one-point elements", "hourglass control"}
        chosen = [part for part in parts_of(scene_of()) if part.name in wanted]
        monkeypatch.setattr(costs_module, "parts_of", lambda scene: chosen)

    return prepare


@pytest.mark.long
def test_the_books_are_exact(made_up: Callable[..., Any], tmp_path: Path) -> None:
    """Made-up times come back as ratios, nanoseconds, seconds of the whole run, in the summary and in the table."""
    made_up()
    found = find_costs(make_plan(*read_scene(SCENE)), 12)
    by_name = {cost.part: cost for cost in found.costs}
    assert found.elements == 120
    for name, against in (("friction", 1.1), ("damping", 1.5), ("hourglass control", 0.7 / 0.5)):
        ends = by_name[name].ratio
        assert ends is not None
        assert (ends.median, ends.low, ends.high) == pytest.approx(3 * (against,), rel=1e-12)
        assert by_name[name].update_ns.median == pytest.approx(20.0 * FAKE[name], rel=1e-12)
    plain = by_name[PLAIN]
    assert plain.ratio is None
    assert plain.time_loop_s == pytest.approx(20e-9 * 120 * plain.steps, rel=1e-12)
    assert found.history.over_loop.median == pytest.approx(390 * 10e-6 / plain.time_loop_s, rel=1e-12)
    assert (found.proof.verdict, found.proof.passed) == (FREE, True)
    write_report(costs_report(found), tmp_path)
    _files_agree(tmp_path)
    assert headline(found).endswith("damping costs most: 1.500 (1.500 to 1.500) times the loop without it.")


def _files_agree(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} == {
        *("summary.json", "features.csv", "turns.csv", "report.html", "features.svg"),
    }
    summary = json.loads((folder / "summary.json").read_text())
    with (folder / "features.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["part"] for row in rows] == [part["part"] for part in summary["parts"]]
    for row, part in zip(rows, summary["parts"], strict=True):
        assert float(row["update_ns_median"]) == part["update_ns"]["median"]
        assert float(row["time_loop_s"]) == part["time_loop_s"]
        assert row["ratio_low"] == (str(part["ratio"]["low"]) if part["ratio"] else "")
    turns = (folder / "turns.csv").read_text().splitlines()
    assert len(turns) == 13
    assert turns[0].split(",")[:3] == ["plain", "bare loop", "plain again"]
    page = (folder / "report.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    for words in (
        "passed",
        "hourglass control",
        "no measurable time",
        "<svg",
        "1.500 (1.500 to 1.500)",
        "The proof",
    ):
        assert words in page, words
    assert not re.search("https?:", page.replace("http://www.w3.org", ""))


@pytest.mark.parametrize(("plain", "status"), [(1.0, 0), pytest.param(1.2, 1, marks=pytest.mark.long)])
def test_exit_status_and_folder(
    made_up: Callable[..., Any],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    plain: float,
    status: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A fifth more than the bare loop fails, with the files there to say so."""
    made_up(plain)
    monkeypatch.chdir(tmp_path)
    assert _status(["study", "features", SCENE, "--turns", "10"]) == status
    out, err = capsys.readouterr()
    assert err == ""
    assert ("FAILED" in out) == bool(status)
    folder = tmp_path / "results" / f"{SCENE}-features"
    assert json.loads((folder / "summary.json").read_text())["passed"] is (status == 0)
    assert ("failed</span>" in (folder / "report.html").read_text()) == bool(status)


@pytest.mark.long
def test_a_part_that_the_scene_cannot_have_is_named(made_up: Callable[..., Any]) -> None:
    made_up()
    first, *others = costs_module.parts_of(scene_of())
    corner = others[0].scene.corner.model_copy(update={"patch_length": 100.0})
    broken = replace(others[0], scene=others[0].scene.model_copy(update={"corner": corner}))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(costs_module, "parts_of", lambda scene: [first, broken, *others[1:]])
        found = find_costs(make_plan(*read_scene(SCENE)), 10)
    assert list(found.refused) == ["friction"]
    assert "friction" not in {cost.part for cost in found.costs}
    assert any(said.startswith("Omitted: friction. corner.patch_length") for said in sentences(found))


@pytest.mark.long
def test_real_loops_run_and_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    """The study with its own loops, three parts and short chunks."""
    monkeypatch.setattr(loops_module, "CHUNK_S", 1e-3)
    chosen = [part for part in parts_of(scene_of()) if part.name in (PLAIN, "friction", "two threads")]
    monkeypatch.setattr(costs_module, "parts_of", lambda scene: chosen)
    found = find_costs(make_plan(*read_scene(SCENE)), 10)
    assert found.proof.same
    assert found.proof.steps == 1000
    assert all(cost.update_ns.best > 0.0 for cost in found.costs)
    assert difference(fe_plan_of(chosen[0]), 5) <= found.proof.difference + 1e-15


def test_the_study_is_found_and_refuses_wrong_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "features" in study_names()
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bare.toml").write_text(
        'name = "bare"\n[vehicle]\nlength = 10\nwidth = 2.438\nmass = 9979\n'
        "[impact]\nspeed = 25\nangle = 0.26\nfriction = 0.4\nrestitution = 0.2\n"
    )
    for arguments, key in (
        ((SCENE, "--turns", "3"), "--turns"),
        ((SCENE, "--out", "/proc/nowhere/x"), "--out"),
        (("bare.toml",), "plate"),
        (("no-such-scene",), "SCENE"),
        ((SCENE, "--set", "plate.elements=[0, 1]"), "plate.elements"),
    ):
        assert _status(["study", "features", *arguments]) == 2
        assert key in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["bare.toml"]
