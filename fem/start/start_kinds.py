"""Kinds of start, which keep different quantities of the rigid body.

The choice is part of the result where the plate is soft.

`inertia-relief`: the quasi-static elastic state of the plate's rigid acceleration. The corner's constraint carries
the reaction from the start, and the velocity includes the slow change of both. Spin and corner speed are those of the
rigid body. The momentum of the centre, which the deformation has displaced, differs from the rigid body's.
`inertia-relief-momenta`: the same state with the rigid body's linear momentum along and across the wall. Spin and
corner speed follow, since the corner stays on the wall. `unstressed`: the unstrained plate with a rigid-body
velocity. All quantities are kept, and the plate oscillates: the reaction reaches several times its static value.

Each kind is one object, registered here or in any file outside. Code that computes the elastic state is loaded when a
plate starts with it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fem.registry import Registry

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.start.inertia_relief import RigidStart

Fields = tuple[np.ndarray, np.ndarray, *tuple[float, ...]]
"""Elastic displacement and rate, and numbers, as of `StartKind.fields`."""

START_KINDS: Registry[StartKind] = Registry("start")
"""Kinds of start by their names in a scene."""


@dataclass(frozen=True)
class StartKind:
    """A kind of start.

    Attributes
    ----------
    name : str
        In a scene.
    fields : callable
        Takes model, rigid start, and positions from the corner in the body frame, shape (2, nodes) [m]; returns
        elastic displacement and rate in that frame, shape (2, nodes) [m], [m/s], gap [m] and its rate [m/s] of the
        corner, and where they are not the rigid body's, spin [rad/s] and speed of the corner [m/s].
    text : str
        Description for reports, with the quantities that equal the rigid body's.
    relieved : bool
        True if it has the elastic state of its acceleration; without it the plate oscillates.
    """

    name: str
    fields: Callable[[PlateModel, RigidStart, np.ndarray], Fields]
    text: str
    relieved: bool = True


def _inertia_relief(model: PlateModel, start: RigidStart, body: np.ndarray) -> Fields:
    """Return the fields of inertia relief."""
    from fem.start.inertia_relief import relieved

    return relieved(model, start, body)


def _inertia_relief_momenta(model: PlateModel, start: RigidStart, body: np.ndarray) -> Fields:
    """Return the fields of inertia relief with the rigid body's momentum."""
    from fem.start import inertia_relief

    return inertia_relief.relieved_with_momenta(model, start, body)


def _unstressed(model: PlateModel, start: RigidStart, body: np.ndarray) -> Fields:
    """Return the fields of an unstrained plate."""
    return np.zeros_like(body), np.zeros_like(body), 0.0, 0.0


for _kind in (
    StartKind(
        "inertia-relief",
        _inertia_relief,
        "by inertia relief, in the quasi-static elastic state of the rigid-body acceleration, with the angular "
        "velocity and corner speed of Stage 1; its momentum differs by the rate of the deflection",
    ),
    StartKind(
        "inertia-relief-momenta",
        _inertia_relief_momenta,
        "by inertia relief, in the quasi-static elastic state of the rigid-body acceleration, with the linear momentum "
        "of Stage 1; angular velocity and corner speed follow",
    ),
    StartKind(
        "unstressed",
        _unstressed,
        "unstressed, with the rigid-body velocities of Stage 1, and oscillates",
        relieved=False,
    ),
):
    START_KINDS.register(_kind)


def start_fields(model: PlateModel, start: RigidStart, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities at t = 0.

    Parameters
    ----------
    model : PlateModel
        The plate.
    start : RigidStart
        Motion of the rigid body.
    kind : str
        A name of `START_KINDS`.

    Returns
    -------
    positions, velocities : ndarray, shape (2, nodes)
        In the wall's frame [m], [m/s].
    """
    from fem.start import inertia_relief

    body = model.discretisation.positions - inertia_relief.at_corner(model, model.discretisation.positions)
    elastic, rate, *numbers = START_KINDS[kind].fields(model, start, body)
    gap, gap_rate, spin, speed = (*numbers, start.omega, start.corner_speed)[:4]
    turn = inertia_relief.to_global(start.angle)
    arm = turn @ (body + elastic)
    positions = arm + np.array([[0.0], [gap]])
    velocities = turn @ rate + spin * np.array([-arm[1], arm[0]])
    velocities += np.array([[speed], [gap_rate]])
    return positions, velocities
