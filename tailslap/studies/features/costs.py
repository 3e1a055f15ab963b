"""The study itself: all loops in turns, set-up, whole commands, machine code, and the proof."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial

import numpy as np

from tailslap.planning.fe_plan import FePlan, make_fe_plan
from tailslap.planning.plan import Plan, make_plan
from tailslap.progress import announced, progress_bar
from tailslap.studies.features.loops import Loop, bare_loop, difference, program_loop, rows_of_history
from tailslap.studies.features.machine_code import MachineCode, bare_code, program_code
from tailslap.studies.features.parts import AGAIN, BARE, PLAIN, Part, fe_plan_of, parts_of, refusal, with_wall
from tailslap.studies.features.processes import Process, find_processes
from tailslap.studies.features.proof import Proof, prove
from tailslap.studies.features.timing import (
    Floats,
    Ratio,
    Spread,
    ratio,
    seconds,
    spread,
    take_turns,
)

SETUP_TURNS = 5
ROWS, FEWEST_ROWS, ROWS_A_TURN = 400, 10, 20
"""Rows of a history: the program's default, the fewest that a scene may ask for; those timed in a turn."""

COMPARED_STEPS = 1000
"""Steps after which the positions of the two loops are compared, or fewer where the run has fewer."""


@dataclass(frozen=True)
class Cost:
    """What a part costs: time of an element update [ns], its ratio to that without the part, and what comes with it.

    steps: of the whole run, for a part may change the time step; loop_s: of its time loop, the median. setup:
    seconds; compile_s: seconds to compile or load the loop; code: of its machine code, None on several threads.
    """

    part: Part
    update: Spread
    ratio: Ratio | None
    steps: int
    loop_s: float
    setup: Spread
    compile_s: float
    code: MachineCode | None


@dataclass(frozen=True)
class History:
    """What a row of the history costs [s], and the rows from FEWEST_ROWS to ROWS over the plain time loop."""

    row: Spread
    loop_share: Ratio


@dataclass(frozen=True)
class Costs:
    """All that the study found. bare, again: element updates [ns]; wall: set-up [s] without and with its mesh."""

    plan: Plan
    elements: int
    turns: int
    costs: tuple[Cost, ...]
    refused: tuple[tuple[str, str], ...]
    bare: Spread
    again: Spread
    bare_code: MachineCode
    history: History
    wall: tuple[Spread, Spread]
    proof: Proof
    processes: tuple[Process, ...]
    table: dict[str, Floats]
    seconds: float


def find_costs(plan: Plan, turns: int, processes: tuple[str, tuple[str, ...]] | None = None) -> Costs:
    """Time all parts of the scene; processes: name and changes of the scene, for whole commands, or None."""
    began = time.perf_counter()
    with announced(
        "Building the models, or compiling their loops: once on this machine, a minute or two ..."
    ):
        refused = tuple((part.name, why) for part in parts_of(plan.scene) if (why := refusal(part)))
        parts = [part for part in parts_of(plan.scene) if part.name not in dict(refused)]
        models = {part.name: fe_plan_of(part) for part in parts}
        loops = _loops(parts, models)
        codes = {part.name: _code(part, models[part.name]) for part in parts}
        code = bare_code(models[PLAIN])
    table, rows = _time_loops(loops, models[PLAIN], turns, f"{plan.scene.name}: {turns} turns")
    setups = _time_setups(plan, parts)
    costs = tuple(_cost(part, models, table, setups, loops, codes) for part in parts)
    steps = min(COMPARED_STEPS, costs[0].steps)
    proof = prove(table[PLAIN], table[AGAIN], table[BARE], difference(models[PLAIN], steps), steps)
    elements = loops[PLAIN].elements
    run_s = 1e-9 * table[PLAIN] * elements * costs[0].steps
    history = History(spread(rows), ratio((ROWS - FEWEST_ROWS) * rows, run_s))
    return Costs(
        plan=plan,
        elements=elements,
        turns=turns,
        costs=costs,
        refused=refused,
        bare=spread(table[BARE]),
        again=spread(table[AGAIN]),
        bare_code=code,
        history=history,
        wall=(spread(setups[""]), spread(setups["wall"])),
        proof=proof,
        processes=_processes(plan, processes),
        table=table | {"row of the history": 1e9 * rows},
        seconds=time.perf_counter() - began,
    )


def _loops(parts: list[Part], models: dict[str, FePlan]) -> dict[str, Loop]:
    """The plain loop twice and the bare one first, next to each other: these make the proof."""
    plain = parts[0]
    loops = [
        program_loop(PLAIN, models[PLAIN], plain),
        bare_loop(BARE, models[PLAIN]),
        program_loop(AGAIN, models[PLAIN], plain),
        *(program_loop(part.name, models[part.name], part) for part in parts[1:]),
    ]
    return {loop.name: loop for loop in loops}


def _time_loops(
    loops: dict[str, Loop], plain: FePlan, turns: int, label: str
) -> tuple[dict[str, Floats], Floats]:
    """Nanoseconds an element update, by loop, and seconds a row of the history, each of shape (turns,)."""
    chunks = {name: loop.chunk() for name, loop in loops.items()}
    chunks[AGAIN] = chunks[BARE] = chunks[PLAIN]
    runs = [partial(loop.run, chunks[name]) for name, loop in loops.items()]
    with progress_bar(label) as progress:
        times = take_turns([*runs, rows_of_history(plain, ROWS_A_TURN)], turns, progress)
    updates = {
        name: 1e9 * times[:, i] / (chunks[name] * loop.elements)
        for i, (name, loop) in enumerate(loops.items())
    }
    return updates, times[:, -1] / ROWS_A_TURN


def _time_setups(plan: Plan, parts: list[Part]) -> dict[str, Floats]:
    """Seconds of mesh and model by part, and under "wall" and "" with the wall's mesh and without."""
    plans = {part.name: make_plan(part.scene) for part in parts}
    plans |= {"": plans[PLAIN], "wall": make_plan(with_wall(plan.scene, plan))}
    runs = [partial(seconds, partial(make_fe_plan, plan)) for plan in plans.values()]
    with progress_bar(f"{plan.scene.name}: set-up") as progress:
        times = take_turns(runs, SETUP_TURNS, progress)
    return {name: times[:, i] for i, name in enumerate(plans)}


def _cost(
    part: Part,
    models: dict[str, FePlan],
    table: dict[str, Floats],
    setups: dict[str, Floats],
    loops: dict[str, Loop],
    codes: dict[str, MachineCode | None],
) -> Cost:
    updates, steps = table[part.name], models[part.name].expected_steps
    return Cost(
        part,
        spread(updates),
        ratio(updates, table[part.without]) if part.without else None,
        steps,
        1e-9 * float(np.median(updates)) * loops[part.name].elements * steps,
        spread(setups[part.name]),
        loops[part.name].compile_s,
        codes[part.name],
    )


def _code(part: Part, fe_plan: FePlan) -> MachineCode | None:
    return None if part.scene.time.threads > 1 else program_code(fe_plan, part.controlled)


def _processes(plan: Plan, scene: tuple[str, tuple[str, ...]] | None) -> tuple[Process, ...]:
    if scene is None:
        return ()
    with progress_bar(f"{plan.scene.name}: whole commands") as progress:
        return find_processes(*scene, progress)
