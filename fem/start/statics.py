"""What the elastic state at the start says by statics alone: deflection, lag by damping, energy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fem.discretisation.model import PlateModel
from fem.start.inertia_relief import lag_by_damping, relieved_displacement, relieved_fields
from fem.start.rigid_state import RigidStart, at_corner, to_global


class Statics(NamedTuple):
    """What the reaction at the start does to the plate.

    Attributes
    ----------
    deflection : float
        Of the centre of mass towards the wall, by the plate's flexibility [m].
    gap : float
        At the corner's constraint [m].
    """

    deflection: float
    gap: float


def statics(model: PlateModel, start: RigidStart) -> Statics:
    """What the reaction at the start does to the plate.

    Parameters
    ----------
    model : PlateModel
        The plate.
    start : RigidStart
        Motion of the rigid body.

    Returns
    -------
    Statics
        Deflection and gap [m].
    """
    elastic, gap = relieved_displacement(model, start)
    moved = (to_global(start.angle) @ elastic)[1] + gap
    return Statics(-float(model.loop.mass @ moved / model.mass), gap)


def static_deflection(model: PlateModel, start: RigidStart) -> float:
    """How far [m] the reaction at the start moves the centre of mass towards the wall, by the plate's flexibility."""
    return statics(model, start).deflection


def damping_lag(model: PlateModel, start: RigidStart) -> float:
    """How far [m] the damping of elastic velocities holds back the corner in the slow change of the elastic state."""
    behind = lag_by_damping(model, relieved_fields(model, start).rate)
    return float(np.abs(at_corner(model, behind)).max())


def elastic_energy(model: PlateModel, start: RigidStart) -> float:
    """Energy [J] of the elastic state at the start by inertia relief, that of the corner's constraint included."""
    elastic, gap = relieved_displacement(model, start)
    displacement = elastic.ravel()
    spring = model.loop.corner.spring
    return float(0.5 * (displacement @ (model.stiffness @ displacement) + spring * gap**2))
