"""Verification: benchmarks/features.py counts the loop's own instructions and sums what Python says of imports."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from tailslap.scene.read import read_scene
from tailslap.studies.features.parts import PLAIN, fe_plan_of, parts_of

pytestmark = pytest.mark.verification

SCENE = "paper-table-3"


def load_benchmark() -> ModuleType:
    path = Path(__file__).parents[2] / "benchmarks" / "features.py"
    spec = importlib.util.spec_from_file_location("features_benchmark", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where its dataclasses look for their types
    spec.loader.exec_module(module)
    return module


benchmark = load_benchmark()

ASSEMBLY = """
\t.text
_ZN3fem9time_loop7advanceE:
\t.cfi_startproc
\tmovq\t%rdi, %rax
.LBB0_1:
\tvaddpd\t%ymm0, %ymm1, %ymm2
\t# a comment
\tretq
_ZN7cpython3fem9time_loop7advanceE:
\tcallq\t*%rax
"_ZN3fem4other.odd":
\tvmulpd\t(%rax), %zmm0, %zmm1
cfunc._ZN3fem9time_loop7advanceE:
\tretq
NRT_incref:
\tlock\tincq\t(%rdi)
.const.text:
\t.asciz\t"text"
"""


def test_instructions_are_the_loop_s_own() -> None:
    assert benchmark.count(ASSEMBLY) == benchmark.MachineCode(4, 2)


@pytest.mark.long
def test_a_part_has_instructions_only_where_it_is() -> None:
    """Counted on vector registers, where the arithmetic is; of other instructions the machine decides how many."""
    parts = {part.name: part for part in parts_of(read_scene(SCENE)[0])}
    plain, friction, damping = (
        benchmark.program_code(fe_plan_of(parts[n])) for n in (PLAIN, "friction", "damping")
    )
    assert 0 < plain.vector < friction.vector < damping.vector < damping.instructions


def test_imports_are_summed_by_package() -> None:
    report = (
        "import time: self [us] | cumulative | imported package\n"
        "import time:      1500 |       1500 |   numpy.core\n"
        "import time:       500 |       2000 | numpy\n"
        "import time:       250 |        250 | fem\n"
        "a warning that says import time: 99 | 99 | nothing\n"
    )
    assert benchmark.parse_imports(report) == pytest.approx({"numpy": 2e-3, "fem": 2.5e-4})


@pytest.mark.long
def test_whole_commands_are_run_and_their_imports_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """The rigid method alone, with a change; and a wrong scene is an error, not a time."""
    for name in ("check", "run --no-pictures", "run"):
        monkeypatch.delitem(benchmark.COMMANDS, name)
    (found,) = benchmark.find_processes(SCENE, ("vehicle.mass=5000",))
    assert found.name == "rigid"
    assert found.modules > 100
    assert 0.0 < max(value for _, value in found.packages) <= found.import_s
    assert "numpy" in dict(found.packages)
    with pytest.raises(OSError, match=r"vehicle\.mass"):
        benchmark.find_processes(SCENE, ("vehicle.mass=-1",))


def test_it_prints_a_line_for_each_part_and_the_bare_loop(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Counted on made-up assembly: what is printed, not what is compiled."""
    monkeypatch.setattr(benchmark, "_assembly", lambda loop, *arguments: ASSEMBLY)
    monkeypatch.setattr(sys, "argv", ["features.py", SCENE, "--no-commands"])
    benchmark.main()
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:3]] == ["instructions", PLAIN, "friction"]
    assert lines[-1].split() == ["bare", "loop", "4", "2"]
