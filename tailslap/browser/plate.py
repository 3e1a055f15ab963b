"""Plates of a page, from start to tail-slap."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.explicit.columns import Measures
from fem.explicit.measures import advance_and_measure, copy_state, lagrange_weight, measure
from machine_code import web_assembly
from machine_code.compiled import compiled
from machine_code.object_code import Prepared
from postprocess.comparison.quantities import QUANTITIES
from postprocess.units import SYSTEMS
from tailslap.errors import InputError, Missing, Verbatim

if TYPE_CHECKING:
    from tailslap.case.corner.corner_case import CornerCase
    from tailslap.case.corner.corner_plan import CornerPlan

SCENES = "paper-table-3", "paper-abaqus", "mash-tl4-sut"
"""Plates of every page."""

MOST_ELEMENTS = 5000
"""Elements of the largest plate of a page."""

INSTANTS = 25
"""Instants of the exact motion in a chart."""

READ = "plate.rows", "plate.strike"
"""Arrays that the script of a page reads."""


@compiled
def run_to_tail_slap(start, state, before, stride, parameters, workspace, rows, near, strike):
    """Advance the plate from its start until its angle is zero.

    state, before, workspace: as of `advance_and_measure`. rows, shape (n, columns): of the history, `stride` steps
    apart, the start first; near, shape (stride + 2, columns): of single steps about the tail-slap. strike, shape
    (columns,): interpolated at angle zero, as `fem.run.corner` does. Returns the number of rows, and the time of the
    tail-slap [s], NaN without one.
    """
    reference, force, scratch, last = workspace
    copy_state(start, state)
    first = measure(state, parameters, reference, force, scratch, last)
    for column in range(strike.size):
        rows[0, column] = first[column]
    count = 1 + advance_and_measure(
        state, before, stride, parameters, reference, force, scratch, last, rows[1:]
    )
    if not rows[count - 1, 0] <= 0.0:
        return count, np.nan
    copy_state(before, state)
    for column in range(strike.size):
        near[0, column] = rows[count - 2, column]
    crossing = advance_and_measure(state, before, 1, parameters, reference, force, scratch, last, near[1:])
    advance_and_measure(state, before, 1, parameters, reference, force, scratch, last, near[crossing + 1 :])
    begin, end, steps = max(0, crossing - 2), crossing + 2, 0.0
    strike[:] = 0.0
    for k in range(begin, end):
        weight = lagrange_weight(near[:, 0], begin, end, k, 0.0)
        steps += weight * float(k)
        for column in range(strike.size):
            strike[column] += weight * near[k, column]
    return count, parameters.time_step * (float(stride * (count - 2)) + steps)


def calls_of(fe_plan: CornerPlan) -> web_assembly.Calls:
    """Return the kernel of a plan with its arguments.

    Raises InputError for a start that the plate cannot have.
    """
    from fem.run import corner
    from fem.start.inertia_relief import TooSoftError

    kind, model, scene = fe_plan.plate.start, fe_plan.model, fe_plan.case.scene
    try:
        start = corner.Stepper(model).start(fe_plan.start, kind)
    except TooSoftError as error:
        raise InputError("plate.start", kind, f'{error}; allowed is "unstressed"') from None
    stepper = corner.Stepper(model)  # with an empty workspace
    fixed, *workspace = (part.value for part in stepper.step_call[1] if isinstance(part, Prepared))
    stride = corner.stride_of(fe_plan.case.duration, model, scene.time.rows)
    states = [type(start)(*map(np.zeros_like, start)) for _ in range(2)]
    most, columns = 2 + math.ceil(corner.OVERTIME * scene.time.rows), len(Measures._fields)
    rows = np.zeros((most, columns)), np.zeros((stride + 2, columns)), np.zeros(columns)
    arguments = start, *states, stride, fixed, tuple(workspace), *rows
    return {"plate": (run_to_tail_slap, arguments)}


def demand_plate(case: Any) -> None:
    """Require a constrained corner whose plate a page computes.

    Raises InputError.
    """
    name, plate = case.scene.name, case.scene.plate
    if plate is None:
        why = "the page computes whole impacts, with [contact], and plates, with [plate]"
        raise InputError("plate", Missing, f"{why}; `tailslap rigid {name}` computes this scene")
    if plate.elements and math.prod(plate.elements) > MOST_ELEMENTS:
        why = f"the page computes plates of at most {MOST_ELEMENTS} elements"
        given = Verbatim(" x ".join(map(str, plate.elements)))
        raise InputError("plate.elements", given, f"{why}; `tailslap run {name}` computes this scene")


def plate_of(case: CornerCase, number: Any) -> dict[str, Any]:
    """Return the plate of a scene for a page.

    number: function of a content of memory that returns its number. Raises InputError.
    """
    from tailslap.case.run_report import plate_sentence

    demand_plate(case)
    fe_plan = case.plan()
    calls = calls_of(fe_plan)
    memory = web_assembly.layout(calls)
    filled = [(place.at, place.content) for place in memory.arrays.values() if place.content]
    stride = calls["plate"][1][3]
    motion = fe_plan.case.motion.at(np.linspace(0.0, fe_plan.case.duration, INSTANTS))
    quantities = [
        [quantity.title, quantity.symbol, fe_plan.case.tail_slap[key], key]
        + [units.of(quantity.unit) for units in SYSTEMS.values()]
        for key, quantity in QUANTITIES.items()
    ]
    return {
        "name": case.scene.name,
        "text": [units.rendered(f"{case.set_up} {plate_sentence(fe_plan)}") for units in SYSTEMS.values()],
        "digest": web_assembly.digest_of(calls),
        "module": number(web_assembly.module(calls)),
        "calls": memory.calls,
        "arrays": {key: [p.at, p.kind, p.shape] for key, p in memory.arrays.items() if key in READ},
        "contents": [(at, number(content)) for at, content in [*filled, *memory.slots]],
        "size": memory.size,
        "columns": Measures._fields,
        "interval": stride * fe_plan.model.parameters.time_step,
        "step": fe_plan.model.parameters.time_step,
        "quantities": quantities,
        "exact": [[float(f"{value:.6g}") for value in values] for values in (motion.t, motion.v_gy)],
    }
