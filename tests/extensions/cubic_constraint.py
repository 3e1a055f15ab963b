"""A constraint from outside, a spring that hardens.

Its force is N = -k y (1 + (y/h)^2).
"""

from typing import Any, NamedTuple

from fem import CONSTRAINTS, Constraint


class Cubic(NamedTuple):
    """Stiffness k [N/m] and length h [m]."""

    stiffness: float
    length: float


def forces(constants: Any, gap: float, rate: float, closing: float) -> tuple[float, float]:
    share = gap / constants.length
    return -constants.stiffness * gap * (1.0 + share * share), 0.0


def energy(constants: Any, gap: float) -> float:
    share = gap / constants.length
    return 0.5 * constants.stiffness * gap * gap * (1.0 + 0.5 * share * share)


CONSTRAINT = Constraint(
    name="cubic",
    constants=Cubic,
    make=lambda inputs: Cubic(inputs.penalty_scale * inputs.youngs_modulus * inputs.thickness, 1.0),
    forces=forces,
    energy=energy,
    stiffness=lambda constants: constants.stiffness,
    text="a spring that hardens",
    keys=("penalty_scale",),
)
CONSTRAINTS.register(CONSTRAINT)
