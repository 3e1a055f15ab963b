"""The state a run starts from: which quantities of the rigid body it keeps is part of the result of a soft plate.

`inertia-relief`: the quasi-static elastic state that belongs to the plate's rigid acceleration, with the corner's
constraint already carrying the reaction, and the slow change of both in the velocity. Keeps the spin and the corner's
speed; the centre, which the deformation has moved, begins with another momentum than the rigid body's.
`inertia-relief-momenta`: the same state with the rigid body's linear momentum, along and across the wall; spin and
speed of the corner follow, since it stays on the wall.
`unstressed`: the unstrained plate with a rigid-body velocity. Keeps all of them, and rings: the reaction, to several
times its size.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fem.discretisation.model import PlateModel
from fem.start.rigid_state import RigidStart, at_corner, to_global
from fem.start.start_kinds import START_KINDS


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
    body = model.discretisation.positions - at_corner(model, model.discretisation.positions)
    return _placed(START_KINDS[kind].fields(model, start, body), start, body)


def _placed(fields: tuple[Any, ...], start: RigidStart, body: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities in the wall's frame of a plate with these fields beside the rigid motion."""
    elastic, rate, gap, gap_rate = fields[:4]
    spin, speed = fields[4:] or (start.omega, start.corner_speed)
    turn = to_global(start.angle)
    arm = turn @ (body + elastic)
    positions = arm + np.array([[0.0], [gap]])
    velocities = turn @ rate + spin * np.array([-arm[1], arm[0]])
    velocities += np.array([[speed], [gap_rate]])
    return positions, velocities
