"""All that the command computes, in one record."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

import tailslap
from tailslap.paper.earlier import EarlierMethods, earlier_methods
from tailslap.paper.figures import Figures, figures
from tailslap.paper.forces import ForceResult, row_b_known, table_4, table_5
from tailslap.paper.method import printed_motion
from tailslap.paper.printed import INPUTS, PAPER, START
from tailslap.paper.restitution import Restitution, restitutions
from tailslap.paper.table_1 import Table1, table_1
from tailslap.paper.table_3 import Table3, table_3


@dataclass(frozen=True)
class Reaction:
    """The wall's reaction N on the vehicle, "drag" from the printed start [N]; negative: it pulls.

    first, last: at the start and at the tail-slap; largest: the one nearest to a push.
    """

    first: float
    last: float
    largest: float


@dataclass(frozen=True)
class Answer:
    """Everything the paper prints on the truck, computed; SI throughout.

    row_b: row b of Tables 4 and 5 with its test's own speed and angle.
    """

    table_1: Table1
    table_3: Table3
    figures: Figures
    table_4: tuple[ForceResult, ...]
    table_5: tuple[ForceResult, ...]
    row_b: tuple[ForceResult, ForceResult]
    earlier: EarlierMethods
    reaction: Reaction
    restitution: dict[str, Restitution]


def answer() -> Answer:
    """Compute all of it; some tens of milliseconds."""
    return Answer(
        table_1(),
        table_3(),
        figures(),
        table_4(),
        table_5(),
        row_b_known(),
        earlier_methods(),
        _reaction(),
        restitutions(),
    )


def numbers(result: Answer) -> dict[str, Any]:
    """The record as JSON takes it, SI; a cell is {"printed", "computed", "difference"}.

    The curves of the figures are left out: they stand in files of their own.
    """
    inputs = {item.name: {"given": item.given, "value": item.value, "unit": item.unit} for item in INPUTS}
    record = asdict(result)
    del record["figures"]["courses"]
    return {
        "version": tailslap.__version__,
        "paper": PAPER,
        "inputs": inputs,
        "start": asdict(START),
        **record,
    }


def _reaction() -> Reaction:
    motion = printed_motion("drag")
    normal = motion.at(np.linspace(0.0, motion.strike.t, 201)).reaction_normal
    return Reaction(float(normal[0]), motion.strike.reaction_normal, float(normal.max()))
