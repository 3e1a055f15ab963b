"""The study itself: all loops in turns, set-up, and the proof."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from tailslap.planning.fe_plan import FePlan, make_fe_plan
from tailslap.planning.plan import Plan, make_plan
from tailslap.progress import announced, progress_bar
from tailslap.studies import with_elements
from tailslap.studies.features.loops import Loop, bare_loop, difference, program_loop, rows_of_history
from tailslap.studies.features.parts import AGAIN, BARE, PLAIN, Part, fe_plan_of, parts_of, refusal, with_wall
from tailslap.studies.features.proof import Proof, prove
from tailslap.studies.features.timing import Floats, Ratio, Spread, ratio, seconds, spread, take_turns
from tailslap.studies.study import Call

SETUP_TURNS = 5
ROWS, FEWEST_ROWS, ROWS_A_TURN = 400, 10, 20
"""Rows of a history: the program's default, the fewest that a scene may ask for; those timed in a turn."""

COMPARED_STEPS = 1000
"""Steps after which the positions of the two loops are compared, or fewer where the run has fewer."""


@dataclass(frozen=True)
class Cost:
    """What a part costs.

    Parameters
    ----------
    part, what, without : str
        Its name, the keys that make it, and the part that it is compared with, "" for none.
    update_ns : Spread
        Time of an element update [ns].
    ratio : Ratio or None
        Of the update to that without the part.
    steps : int
        Of the whole run, for a part may change the time step.
    time_loop_s : float
        Time loop of the whole run, the median [s].
    setup_s : Spread
        Mesh and model [s].
    compile_s : float
        Compiling or loading the loop [s].
    """

    part: str
    what: str
    without: str
    update_ns: Spread
    ratio: Ratio | None
    steps: int
    time_loop_s: float
    setup_s: Spread
    compile_s: float

    @property
    def entries(self) -> dict[str, Any]:
        """All numbers in one mapping, those of a spread by names like "setup_s_best"; without those there are not."""
        known = {key: value for key, value in asdict(self).items() if value is not None}
        parts = {key: value if isinstance(value, dict) else {"": value} for key, value in known.items()}
        return {
            f"{key}_{name}".rstrip("_"): value for key, its in parts.items() for name, value in its.items()
        }


@dataclass(frozen=True)
class History:
    """What a row of the history costs [s], and the rows from FEWEST_ROWS to ROWS over the plain time loop."""

    row_s: Spread
    over_loop: Ratio


@dataclass(frozen=True)
class WallSetup:
    """Set-up [s] of the plain scene without a wall and with the wall's mesh."""

    setup_without_s: Spread
    setup_with_s: Spread


@dataclass(frozen=True)
class Costs:
    """All that the study found. refused: parts that the scene cannot have, and why; bare, again: updates [ns].

    table: time of every loop in every turn, shape (turns,), updates and the row of the history [ns].
    """

    plan: Plan
    elements: int
    turns: int
    costs: tuple[Cost, ...]
    refused: dict[str, str]
    bare: Spread
    again: Spread
    history: History
    wall: WallSetup
    proof: Proof
    table: dict[str, Floats]
    seconds: float

    @property
    def ratios(self) -> dict[str, Ratio]:
        """By part, its loop over that without it."""
        return {cost.part: cost.ratio for cost in self.costs if cost.ratio}


def study_costs(call: Call, turns: int) -> Costs:
    """The study as the command line asks for it; all parts get the elements that the program chooses."""
    return find_costs(with_elements(call.plan), turns)


def find_costs(plan: Plan, turns: int) -> Costs:
    """Time all parts of the scene."""
    began = time.perf_counter()
    with announced(
        "Building the models, or compiling their loops: once on this machine, a minute or two ..."
    ):
        refused = {part.name: why for part in parts_of(plan.scene) if (why := refusal(part))}
        parts = [part for part in parts_of(plan.scene) if part.name not in refused]
        models = {part.name: fe_plan_of(part) for part in parts}
        loops = _loops(parts, models)
    table, rows = _time_loops(loops, models[PLAIN], turns, f"{plan.scene.name}: {turns} turns")
    setups = _time_setups(plan, parts)
    costs = tuple(_cost(part, models[part.name], table, setups, loops) for part in parts)
    steps = min(COMPARED_STEPS, costs[0].steps)
    elements = loops[PLAIN].elements
    run_s = 1e-9 * table[PLAIN] * elements * costs[0].steps
    return Costs(
        plan=plan,
        elements=elements,
        turns=turns,
        costs=costs,
        refused=refused,
        bare=spread(table[BARE]),
        again=spread(table[AGAIN]),
        history=History(spread(rows), ratio((ROWS - FEWEST_ROWS) * rows, run_s)),
        wall=WallSetup(spread(setups[""]), spread(setups["wall"])),
        proof=prove(table[PLAIN], table[AGAIN], table[BARE], difference(models[PLAIN], steps), steps),
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
    part: Part, fe_plan: FePlan, table: dict[str, Floats], setups: dict[str, Floats], loops: dict[str, Loop]
) -> Cost:
    updates, steps, loop = table[part.name], fe_plan.expected_steps, loops[part.name]
    return Cost(
        part=part.name,
        what=part.what,
        without=part.without,
        update_ns=spread(updates),
        ratio=ratio(updates, table[part.without]) if part.without else None,
        steps=steps,
        time_loop_s=1e-9 * float(np.median(updates)) * loop.elements * steps,
        setup_s=spread(setups[part.name]),
        compile_s=loop.compile_s,
    )
