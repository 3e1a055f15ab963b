"""Verify loops, verdicts and counts of benchmarks/features.py.

The bare loop has the bits of the program's and no code for a part. Verdicts are of artificial times with known ratios.
"""

import sys
from functools import partial

import features as benchmark
import numpy as np
import pytest

from fem.laws import constraints, materials
from fem.laws.friction import Drag
from fem.run.corner import Stepper
from fem.run.runner import copy_state
from fem.start.inertia_relief import RigidStart
from machine_code.compiled import Kernel
from meshes import distorted, plate_mesh
from tailslap.cli import _status
from tailslap.scene.read import read_scene

SCENE = "paper-table-3"
START = RigidStart(0.26, 0.707, 25.053)
STEPS = 300


def scene_of(*changes):
    return read_scene(SCENE, changes)[0]


@pytest.fixture(scope="module")
def models():
    """Of a scene that has parts itself."""
    changes = ("damping.ratio=0.1", "corner.patch_length=2", "material.law=neo-hookean", "time.threads=3")
    return benchmark.models_of(scene_of(*changes))


ASSEMBLY = """
\t.text
kernel_advance:
\t.cfi_startproc
\tmovq\t%rdi, %rax
.LBB0_1:
\tvaddpd\t%ymm0, %ymm1, %ymm2
\t# a comment
\tretq
f1_other:
\tvmulpd\t(%rax), %zmm0, %zmm1
.const.text:
\t.asciz\t"text"
"""


def test_instructions_are_the_loop_s_own():
    assert benchmark.count(ASSEMBLY) == benchmark.MachineCode(4, 2)


@pytest.mark.parametrize(
    "kind", ["quad4", *(pytest.param(kind, marks=pytest.mark.long) for kind in ("tri3", "distorted"))]
)
def test_the_bare_loop_computes_what_the_program_s_does(plate_model, kind):
    """Positions and velocities agree to rounding, on lattices and other meshes."""
    mesh = distorted(plate_mesh(10.0, 2.438, (8, 4)), 0.2, (8, 4)) if kind == "distorted" else None
    model = plate_model((8, 4), mesh=mesh, plate={"element": "tri3"} if kind == "tri3" else None)
    stepper = Stepper(model)
    start = stepper.start(START, "inertia-relief")
    later, mine = stepper.advance(start, STEPS), copy_state(start)
    force, scratch = np.zeros_like(mine.positions), benchmark.bare_scratch(model.parameters)
    bare = benchmark.bare_parameters(model.parameters)
    benchmark.advance_bare(mine.positions, mine.velocities, STEPS, bare, force, scratch)
    assert np.abs(later.positions - start.positions).max() > 0.1
    np.testing.assert_allclose(mine.positions, later.positions, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(mine.velocities, later.velocities, rtol=0.0, atol=1e-9)
    other = copy_state(start)
    softer = bare._replace(stiffness=0.5 * bare.stiffness)
    benchmark.advance_bare(other.positions, other.velocities, STEPS, softer, force, scratch)
    assert np.abs(other.positions - later.positions).max() > 1e-8


@pytest.mark.parametrize("changes", [
    {"reaction": "drag"}, {"corner": {"constraint": "exact"}}, {"corner": {"damping_ratio": 0.2}},
    {"corner": {"patch_length": 3.0}}, {"damping_ratio": 0.02}, {"plate": {"element": "quad4-reduced"}},
])  # fmt: skip
def test_the_bare_loop_refuses_what_it_has_no_code_for(plate_model, changes):
    with pytest.raises(ValueError, match="bare loop"):
        benchmark.bare_parameters(plate_model((8, 4), **changes).parameters)


def test_each_part_is_added_alone(models):
    """A model has the part of its name and no other."""
    for name, model in models.items():
        parameters = model.model.parameters
        corner, neo_hookean = parameters.corner, isinstance(parameters.material, materials.NeoHookean)
        parts = {
            "friction": isinstance(parameters.friction, Drag),
            "damping": parameters.viscosity is not None,
        }
        parts |= {"dashpot": corner.dashpot > 0.0, "patch": corner.nodes.size > 1, "neo-Hookean": neo_hookean}
        parts["exact constraint"] = isinstance(corner.constraint, constraints.Exact)
        parts["hourglass control"] = parameters.hourglass is not None
        assert {part for part, there in parts.items() if there} == {name} - {benchmark.PLAIN}
    assert len(models) == 8
    assert isinstance(models[benchmark.PLAIN].model.parameters.corner.constraint, constraints.Penalty)
    plain = benchmark.plain_scene(scene_of())
    assert benchmark.plain_scene(plain) == plain


def test_turns_go_forwards_and_back():
    order: list[int] = []

    def run(i):
        order.append(i)
        return float(10 * len(order) + i)

    runs = [partial(run, i) for i in range(3)]
    table = benchmark.take_turns(runs, 3)
    assert order == [0, 1, 2, 2, 1, 0, 0, 1, 2]
    assert table.tolist() == [[10, 21, 32], [60, 51, 42], [70, 81, 92]]


def test_a_slow_machine_cancels_turn_by_turn():
    """Times that double, and an outlier, do not change the ratio."""
    slow = np.where(np.arange(40) < 20, 1.0, 2.0)
    assert benchmark.ratio(1.3 * slow, slow) == pytest.approx((1.3, 1.3, 1.3), abs=1e-15)
    hit = 1.3 * slow
    hit[7] *= 100.0
    assert benchmark.ratio(hit, slow)[2] == pytest.approx(1.3, abs=1e-15)


def test_the_interval_of_a_ratio_covers_the_truth_as_often_as_it_says():
    """The bootstrap of a median covers 95 % of 300 samples."""
    random = np.random.default_rng(1)
    covered = 0
    for _ in range(300):
        times = 1.2 * np.exp(0.1 * random.normal(size=40))
        _, low, high = benchmark.ratio(times, np.exp(0.1 * random.normal(size=40)))
        covered += low <= 1.2 <= high
    assert 0.91 <= covered / 300 <= 0.99


def noisy(factor, noise, seed):
    return factor * np.exp(noise * np.random.default_rng(seed).normal(size=40))


@pytest.mark.parametrize(("factor", "noise", "expected"), [
    (1.00, 0.005, "free"), (1.03, 0.005, "free"), (1.08, 0.005, "costs"), (1.30, 0.1, "costs"),
    (1.00, 0.8, "unsettled"), (1.00, 0.02, "free"),
])  # fmt: skip
def test_verdicts_on_made_up_times(factor, noise, expected):
    plain, again, bare = noisy(factor, noise, 1), noisy(factor, noise, 2), noisy(1.0, noise, 3)
    assert benchmark.verdict(plain, again, bare) == expected


def test_a_noisy_machine_widens_the_limit():
    """7 % does not differ from a noise of 9 %."""
    ones = np.ones(40)
    assert benchmark.verdict(1.07 * ones, 1.07 * ones, ones) == "costs"
    assert benchmark.verdict(1.07 * ones, 1.07 * 1.09 * ones, ones) == "unsettled"
    assert benchmark.verdict(np.nan * ones, ones, ones) == "costs", "what is not known proves nothing"


@pytest.mark.parametrize(
    ("plain", "apart", "status"), [(1.0, 0.0, 0), (1.2, 0.0, 1), (1.0, 2e-9, 1), (1.0, np.nan, 1)]
)
def test_it_prints_a_line_a_loop_and_fails_where_the_proof_does(
    models, monkeypatch, capsys, plain, apart, status
):
    """On made-up assembly, times and positions, and arrays of one loop."""
    arrays, twenty = benchmark.workspace(models[benchmark.PLAIN]), 20.0 * np.ones(10)
    made_up = dict.fromkeys(("plain", "plain again"), plain * twenty) | {"bare loop": twenty}
    monkeypatch.setattr(benchmark, "workspace", lambda fe_plan: arrays)
    monkeypatch.setattr(Kernel, "assembly", lambda loop, *arguments: ASSEMBLY)
    timed = lambda models, turns: dict.fromkeys(models, 1.5 * twenty) | made_up  # noqa: E731
    monkeypatch.setattr(benchmark, "time_loops", timed)
    monkeypatch.setattr(benchmark, "difference", lambda model, steps: apart)
    monkeypatch.setattr(sys, "argv", ["features.py", SCENE, "--no-commands"])
    assert benchmark.main() == status
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [line[0] for line in lines[:3]] == ["loop", "plain", "friction"]
    assert lines[8][:5] == ["hourglass", "control", "4", "2", "30.00"]
    assert (lines[9][:5], lines[2][4]) == (["bare", "loop", "4", "2", "20.00"], f"{1.5 / plain:.3f}")


def test_the_two_loops_agree_and_can_be_timed(models, monkeypatch):
    monkeypatch.setattr(benchmark, "CHUNK_S", 1e-3)
    plain = models[benchmark.PLAIN]
    assert 0.0 <= benchmark.difference(plain, 200) <= benchmark.SAME
    updates = benchmark.time_loops({benchmark.PLAIN: plain}, 3)
    assert list(updates) == ["plain", "bare loop", "plain again"]
    assert all((rates > 0.0).all() and rates.shape == (3,) for rates in updates.values())


def test_the_study_of_features_says_where_it_went(capsys):
    assert _status(["study", "features", SCENE]) == 2
    said = capsys.readouterr().err
    assert [words for words in ("benchmarks/features.py", "tailslap check") if words not in said] == []


@pytest.mark.long
def test_a_part_has_instructions_only_where_it_is(models):
    """Arithmetic is counted on vector registers."""
    named = (models[name] for name in ("plain", "friction", "damping"))
    plain, friction, damping = map(benchmark.program_code, named)
    assert 0 < plain.vector < friction.vector < damping.vector < damping.instructions


def test_imports_are_summed_by_package():
    report = (
        "import time: self [us] | cumulative | imported package\n"
        "import time:      1500 |       1500 |   numpy.core\n"
        "import time:       500 |       2000 | numpy\n"
        "import time:       250 |        250 | fem\n"
        "a warning that says import time: 99 | 99 | nothing\n"
    )
    assert benchmark.parse_imports(report) == pytest.approx({"numpy": 2e-3, "fem": 2.5e-4})


@pytest.mark.long
def test_whole_commands_are_run_and_their_imports_read(monkeypatch):
    """The rigid method has a time, and a wrong scene an error."""
    for name in ("check", "run --no-pictures", "run"):
        monkeypatch.delitem(benchmark.COMMANDS, name)
    (rigid,) = benchmark.find_processes(SCENE, ("vehicle.mass=5000",))
    assert rigid.name == "rigid"
    assert rigid.modules > 100
    assert 0.0 < max(value for _, value in rigid.packages) <= rigid.import_s
    assert "numpy" in dict(rigid.packages)
    with pytest.raises(OSError, match=r"vehicle\.mass"):
        benchmark.find_processes(SCENE, ("vehicle.mass=-1",))
