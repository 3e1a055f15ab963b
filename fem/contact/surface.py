"""The wall's face under a contact point: what contact asks of the wall. A rigid wall is None, and compiled to nothing;
`elastic_wall` is loaded with the first wall that gives."""

from __future__ import annotations

from typing import Any, NamedTuple

from fem.compiled import implements


class Surface(NamedTuple):
    """The face under a contact point; x along the wall, y across it.

    left, share: the node of the face before the point, and the next one's part in what is interpolated; beyond: how far
    beyond the wall's end the point is [m]; sink: the face's y [m], and slope its derivative along the wall [-]; rate:
    velocity [m/s]; pull: acceleration by the forces that are known [m/s^2]; give: mobility [1/kg].
    """

    left: int
    share: float
    beyond: float
    sink: float
    slope: float
    rate_x: float
    rate_y: float
    pull_x: float
    pull_y: float
    give_x: float
    give_y: float


def resist(wall: Any, moving: Any) -> None:
    """Begin the wall's forces of this instant with its own and its foundation's; compiled code only."""
    raise NotImplementedError(type(wall))


def under(wall: Any, moving: Any, contact: Any, i: int, positions: Any, origin: float) -> Surface:
    """The face under contact point i, positions [m] being counted from the origin; compiled code only."""
    raise NotImplementedError(type(wall))


def tilted(wall: Any, face: Surface, value: float) -> float:
    """The face's slope times a value; compiled code only."""
    raise NotImplementedError(type(wall))


def press(wall: Any, moving: Any, face: Surface, tangential: float, normal: float) -> None:
    """Put the reaction to the forces [N] on a contact point onto the face; compiled code only."""
    raise NotImplementedError(type(wall))


def move(wall: Any, moving: Any, time_step: float) -> None:
    """Move the wall on by a step, its forces being complete; compiled code only."""
    raise NotImplementedError(type(wall))


def held_by(wall: Any, moving: Any, half: float) -> tuple[float, float, float, float]:
    """Energy [J] of the wall and its foundation; largest deflection of the face [m] and its place along the wall [m];
    impulse of the foundation across the wall [N s]; half: of the time step [s]. Compiled code only."""
    raise NotImplementedError(type(wall))


@implements(resist, type(None), merged=True)
def _nothing_resists(wall, moving):
    return


@implements(under, type(None), merged=True)
def _rigid(wall, moving, contact, i, positions, origin):
    return Surface(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@implements(tilted, type(None), merged=True)
def _straight(wall, face, value):
    return 0.0


@implements(press, type(None), merged=True)
def _nothing_pressed(wall, moving, face, tangential, normal):
    return


@implements(move, type(None), merged=True)
def _nothing_moves(wall, moving, time_step):
    return


@implements(held_by, type(None), merged=True)
def _nothing_held(wall, moving, half):
    return 0.0, 0.0, 0.0, 0.0
