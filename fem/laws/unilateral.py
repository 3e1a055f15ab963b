"""Laws of unilateral contact between boundary nodes and the wall.

The wall pushes, and never pulls. Each law is one object, registered here or in any other file.

A law computes the normal force N >= 0 [N] of point i. Its arguments are the depth behind the wall [m] a step ago and,
without this force, a step ahead (`before`, `free`), the greatest mean of two such depths so far (`deepest`), and m/dt^2
of the point [N/m] (`inertia`). The step ends at the depth free - N/inertia. All laws are solved for that end, point by
point, so that none bounds the time step: with (M + dt^2 K_c/2) in place of M the plate alone does.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fem.laws.contact_forces import PointCrush, crush_force, crush_line, item, loading_depth
from fem.registry import Law, LawRegistry

CONTACT_LAWS: "LawRegistry[ContactLaw]" = LawRegistry("contact law")
"""Laws of unilateral contact by name."""


@dataclass(frozen=True, kw_only=True)
class ContactLaw(Law):
    """Law of unilateral contact.

    Attributes
    ----------
    force : callable
        Kernel (constants, i, before, free, deepest, inertia) -> normal force [N].
    stored : callable
        Kernel (constants, i, before, depth, deepest, force) -> energy that unloading returns [J].
    lost : callable
        Kernel (constants, i, deepest) -> energy that it does not return [J].
    text : str
        Description for reports.
    """

    force: Callable[[Any, int, float, float, float, float], float]
    stored: Callable[[Any, int, float, float, float, float], float]
    lost: Callable[[Any, int, float], float]
    text: str


class Crush(NamedTuple):
    """Crush of each point, as arrays of the fields of `PointCrush`.

    A part that no point has is None; `returned` is a number where it is the same for all points. The law is taken at
    the mean of the depths before and ahead, which keeps the energy on either line.
    """

    stiffness: np.ndarray
    initial_force: np.ndarray
    returned: np.ndarray | float
    plateau: np.ndarray | float | None = None
    unloading: np.ndarray | float | None = None
    hardening: np.ndarray | float | None = None


def crush_of(law: Crush, i: int) -> PointCrush:
    """Return the crush of point i."""
    returned, plateau, unloading = item(law.returned, i), item(law.plateau, i), item(law.unloading, i)
    hardening = item(law.hardening, i)
    return PointCrush(law.stiffness[i], law.initial_force[i], returned, plateau, unloading, hardening)


def _crush_force(law: Crush, i: int, before: float, free: float, deepest: float, inertia: float) -> float:
    crush, compliance, mean = crush_of(law, i), 0.5 / inertia, 0.5 * (before + free)
    depth = loading_depth(crush, mean, compliance, 1.0)
    return crush_force(crush, deepest, mean - deepest, compliance, depth)


def _crush_stored(law: Crush, i: int, before: float, depth: float, deepest: float, force: float) -> float:
    _, energy, length, returned = crush_line(crush_of(law, i), deepest)
    drop = deepest - depth
    return returned * energy * (1.0 - drop / length) ** 2 if drop < length else 0.0


def _crush_lost(law: Crush, i: int, deepest: float) -> float:
    _, energy, _, returned = crush_line(crush_of(law, i), deepest)
    return (1.0 - returned) * energy


CONTACT_LAWS.register(
    ContactLaw(
        name="crush",
        constants=Crush,
        force=_crush_force,
        stored=_crush_stored,
        lost=_crush_lost,
        text="crush with permanent set: F0 + k d up to the plateau, then its hardening; linear unloading",
    )
)


class PenaltyContact(NamedTuple):
    """Spring of energy W = k d^2/2 behind the wall.

    stiffness: k [N/m] of each point.

    N = (W_ahead - W_before) / (d_ahead - d_before), solved for each point: it keeps the energy whatever the time step
    (Armero and Petocz, Comput. Methods Appl. Mech. Eng. 158, 1998), where N = k d gains some at every touch.
    """

    stiffness: np.ndarray


def _penalty_force(
    law: PenaltyContact, i: int, before: float, free: float, deepest: float, inertia: float
) -> float:
    half, fraction = 0.5 * law.stiffness[i], 0.5 * law.stiffness[i] / inertia
    if before > 0.0:
        ahead = (free - fraction * before) / (1.0 + fraction)
        if ahead >= 0.0:
            return half * (ahead + before)
        back = before - free
        return 2.0 * half * before**2 / (back + math.sqrt(back**2 + 4.0 * fraction * before**2))
    if free <= 0.0:
        return 0.0
    displacement = free - before * (1.0 + 2.0 * fraction)
    moved = (
        0.5
        * (displacement + math.sqrt(displacement**2 - 4.0 * (1.0 + fraction) * fraction * before**2))
        / (1.0 + fraction)
    )
    return half * max(before + moved, 0.0) ** 2 / moved


def _penalty_stored(
    law: PenaltyContact, i: int, before: float, depth: float, deepest: float, force: float
) -> float:
    """Return the stored energy [J].

    With it the balance, with works by the trapezoidal rule, closes at every instant.
    """
    held = 0.25 * law.stiffness[i] * (max(depth, 0.0) ** 2 + max(before, 0.0) ** 2)
    return held + 0.5 * force * (depth - before)


CONTACT_LAWS.register(
    ContactLaw(
        name="penalty",
        constants=PenaltyContact,
        force=_penalty_force,
        stored=_penalty_stored,
        lost=lambda law, i, deepest: 0.0,
        text="a penalty spring at each node of the boundary",
    )
)


class ExactContact(NamedTuple):
    """Signorini's condition by forward-increment multipliers.

    Where the step would end behind the wall, N ends it on the wall's line (Carpenter, Taylor and Katona, Int. J. Numer.
    Meth. Eng. 32, 1991). With y >= 0 at every instant its work is -N y_before / 2: it never gains energy, and the
    energy that a node loses on touching decreases with its mass. points: their number; a tuple needs a member.
    """

    points: int


CONTACT_LAWS.register(
    ContactLaw(
        name="exact",
        constants=ExactContact,
        force=lambda law, i, before, free, deepest, inertia: inertia * max(free, 0.0),
        stored=lambda law, i, before, depth, deepest, force: 0.0,
        lost=lambda law, i, deepest: 0.0,
        text="Signorini's condition at each node of the boundary, by forward-increment multipliers",
    )
)


def penalty_stiffness(youngs_modulus: float, thickness: float, scale: float = 1.0) -> float:
    """Return the stiffness [N/m] of a contact point that does not crush.

    It is three times that of a square element, which is Young's modulus [Pa] times thickness [m], times the scale. A
    larger stiffness costs no time, but the force is noisier.
    """
    return 3.0 * scale * youngs_modulus * thickness
