"""What a model is made from: properties of plate, corner and time step, and what is wrong where none can be made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any


class ModelError(ValueError):
    """No model can be made of these properties.

    Parameters
    ----------
    wrong : str
        The property at fault, "elements" or "patch_length"; also an attribute.
    why : str
        The message.
    """

    def __init__(self, wrong: str, why: str) -> None:
        self.wrong = wrong
        super().__init__(why)


@dataclass(frozen=True)
class PlateProperties:
    """What the plate is made of, and choices by name.

    Attributes
    ----------
    thickness : float
        [m].
    density : float
        [kg/m^3].
    youngs_modulus : float
        [Pa].
    poissons_ratio : float
        [-].
    lumping : str
        Of the mass: "exact" or "row-sum".
    element : str
        A name of `ELEMENT_KINDS`.
    material : str
        A name of `MATERIALS`.
    hourglass : float
        Share of the stiffness that controls one-point elements [-]; others have none.
    """

    thickness: float
    density: float
    youngs_modulus: float
    poissons_ratio: float
    lumping: str = "exact"
    element: str = "quad4"
    material: str = "st-venant-kirchhoff"
    hourglass: float = 0.1


@dataclass(frozen=True)
class CornerProperties:
    """How the corner is held on the wall.

    Attributes
    ----------
    friction : NamedTuple or None
        Constants of a law of `FRICTION_LAWS`.
    constraint : str
        A name of `CONSTRAINTS`.
    penalty_scale : float
        Multiple of the constraint's usual stiffness [-].
    patch_length : float
        Of the support patch [m]; 0 for the corner node alone.
    damping_ratio : float
        Of the constraint's dashpot, to critical [-].
    angles : tuple of float
        Angles of the plate during the run [rad], at which the time step is looked at.
    """

    friction: Any = None
    constraint: str = "penalty"
    penalty_scale: float = 1.0
    patch_length: float = 0.0
    damping_ratio: float = 0.0
    angles: tuple[float, ...] = (0.26, 0.13, 0.0)


@dataclass(frozen=True)
class StepProperties:
    """The time step, and damping of the plate.

    Attributes
    ----------
    safety_factor : float
        Share of the stable time step that is taken [-].
    longest : float
        Upper bound on the time step [s].
    damping_ratio : float
        Stiffness-proportional, to critical at the highest frequency [-].
    bulk_viscosity : float
        Linear: coefficient of density x wave speed x element size [-].
    elastic_rate : float
        Rate at which elastic velocities are damped [1/s].
    """

    safety_factor: float = 0.9
    longest: float = math.inf
    damping_ratio: float = 0.0
    bulk_viscosity: float = 0.0
    elastic_rate: float = 0.0
