"""Threads of the time loop: no more than the mesh has work for."""

from __future__ import annotations

import math

from tailslap.case.corner.rigid import RigidStages
from tailslap.planning.decisions import Decision
from tailslap.scene.schema import Plate

ELEMENTS_A_THREAD = 10_000
"""Elements that a thread needs to be worth it: in a step the threads meet three times, and to wake one takes some 20 us
where a core is busy, in which another computes a thousand elements."""


def decide_threads(plan: RigidStages, plate: Plate) -> tuple[RigidStages, tuple[Decision, ...]]:
    """The plan with as many threads as its mesh has work for; as it is where that is what was asked for."""
    asked, elements = plan.scene.time.threads, math.prod(plate.counts)
    most = max(1, elements // ELEMENTS_A_THREAD)
    if asked <= most:
        return plan, ()
    needed = f"a thread needs {ELEMENTS_A_THREAD} elements to be worth it, and there are {elements}"
    decision = Decision("time.threads", most, f"{asked} were asked for; {needed}")
    return plan.with_changes({decision.key: decision.value}), (decision,)


def one_thread(asked: int) -> tuple[Decision, ...]:
    """What is said of the threads asked for where the time loop has one alone: nothing if one is asked for."""
    why = f"{asked} were asked for; the time loop of a whole impact has one"
    return (Decision("time.threads", 1, why),) if asked > 1 else ()
