"""What a model is made from: properties of plate, corner and time step, and what is wrong where none can be made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any


class ModelError(ValueError):
    """No model can be made; `wrong` is the property at fault: "elements" or "patch_length"."""

    def __init__(self, wrong: str, why: str) -> None:
        self.wrong = wrong
        super().__init__(why)


@dataclass(frozen=True)
class PlateProperties:
    """Thickness [m], density [kg/m^3], Young's modulus [Pa], Poisson's ratio, and choices by name.

    hourglass: share of the stiffness that controls one-point elements; others have none.
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
    """How the corner is held: by a constraint of `fem.contact.constraints`, with this multiple of its usual stiffness.

    patch_length [m]: of the support patch, 0 for the corner node alone. damping_ratio: of the constraint's dashpot, to
    critical. friction: constants of a law of `fem.contact.friction`, or None. angles [rad]: of the plate during the
    run, for the time step.
    """

    friction: Any = None
    constraint: str = "penalty"
    penalty_scale: float = 1.0
    patch_length: float = 0.0
    damping_ratio: float = 0.0
    angles: tuple[float, ...] = (0.26, 0.13, 0.0)


@dataclass(frozen=True)
class StepProperties:
    """Share of the stable time step that is taken, an upper bound on it [s], and damping.

    damping_ratio: stiffness-proportional, to critical at the highest frequency. bulk_viscosity: linear, the
    dimensionless coefficient of density x wave speed x element size. elastic_rate [1/s]: of the elastic velocities.
    """

    safety_factor: float = 0.9
    longest: float = math.inf
    damping_ratio: float = 0.0
    bulk_viscosity: float = 0.0
    elastic_rate: float = 0.0
