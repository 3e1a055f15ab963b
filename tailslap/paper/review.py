"""All that the command computes, in one record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tailslap.paper.earlier import EarlierMethods, earlier_methods
from tailslap.paper.figures import Figures, figures
from tailslap.paper.forces import ForceResult, row_b_known, table_4, table_5
from tailslap.paper.method import printed_motion
from tailslap.paper.restitution import Restitution, restitutions
from tailslap.paper.table_1 import Table1, table_1
from tailslap.paper.table_3 import Table3, table_3
from tailslap.paper.whole_impact import WholeImpact, whole_impact


@dataclass(frozen=True)
class Reaction:
    """The wall's reaction N on the vehicle, "drag" from the printed start [N]; negative: it pulls.

    first, last: at the start and at the tail-slap; largest: the one nearest to a push.
    """

    first: float
    last: float
    largest: float


@dataclass(frozen=True)
class Review:
    """Everything the paper prints on the truck, computed; SI throughout.

    row_b: row b of Tables 4 and 5 with its test's own speed and angle. whole_impact: that of Table 1's truck.
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
    whole_impact: WholeImpact


def review_paper() -> Review:
    """Compute all of it; under a second."""
    forces = (table_4(), table_5(), row_b_known())
    stages = (earlier_methods(), _reaction(), restitutions())
    return Review(table_1(), table_3(), figures(), *forces, *stages, whole_impact())


def _reaction() -> Reaction:
    motion = printed_motion("drag")
    normal = motion.at(np.linspace(0.0, motion.strike.t, 201)).reaction_normal
    return Reaction(float(normal[0]), motion.strike.reaction_normal, float(normal.max()))
