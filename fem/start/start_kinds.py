"""Kinds of start: which quantities of the rigid body a plate keeps is part of the result where it is soft.

`inertia-relief`: the quasi-static elastic state that belongs to the plate's rigid acceleration, with the corner's
constraint already carrying the reaction, and the slow change of both in the velocity. Keeps the spin and the corner's
speed; the centre, which the deformation has moved, begins with another momentum than the rigid body's.
`inertia-relief-momenta`: the same state with the rigid body's linear momentum, along and across the wall; spin and
speed of the corner follow, since it stays on the wall.
`unstressed`: the unstrained plate with a rigid-body velocity. Keeps all of them, and rings: the reaction, to several
times its size.

Each is one object; adding one is adding it here, or in any file that registers it. Code that finds the elastic state is
loaded when a plate starts with it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.registry import Registry

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.start.inertia_relief import RigidStart


@dataclass(frozen=True)
class StartKind:
    """A kind of start.

    Attributes
    ----------
    name : str
        In a scene.
    fields : callable
        Takes model, rigid start, and positions from the corner in the body frame, shape (2, nodes) [m]; returns elastic
        displacement and rate in that frame, shape (2, nodes) [m], [m/s], gap [m] and its rate [m/s] of the corner, and
        where they are not the rigid body's, spin [rad/s] and speed of the corner [m/s].
    text : str
        For reports: how the plate starts, and what it keeps of the rigid body.
    relieved : bool
        Whether it has the elastic state of its acceleration; without it, it oscillates.
    """

    name: str
    fields: Callable[[PlateModel, RigidStart, np.ndarray], Any]
    text: str
    relieved: bool = True


START_KINDS: Registry[StartKind] = Registry("start")
"""Kinds of start by their names in a scene."""


def _inertia_relief(model: PlateModel, start: RigidStart, body: np.ndarray) -> Any:
    from fem.start.inertia_relief import relieved

    return relieved(model, start, body)


def _inertia_relief_momenta(model: PlateModel, start: RigidStart, body: np.ndarray) -> Any:
    from fem.start import inertia_relief

    return inertia_relief.relieved_with_momenta(model, start, body)


def _unstressed(model: PlateModel, start: RigidStart, body: np.ndarray) -> Any:
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
    """Positions and velocities at t = 0.

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
    elastic, rate, gap, gap_rate, *others = START_KINDS[kind].fields(model, start, body)
    spin, speed = others or (start.omega, start.corner_speed)
    turn = inertia_relief.to_global(start.angle)
    arm = turn @ (body + elastic)
    positions = arm + np.array([[0.0], [gap]])
    velocities = turn @ rate + spin * np.array([-arm[1], arm[0]])
    velocities += np.array([[speed], [gap_rate]])
    return positions, velocities
