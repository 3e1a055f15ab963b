"""Friction laws of the corner.

Each is one object, registered here or in any other file.

A law computes the tangential force R [N] from the normal force N [N], negative where the wall pulls, and from the
stopping force that would end the step with the corner at rest.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from types import NoneType
from typing import Any, NamedTuple

import numpy as np

from fem.laws.contact_forces import coulomb_force
from fem.registry import Law, LawRegistry

FRICTION_LAWS: "LawRegistry[FrictionLaw]" = LawRegistry("friction law")
"""Friction laws by their names in a scene."""


@dataclass(frozen=True, kw_only=True)
class FrictionLaw(Law):
    """Friction law of the corner.

    `constants` takes the scene's coefficient of friction alone.

    Attributes
    ----------
    force : callable
        Kernel (constants, normal, stopping) -> R [N]: the stopping force, within the limits of the law.
    slope : callable
        Kernel (constants, normal, speed) -> R over N while the corner slides at this speed [m/s].
    text : str
        Description for reports.
    rigid : str
        Name of the rigid-body theory's reaction.
    impulse : str
        History column J with friction work = -mu integral of v_P dJ, to which a check holds the run; "" where R is in
        proportion to neither.
    dissipative : bool
        Whether it can only take energy.
    """

    force: Callable[[Any, float, float], float]
    slope: Callable[[Any, float, float], float]
    text: str
    rigid: str
    impulse: str = ""
    dissipative: bool = True

    @cached_property
    def frictionless(self) -> bool:
        """True if there is no code for the law in the loop."""
        return self.constants is NoneType


def friction_slope(constants: Any, speed: float) -> float:
    """Return the tangential force per normal force while the reaction pulls.

    The corner slides at this speed [m/s].
    """
    return FRICTION_LAWS.of(constants).slope(constants, -1.0, speed)


class Drag(NamedTuple):
    """Coulomb friction of either sign of N, R = -mu |N| sign(v_P).

    R is smaller where that is enough to stop the corner.
    """

    coefficient: float


FRICTION_LAWS.register(
    FrictionLaw(
        name="drag",
        constants=Drag,
        force=lambda law, normal, stopping: coulomb_force(stopping, law.coefficient * abs(normal)),
        slope=lambda law, normal, speed: -law.coefficient * np.sign(normal) * np.sign(speed),
        text="Coulomb friction mu |N| against the sliding direction, for either sign of the reaction "
        "(Eqs 66-67)",
        rigid="drag",
        impulse="normal_impulse_magnitude",
    )
)


FRICTION_LAWS.register(
    FrictionLaw(
        name="none",
        constants=NoneType,
        force=lambda law, normal, stopping: 0.0,
        slope=lambda law, normal, speed: 0.0,
        text="no friction",
        rigid="none",
        impulse="normal_impulse",
    )
)


class Signed(NamedTuple):
    """Friction with the sign of N, R = -mu N sign(v_P).

    Where N < 0 it accelerates the corner; the law demonstrates the effect of the sign.
    """

    coefficient: float


def _signed_force(law: Signed, normal: float, stopping: float) -> float:
    limit = law.coefficient * normal
    if limit >= 0.0:
        return coulomb_force(stopping, limit)
    return limit if stopping > 0.0 else -limit


FRICTION_LAWS.register(
    FrictionLaw(
        name="signed",
        constants=Signed,
        force=_signed_force,
        slope=lambda law, normal, speed: -law.coefficient * np.sign(speed),
        text="Coulomb friction mu N with the sign of N, which accelerates the corner while the wall pulls",
        rigid="signed",
        impulse="normal_impulse",
        dissipative=False,
    )
)
