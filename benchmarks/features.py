"""Cost of the parts of a scene in the compiled loop.

    .venv/bin/python benchmarks/features.py [SCENE] [--set KEY=VALUE ...] [--turns N] [--no-commands]

Parts are added one at a time to a plain scene: internal forces, a penalty spring, drift. Beside it stands a bare loop,
which has no code for any of them. Instructions are counted in LLVM's assembly, and all loops are timed in turns.
Commands run in fresh processes: seconds, modules loaded, and the time of imports by Python's own report.
Exit status 1 where the plain loop costs measurably more than the bare one.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import command_line
import numpy as np
from command_line import TAILSLAP, seconds

from fem.explicit.internal_force import Scratch, scratch_for
from fem.explicit.simd_blocks import (
    BLOCK_SIZE,
    NODE,
    Y,
    at_slot,
    balance,
    block_rows,
    clear_idle,
    gather,
    point_of,
    scatter,
    slot_count,
    subtract_first,
)
from fem.explicit.time_loop import LoopParameters, State, advance, drift
from fem.laws.constraints import Penalty
from fem.laws.materials import stress
from fem.plate.discretisation import ElementTable
from fem.run.corner import Stepper
from fem.run.runner import copy_state
from machine_code.compiled import compiled, inlined
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.errors import InputError
from tailslap.scene.read import read_scene
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Source, varied
from tailslap.studies import with_elements

Floats = np.ndarray

PLAIN, AGAIN, BARE = "plain", "plain again", "bare loop"
"""The loop without parts, the same a second time, and the loop that has no code for them."""
CHUNK_S, TRIAL, MAX_STEPS = 0.012, 100, 1_000_000
"""Seconds of a loop in a turn, about, long against a call of compiled code; steps of a trial; most steps."""
MEASURABLE, SAME = 1.05, 1e-9
"""Ratio to the bare loop that counts as a cost; difference of positions by rounding, over the plate's length."""
FREE, COSTS, UNSETTLED = "free", "costs", "unsettled"
SEED, RESAMPLES = 20251, 2000
VECTOR = re.compile(r"%[xyz]mm\d|\bv\d+\.\d")
COMMAND_TURNS = 2
"""Timed runs of each command; a further run, slower, reports its imports."""
COMMANDS = {name: tuple(name.split()) for name in ("rigid", "check", "run --no-pictures", "run")}
CODE = (
    "import sys\nfrom tailslap.cli import _status\n"
    "status = _status(sys.argv[1:])\nprint()\nprint(len(sys.modules))\nsys.exit(status)\n"
)


def plain_scene(scene: Scene) -> Scene:
    """The scene with a plate and a penalty spring alone."""
    changes = {
        "corner": {"reaction": "none", "penalty_scale": scene.corner.penalty_scale},
        "time.threads": 1,
        **dict.fromkeys(("material", "damping", "wall")),
        **({"plate.element": "quad4"} if scene.needed_plate.element == "quad4-reduced" else {}),
    }
    return varied(scene, changes)


def models_of(scene: Scene) -> dict[str, CornerPlan]:
    """Models of the plain scene, alone and with each part."""
    plain = plain_scene(scene)
    changes: dict[str, dict[str, Any]] = {
        PLAIN: {},
        "friction": {"corner.reaction": "drag", "corner.friction": 0.47},
        "damping": {"damping.ratio": 0.02},
        "dashpot": {"corner.damping_ratio": 0.2},
        "exact constraint": {"corner.constraint": "exact", "corner.penalty_scale": None},
        "patch": {"corner.patch_length": 0.1 * scene.vehicle.length},
        "neo-Hookean": {"material.law": "neo-hookean"},
        "hourglass control": {"plate.element": "quad4-reduced"},
    }
    models = {}
    for name, part in changes.items():
        try:
            changed = varied(plain, part)
            models[name] = CornerCase(changed, Source.of(changed)).plan()
        except InputError as error:
            print(f"omitted: {name}. {error}", file=sys.stderr)
    return models


class BareParameters(NamedTuple):
    """Elements, material, masses [kg], node and stiffness [N/m], and step [s]."""

    table: ElementTable
    material: Any
    mass: np.ndarray
    node: int
    stiffness: float
    time_step: float


def bare_parameters(loop: LoopParameters) -> BareParameters:
    """Parameters of a bare loop.

    Raises ValueError if a part is present.
    """
    parts = (loop.friction, loop.viscosity, loop.hourglass, loop.elastic_damping)
    if any(part is not None for part in parts) or loop.corner.nodes.size > 1:
        raise ValueError("the bare loop has no code for a part of this model")
    if not isinstance(loop.corner.constraint, Penalty) or loop.corner.dashpot:
        raise ValueError("the bare loop has a penalty spring and no other constraint")
    node, stiffness = int(loop.corner.nodes[0]), float(loop.corner.stiffness)
    return BareParameters(_stored(loop.table), loop.material, loop.mass, node, stiffness, loop.time_step)


def bare_scratch(loop: LoopParameters) -> Scratch:
    """Return the workspace of the bare loop."""
    return scratch_for(_stored(loop.table))


def _stored(table: ElementTable) -> ElementTable:
    """Return the table with stored gradients, since mapping is a part."""
    return table._replace(mapping=None)


@compiled
def advance_bare(positions: Any, velocities: Any, steps: Any, model: Any, force: Any, scratch: Any) -> Any:
    """Advance positions and velocities in place, shape (2, nodes)."""
    for _ in range(steps):
        force[:] = 0.0
        _subtract_forces(positions, force, model.table, model.material, scratch)
        force[1, model.node] -= model.stiffness * positions[1, model.node]
        drift(positions, velocities, force, model.mass, model.time_step, 0.0, 0, model.mass.size)


@compiled
def _subtract_forces(positions: Any, force: Any, table: Any, material: Any, scratch: Any) -> Any:
    following, nodes, rows = table.per_element[1:], len(table.per_element), scratch.rows
    connectivity, lattice, at = table.connectivity, scratch.lattice, block_rows(nodes)
    slots = slot_count(connectivity, lattice)
    for first in range(0, slots, BLOCK_SIZE):
        count = min(BLOCK_SIZE, slots - first)
        gather(positions, connectivity, lattice, first, count, rows)
        forces = rows[at.forces : at.velocities]
        if scratch.quadrilateral is not None:
            linear, twists = scratch.quadrilateral
            _set_parallelograms(material, rows, linear, twists, scratch.weights)
        else:
            subtract_first(following, rows)
            forces[:] = 0.0
            for point in range(table.weights.shape[0]):
                gradients = point_of(scratch.gradients, first // BLOCK_SIZE, point, 2 * len(following))
                weights = point_of(scratch.weights, first // BLOCK_SIZE, point, 1)
                _add_point(following, material, rows, gradients, weights)
            balance(following, forces)
        clear_idle(lattice, first // BLOCK_SIZE, 2 * nodes, forces)
        scatter(force, connectivity, lattice, first, count, forces)


@compiled
def _set_parallelograms(material: Any, rows: Any, linear: Any, twists: Any, weights: Any) -> Any:
    forces = block_rows(4).forces
    for slot in range(BLOCK_SIZE):
        x, y = rows[slot], rows[Y + slot]
        x_1, y_1 = rows[NODE + slot] - x, rows[NODE + Y + slot] - y
        x_2, y_2 = rows[3 * NODE + slot] - x, rows[3 * NODE + Y + slot] - y
        x_3, y_3 = rows[2 * NODE + slot] - x - x_1 - x_2, rows[2 * NODE + Y + slot] - y - y_1 - y_2
        m_11, m_12 = x_1 * linear[0] + x_2 * linear[2], x_1 * linear[1] + x_2 * linear[3]
        m_21, m_22 = y_1 * linear[0] + y_2 * linear[2], y_1 * linear[1] + y_2 * linear[3]
        q_11 = q_12 = q_21 = q_22 = t_1 = t_2 = 0.0
        for point in range(len(twists)):
            g_1, g_2 = twists[point]
            f_11, f_12, f_21, f_22 = m_11 + x_3 * g_1, m_12 + x_3 * g_2, m_21 + y_3 * g_1, m_22 + y_3 * g_2
            p_11, p_12, p_21, p_22 = _stress(material, f_11, f_12, f_21, f_22, weights[point])
            q_11, q_12, q_21, q_22 = q_11 + p_11, q_12 + p_12, q_21 + p_21, q_22 + p_22
            t_1, t_2 = t_1 + p_11 * g_1 + p_12 * g_2, t_2 + p_21 * g_1 + p_22 * g_2
        r_11, r_12 = q_11 * linear[0] + q_12 * linear[1], q_11 * linear[2] + q_12 * linear[3]
        r_21, r_22 = q_21 * linear[0] + q_22 * linear[1], q_21 * linear[2] + q_22 * linear[3]
        rows[forces + slot], rows[forces + Y + slot] = t_1 - r_11 - r_12, t_2 - r_21 - r_22
        rows[forces + NODE + slot], rows[forces + NODE + Y + slot] = r_11 - t_1, r_21 - t_2
        rows[forces + 2 * NODE + slot], rows[forces + 2 * NODE + Y + slot] = t_1, t_2
        rows[forces + 3 * NODE + slot], rows[forces + 3 * NODE + Y + slot] = r_12 - t_1, r_22 - t_2


@compiled
def _add_point(following: Any, material: Any, rows: Any, gradients: Any, weights: Any) -> Any:
    forces = block_rows(len(following) + 1).forces
    for slot in range(BLOCK_SIZE):
        f = _gradient(following, rows, gradients, slot)
        weight = at_slot(weights, 0, slot)
        p_11, p_12, p_21, p_22 = _stress(material, f[0], f[1], f[2], f[3], weight)
        for a in range(len(following)):
            g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
            rows[forces + (a + 1) * NODE + slot] += p_11 * g_1 + p_12 * g_2
            rows[forces + (a + 1) * NODE + Y + slot] += p_21 * g_1 + p_22 * g_2


@inlined
def _stress(material: Any, f_11: Any, f_12: Any, f_21: Any, f_22: Any, weight: Any) -> Any:
    e_11 = 0.5 * (f_11 * f_11 + f_21 * f_21 - 1.0)
    e_22 = 0.5 * (f_12 * f_12 + f_22 * f_22 - 1.0)
    s_11, s_22, s_12 = stress(material, e_11, e_22, f_11 * f_12 + f_21 * f_22)
    s_11, s_22, s_12 = weight * s_11, weight * s_22, weight * s_12
    return (
        f_11 * s_11 + f_12 * s_12,
        f_11 * s_12 + f_12 * s_22,
        f_21 * s_11 + f_22 * s_12,
        f_21 * s_12 + f_22 * s_22,
    )


@inlined
def _gradient(following: Any, rows: Any, gradients: Any, slot: Any) -> Any:
    f_11 = f_12 = f_21 = f_22 = 0.0
    for a in range(len(following)):
        g_1, g_2 = at_slot(gradients, 2 * a, slot), at_slot(gradients, 2 * a + 1, slot)
        x, y = rows[(a + 1) * NODE + slot], rows[(a + 1) * NODE + Y + slot]
        f_11, f_12, f_21, f_22 = f_11 + x * g_1, f_12 + x * g_2, f_21 + y * g_1, f_22 + y * g_2
    return f_11, f_12, f_21, f_22


def workspace(fe_plan: CornerPlan) -> tuple[State, Floats, Any]:
    """State at t = 0, forces and scratch in new memory."""
    state = copy_state(Stepper(fe_plan.model).start(fe_plan.start, fe_plan.plate.start))
    loop = fe_plan.model.parameters
    return state, np.zeros_like(state.positions), scratch_for(loop.table, loop.hourglass)


def run_program(fe_plan: CornerPlan, steps: int) -> tuple[float, Floats]:
    """Return the seconds of the program's loop and the final positions."""
    (state, force, scratch), loop = workspace(fe_plan), fe_plan.model.parameters
    arguments = (state, steps, loop, force, scratch)
    spent = seconds(lambda: advance(*arguments))
    return spent, state.positions + np.array([[state.origin[0]], [0.0]])


def run_bare(fe_plan: CornerPlan, steps: int) -> tuple[float, Floats]:
    """The bare loop on the same model."""
    (state, force, _), loop = workspace(fe_plan), fe_plan.model.parameters
    arguments = (steps, bare_parameters(loop), force, bare_scratch(loop))
    return seconds(lambda: advance_bare(state.positions, state.velocities, *arguments)), state.positions


def take_turns(runs: Sequence[Callable[[], float]], turns: int) -> Floats:
    """Results of runs in alternating order, shape (turns, runs)."""
    table = np.empty((turns, len(runs)))
    for turn in range(turns):
        for i in range(len(runs))[:: 1 if turn % 2 == 0 else -1]:
            table[turn, i] = runs[i]()
    return table


def ratio(times: Floats, reference: Floats) -> tuple[float, float, float]:
    """Median of times over reference with its 95 % bootstrap interval.

    Turn by turn, because a slow spell of the machine then cancels; the median, because one hiccup must not count.
    """
    values = times / reference
    drawn = np.random.default_rng(SEED).integers(0, len(values), (RESAMPLES, len(values)))
    low, high = np.percentile(np.median(values[drawn], axis=1), (2.5, 97.5))
    return float(np.median(values)), float(low), float(high)


def verdict(plain: Floats, again: Floats, bare: Floats) -> str:
    """Return COSTS where the interval is above 1, FREE below."""
    _, low, high = ratio(plain, bare)
    if not low <= max(MEASURABLE, ratio(again, plain)[2]):
        return COSTS
    return FREE if high <= MEASURABLE else UNSETTLED


def time_loops(models: dict[str, CornerPlan], turns: int) -> dict[str, Floats]:
    """Nanoseconds of an element update by loop, shape (turns,)."""
    plain = models[PLAIN]
    loops = {PLAIN: (run_program, plain), BARE: (run_bare, plain), AGAIN: (run_program, plain)}
    loops |= {name: (run_program, model) for name, model in models.items() if name != PLAIN}
    runs, updates = [], []
    for run, model in loops.values():
        run(model, 0)  # compiles
        best = min(run(model, TRIAL)[0] for _ in range(3))
        steps = int(np.clip(CHUNK_S * TRIAL / best, 1, MAX_STEPS))
        runs.append(lambda run=run, model=model, steps=steps: run(model, steps)[0])
        updates.append(steps * model.model.parameters.table.connectivity.shape[1])
    times = 1e9 * take_turns(runs, turns) / np.array(updates)
    return dict(zip(loops, times.T, strict=True))


class MachineCode(NamedTuple):
    """Instructions of the loop and its functions, and those on vector registers."""

    instructions: int
    vector: int


def count(assembly: str) -> MachineCode:
    """Count instructions in LLVM's assembly."""
    lines = [line for line in assembly.splitlines() if line.startswith("\t") and line[1:2] not in ".#"]
    return MachineCode(len(lines), sum(bool(VECTOR.search(line)) for line in lines))


def program_code(fe_plan: CornerPlan) -> MachineCode:
    """Of the program's loop for this model."""
    (state, force, scratch), loop = workspace(fe_plan), fe_plan.model.parameters
    return count(advance.assembly(state, 0, loop, force, scratch))


def bare_code(fe_plan: CornerPlan) -> MachineCode:
    """Of the bare loop for this model."""
    (state, force, _), loop = workspace(fe_plan), fe_plan.model.parameters
    arguments = (0, bare_parameters(loop), force, bare_scratch(loop))
    return count(advance_bare.assembly(state.positions, state.velocities, *arguments))


class Process(NamedTuple):
    """Times [s], modules and imports of a command, and the costliest packages."""

    name: str
    best: float
    median: float
    modules: int
    import_s: float
    packages: tuple[tuple[str, float], ...]


def find_processes(scene: str, changes: tuple[str, ...]) -> tuple[Process, ...]:
    """Measure all COMMANDS on a scene in a temporary folder."""
    processes = []
    with tempfile.TemporaryDirectory(prefix="tailslap-features-") as folder:
        words = [_arguments(command, scene, changes, folder) for command in COMMANDS.values()]
        timed = [partial(seconds, partial(_process, [*TAILSLAP, *arguments])) for arguments in words]
        for name, arguments, times in zip(COMMANDS, words, take_turns(timed, COMMAND_TURNS).T, strict=True):
            process = _process([sys.executable, "-X", "importtime", "-c", CODE, *arguments])
            imports = parse_imports(process.stderr)
            largest = sorted(imports.items(), key=lambda item: -item[1])[:5]
            shortest, median = float(times.min()), float(np.median(times))
            modules, total = int(process.stdout.splitlines()[-1]), sum(imports.values())
            processes.append(Process(name, shortest, median, modules, total, tuple(largest)))
    return tuple(processes)


def parse_imports(report: str) -> dict[str, float]:
    """Return the seconds of imports by package.

    report: that of `python -X importtime`.
    """
    packages: dict[str, float] = {}
    for line in report.splitlines():
        head, _, rest = line.partition("import time:")
        microseconds, _, named = rest.partition("|")
        if head or not microseconds.strip().isdigit():
            continue
        package = named.partition("|")[2].strip().split(".")[0]
        packages[package] = packages.get(package, 0.0) + 1e-6 * int(microseconds)
    return packages


def _arguments(command: tuple[str, ...], scene: str, changes: tuple[str, ...], folder: str) -> list[str]:
    verb, *options = command
    out = ["--out", str(Path(folder) / "out")] if verb == "run" else []
    return [verb, scene, *(part for change in changes for part in ("--set", change)), *options, *out]


def _process(command: list[str]) -> subprocess.CompletedProcess[str]:
    """Run a command, which may end with 0 or 1."""
    process = subprocess.run(command, capture_output=True, text=True)
    if process.returncode not in (0, 1):
        raise OSError(f"{' '.join(command[-4:])} ended with {process.returncode}: {process.stderr[-300:]}")
    return process


def print_parts(scene: str, changes: tuple[str, ...], turns: int) -> bool:
    """Print a line a part, and return True if loops agree."""
    models = models_of(with_elements(CornerCase(*read_scene(scene, changes))).scene)
    codes = {name: program_code(model) for name, model in models.items()} | {BARE: bare_code(models[PLAIN])}
    updates = time_loops(models, turns)
    print(f"{'loop':<20}{'instructions':>13}{'on vectors':>12}{'update [ns]':>13}  times the plain loop")
    for name, code in codes.items():
        middle, low, high = ratio(updates[name], updates[PLAIN])
        costs = f"{np.median(updates[name]):13.2f}  {middle:.3f} ({low:.3f} to {high:.3f})"
        print(f"{name:<20}{code.instructions:>13}{code.vector:>12}{costs}", flush=True)
    cost = verdict(updates[PLAIN], updates[AGAIN], updates[BARE])
    middle, low, high = ratio(updates[PLAIN], updates[BARE])
    apart = difference(models[PLAIN], 1000)
    print(f"a part left out: {cost}; {middle:.3f} ({low:.3f} to {high:.3f}) times the bare loop")
    print(f"after 1000 steps their positions differ by {apart:.1e} of the plate's length", flush=True)
    return cost != COSTS and apart <= SAME


def difference(fe_plan: CornerPlan, steps: int) -> float:
    """Return the largest distance of positions of both loops, relative."""
    ours, bare = (run(fe_plan, steps)[1] for run in (run_program, run_bare))
    return float(np.abs(ours - bare).max() / fe_plan.case.body.length)


def print_commands(scene: str, changes: tuple[str, ...]) -> None:
    """Print a line for each command."""
    for process in find_processes(scene, changes):
        costliest = ", ".join(f"{name} {value:.2f} s" for name, value in process.packages)
        times = f"{process.best:6.2f} s best, {process.median:.2f} s median, {process.modules} modules"
        print(
            f"tailslap {process.name:<18}{times}, imports {process.import_s:.2f} s: {costliest}", flush=True
        )


def main() -> int:
    """Measure and print, and return the exit status."""
    options = command_line.options(__doc__, ("scene", "paper-table-3"), set=[], no_commands=False, turns=40)
    is_free = print_parts(options.scene, tuple(options.set), options.turns)
    if not options.no_commands:
        print_commands(options.scene, tuple(options.set))
    return 0 if is_free else 1


if __name__ == "__main__":
    sys.exit(main())
