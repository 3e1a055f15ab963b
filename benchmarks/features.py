"""What the parts of a scene add to the compiled loop, in instructions, and what whole commands spend on imports.

    .venv/bin/python benchmarks/features.py [SCENE] [--set KEY=VALUE ...] [--no-commands]

Instructions are counted in LLVM's assembly of the program's loop with each part that `tailslap study features` times,
and of the study's bare loop, which has no code for them: a part left out must have none. Commands run in fresh
processes: seconds, modules loaded, and where the time of imports goes by Python's own report.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fem.explicit.time_loop import advance
from fem.machine_code.kernel import Kernel
from fem.machine_code.numba_code import compile_for, make_dispatcher
from tailslap.planning.fe_plan import FePlan
from tailslap.planning.plan import make_plan
from tailslap.scene.read import read_scene
from tailslap.studies import with_elements
from tailslap.studies.features.bare import advance_bare, bare_parameters, bare_scratch
from tailslap.studies.features.loops import start_state, without_control, workspace
from tailslap.studies.features.parts import PLAIN, fe_plan_of, parts_of, refusal
from tailslap.studies.features.timing import Spread, seconds, spread, take_turns

VECTOR = re.compile(r"%[xyz]mm\d|\bv\d+\.\d")


TURNS = 2
"""Times that each command is run to be timed; a third run, slower, reports its imports."""

COMMANDS = {
    "rigid": ("rigid",),
    "check": ("check",),
    "run --no-pictures": ("run", "--no-pictures"),
    "run": ("run",),
}

CODE = (
    "import sys\nfrom tailslap.command_line import _status\n"
    "status = _status(sys.argv[1:])\nprint()\nprint(len(sys.modules))\nsys.exit(status)\n"
)


@dataclass(frozen=True)
class MachineCode:
    """Instructions in the loop and what it calls, and those of them on vector registers."""

    instructions: int
    vector: int


def count(assembly: str) -> MachineCode:
    """Counts in LLVM's assembly; the wrappers that Python calls through and reference counts are not the loop's."""
    instructions = vector = 0
    own = False
    for line in assembly.splitlines():
        if line[:1].isalnum() or line[:1] in '_"':
            name = line.strip('"')
            own = name.startswith("_Z") and not name.startswith(("_ZN7cpython", "_ZN08NumbaEnv"))
        elif own and line.startswith("\t") and not line.startswith(("\t.", "\t#")):
            instructions += 1
            vector += bool(VECTOR.search(line))
    return MachineCode(instructions, vector)


def program_code(fe_plan: FePlan, controlled: bool = True) -> MachineCode:
    """Of the program's loop for this model."""
    fe_plan = fe_plan if controlled else without_control(fe_plan)
    state, force, scratch = workspace(fe_plan, start_state(fe_plan))
    loop = fe_plan.model.loop
    return count(_assembly(advance, state, 0, loop, loop.viscosity, loop.hourglass, force, scratch))


def bare_code(fe_plan: FePlan) -> MachineCode:
    """Of the bare loop for this model."""
    state, force, _ = workspace(fe_plan, start_state(fe_plan))
    model, scratch = bare_parameters(fe_plan.model.loop), bare_scratch(fe_plan.model.loop)
    return count(_assembly(advance_bare, state.positions, state.velocities, 0, model, force, scratch))


def _assembly(loop: Kernel, *arguments: Any) -> str:
    """Compiled afresh, for Numba shows no assembly of what it loaded from disk, and not called."""
    fresh = make_dispatcher(loop)
    compile_for(fresh, arguments)
    (assembly,) = fresh.inspect_asm().values()
    return str(assembly)


@dataclass(frozen=True)
class Process:
    """A command: seconds of the whole process, modules at its end, seconds in imports, and the costliest packages."""

    name: str
    seconds: Spread
    modules: int
    import_s: float
    packages: tuple[tuple[str, float], ...]


def find_processes(scene: str, changes: tuple[str, ...]) -> tuple[Process, ...]:
    """All COMMANDS on this scene; results go to a folder that is removed."""
    with tempfile.TemporaryDirectory(prefix="tailslap-features-") as folder:
        arguments = {name: _arguments(command, scene, changes, folder) for name, command in COMMANDS.items()}
        runs = [partial(_timed, command) for command in arguments.values()]
        table = take_turns(runs, TURNS)
        found = []
        for i, (name, command) in enumerate(arguments.items()):
            modules, imports = _imports(command)
            largest = sorted(imports.items(), key=lambda item: -item[1])[:5]
            total = sum(imports.values())
            found.append(Process(name, spread(table[:, i]), modules, total, tuple(largest)))
    return tuple(found)


def parse_imports(report: str) -> dict[str, float]:
    """Seconds that importing took, by top-level package, from what `python -X importtime` says."""
    packages: dict[str, float] = {}
    for line in report.splitlines():
        head, _, rest = line.partition("import time:")
        own, _, named = rest.partition("|")
        if head or not own.strip().isdigit():
            continue
        package = named.partition("|")[2].strip().split(".")[0]
        packages[package] = packages.get(package, 0.0) + 1e-6 * int(own)
    return packages


def _arguments(command: tuple[str, ...], scene: str, changes: tuple[str, ...], folder: str) -> list[str]:
    verb, *options = command
    out = ["--out", str(Path(folder) / "out")] if verb == "run" else []
    return [verb, scene, *(part for change in changes for part in ("--set", change)), *options, *out]


def _timed(arguments: list[str]) -> float:
    return seconds(lambda: _process([sys.executable, "-m", "tailslap.command_line", *arguments]))


def _imports(arguments: list[str]) -> tuple[int, dict[str, float]]:
    done = _process([sys.executable, "-X", "importtime", "-c", CODE, *arguments])
    return int(done.stdout.splitlines()[-1]), parse_imports(done.stderr)


def _process(command: list[str]) -> subprocess.CompletedProcess[str]:
    """A run whose check fails ends with 1, and is timed like any other."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise OSError(f"{' '.join(command[-4:])} ended with {done.returncode}: {done.stderr[-300:]}")
    return done


def print_instructions(scene: str, changes: tuple[str, ...]) -> None:
    """A line a part, and the bare loop."""
    plan = with_elements(make_plan(*read_scene(scene, changes)))
    parts = [part for part in parts_of(plan.scene) if not refusal(part)]
    models = {part.name: fe_plan_of(part) for part in parts}
    print(f"{'instructions':<24}{'all':>8}{'on vectors':>12}")
    for part in parts:
        if part.scene.time.threads == 1:
            _print_code(part.name, program_code(models[part.name], part.controlled))
    _print_code("bare loop", bare_code(models[PLAIN]))


def _print_code(name: str, code: MachineCode) -> None:
    print(f"{name:<24}{code.instructions:>8}{code.vector:>12}", flush=True)


def print_commands(scene: str, changes: tuple[str, ...]) -> None:
    """A line a command; imports are timed in a run of their own, which Python's report slows down."""
    for found in find_processes(scene, changes):
        costliest = ", ".join(f"{name} {value:.2f} s" for name, value in found.packages)
        print(
            f"tailslap {found.name:<18}{found.seconds.best:6.2f} s best, {found.seconds.median:.2f} s median, "
            f"{found.modules} modules, imports {found.import_s:.2f} s: {costliest}",
            flush=True,
        )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", nargs="?", default="paper-table-3", metavar="SCENE")
    parser.add_argument("--set", dest="changes", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--no-commands", action="store_true", help="count instructions alone")
    given = parser.parse_args()
    print_instructions(given.scene, tuple(given.changes))
    if not given.no_commands:
        print_commands(given.scene, tuple(given.changes))


if __name__ == "__main__":
    main()
