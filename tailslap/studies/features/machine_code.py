"""How many instructions the compiled loops have: a part that is left out has none."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numba

from fem.compiled import FAST_MATH
from fem.explicit.time_loop import advance
from tailslap.planning.fe_plan import FePlan
from tailslap.studies.features.bare import advance_bare, bare_parameters
from tailslap.studies.features.loops import room, start_state, without_control

VECTOR = re.compile(r"%[xyz]mm\d|\bv\d+\.\d")


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
    state, force, scratch = room(fe_plan, start_state(fe_plan))
    loop = fe_plan.model.loop
    return count(_assembly(advance, state, 0, loop, loop.viscosity, loop.hourglass, force, scratch))


def bare_code(fe_plan: FePlan) -> MachineCode:
    """Of the bare loop for this model."""
    state, force, scratch = room(fe_plan, start_state(fe_plan))
    model = bare_parameters(fe_plan.model.loop)
    return count(_assembly(advance_bare, state.positions, state.velocities, 0, model, force, scratch))


def _assembly(loop: Callable[..., Any], *arguments: Any) -> str:
    """Compiled afresh, for Numba shows no assembly of what it loaded from disk; done nothing with."""
    fresh = numba.njit(nogil=True, fastmath=FAST_MATH, error_model="numpy")(loop.py_func)  # type: ignore[attr-defined]
    fresh(*arguments)
    (assembly,) = fresh.inspect_asm().values()
    return str(assembly)
