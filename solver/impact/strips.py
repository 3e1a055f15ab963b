"""Parts of vehicles that the wall can push.

A strip is a point or a line along the side of a unit, on both sides of it. A group of contact points
1. is one strip on one side of one unit; no point belongs to two groups;
2. is numbered unit by unit, in each first the strips on the side of the wall, then those on the far side;
3. has one law, which a length multiplies where it is a line, and the friction of all;
4. strikes as a whole: its contacts are strikes by the rule of `counting`, whichever of its points touch;
5. has a name that says where it is, the same in the plane, on the plate and in results.
SI units.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from solver import rules
from solver.conditions import Array, Gate, Number, RigidBodyError, demand, number
from solver.impact.crush_law import LAW, CrushLaw

LINE_POINTS = 128
"""Gauss points of a line along the side."""

ROUNDING = 1e-6
"""Part of its length by which a place at the rear may differ from it, in other units."""

SIDES = (-1.0, 1.0)
"""Signs of the distance to the left: the side of the wall, the far side."""

SCALED = ("stiffness", "initial_force", "plateau_force", "unloading_stiffness", "hardening")
"""Parameters of a law that a length multiplies."""


@dataclass(frozen=True)
class Strip:
    """Point or line of a unit that the wall can push.

    Parameters
    ----------
    at : (float or ndarray, float or ndarray)
        Distances of both ends behind the front of the unit [m]; a point if they are equal.
    law : CrushLaw
        Its crush: of a point, or per metre of a line.
    inset : float or ndarray
        Distance inwards from the side [m].
    unit : int
        Number of its unit in a train, from 0.
    """

    at: tuple[Number, Number]
    law: CrushLaw
    inset: Number = 0.0
    unit: int = 0

    @property
    def is_line(self) -> bool:
        """True unless both ends are one point."""
        return not np.array_equal(*self.at)


@dataclass(frozen=True)
class WallContact:
    """Laws of a vehicle's or a train's contact with the wall.

    Parameters
    ----------
    crush : CrushLaw or None
        Crush of both corners of each unit without strips; None where all units have strips.
    friction : float or ndarray
        Coulomb's coefficient mu [-].
    strips : tuple of Strip
        What the wall can push of the units that they name.

    Raises
    ------
    RigidBodyError
        Unless the friction is 0 or more and finite.
    """

    crush: CrushLaw | None
    friction: Number
    strips: tuple[Strip, ...] = ()

    def __post_init__(self) -> None:
        Gate().not_negative(rules.FRICTION, number("friction", self.friction))


def strips_of_units(contact: WallContact, lengths: Sequence[Number]) -> list[tuple[Strip, ...]]:
    """Return the strips of each unit.

    Those of a unit without any are its corners.

    lengths: of the units [m]. Raises RigidBodyError for a unit that has neither.
    """
    units = []
    for u, length in enumerate(lengths):
        strips = tuple(strip for strip in contact.strips if strip.unit == u)
        if not strips:
            if contact.crush is None:
                raise RigidBodyError(
                    "contact", f"unit {u + 1}", "nothing of it can touch the wall", "a strip of this unit"
                )
            strips = tuple(Strip((place, place), contact.crush, unit=u) for place in (0.0 * length, length))
        units.append(strips)
    return units


def demand_strips(contact: WallContact, lengths: Array, widths: Array) -> None:
    """Require strips that are parts of their units.

    lengths, widths: of the units [m], shape (units, ...). Raises RigidBodyError.
    """
    for k, strip in enumerate(contact.strips):
        demand(
            rules.STRIP_UNIT, f"strip.{k}.unit", 0 <= strip.unit < len(lengths), strip.unit, most=len(lengths)
        )
        length, half = lengths[strip.unit], 0.5 * widths[strip.unit]
        begin, end = strip.at
        for place in strip.at:
            demand(
                rules.STRIP_AT,
                f"strip.{k}.at",
                (place >= 0.0) & (place <= length * (1.0 + ROUNDING)),
                place,
                length=length,
            )
        demand(rules.STRIP_LENGTH, f"strip.{k}.at", (end > begin) | (not strip.is_line), begin)
        demand(
            rules.INSET,
            f"strip.{k}.inset",
            (strip.inset >= 0.0) & (strip.inset < half),
            strip.inset,
            most=half,
        )


class Points(NamedTuple):
    """Contact points of trains, n samples, with columns as of `Train`.

    unit, group: shape (points,); along, across and each parameter of the law: shape (points, n).
    """

    unit: NDArray[np.int64]
    group: NDArray[np.int64]
    along: Array
    across: Array
    law: dict[str, Array]


def points_of(contact: WallContact, lengths: Array, widths: Array, centres: Array) -> Points:
    """Return the contact points of trains.

    lengths, widths, centres: of the units, centre of mass behind the front, shape (units, n) [m]. Raises RigidBodyError
    for a strip outside its unit.
    """
    demand_strips(contact, lengths, widths)
    group, owner, places, laws = 0, list[tuple[int, int]](), list[Any](), list[Any]()
    for u, strips in enumerate(strips_of_units(contact, [*lengths])):
        for side in SIDES:
            for strip in strips:
                begin, end = strip.at
                for node, weight in zip(*_nodes(strip), strict=True):
                    owner.append((u, group))
                    place = begin + node * (end - begin) if strip.is_line else begin
                    places.append((centres[u] - place, side * (0.5 * widths[u] - strip.inset)))
                    laws.append(_scaled(strip.law, weight * (end - begin) if strip.is_line else 1.0))
                group += 1
    shape = lengths.shape[1:]
    along, across = (
        np.array([np.broadcast_to(v, shape) for v in column]) for column in zip(*places, strict=True)
    )
    law = {
        key: np.array([np.broadcast_to(values[key], shape) for values in laws], dtype=np.float64)
        for key in LAW
    }
    unit, groups = np.array(owner).T.copy()
    return Points(unit, groups, along, across, law)


def _nodes(strip: Strip) -> tuple[Array, Array]:
    """Return places of a strip's points over its length, and weights."""
    if not strip.is_line:
        return np.zeros(1), np.ones(1)
    nodes, weights = np.polynomial.legendre.leggauss(LINE_POINTS)
    return 0.5 * (1.0 + nodes), 0.5 * weights


def _scaled(law: CrushLaw, length: Number) -> dict[str, Number]:
    """Return the parameters of a law of this length [m]."""
    return {key: getattr(law, key) * (length if key in SCALED else 1.0) for key in LAW}


def group_names(contact: WallContact, lengths: Sequence[float]) -> tuple[str, ...]:
    """Return the name of each group.

    Parameters
    ----------
    contact : WallContact
        Of the train.
    lengths : sequence of float
        Lengths of its units [m].

    Returns
    -------
    tuple of str
        "front" and "rear" of a point there, otherwise the place, e.g. "7.2 m" or "2.6 to 10 m"; with "far side" behind
        it, and "trailer", "trailer 2" and so on in front; a second group of that name ends with its number.
    """
    units = strips_of_units(contact, lengths)
    return names_of_places([[strip.at for strip in strips] for strips in units], lengths)


def names_of_places(
    units: Sequence[Sequence[tuple[Number, Number]]], lengths: Sequence[Number]
) -> tuple[str, ...]:
    """Return names as of `group_names` for strips at these places.

    units: both ends of each strip of each unit behind its front [m].
    """
    names = list[str]()
    for u, (places, length) in enumerate(zip(units, lengths, strict=True)):
        number = f"{u} " if u > 1 else ""
        unit = f"trailer {number}" if u else ""
        for side in ("", " far side"):
            for place in places:
                name = f"{unit}{_place(*place, length)}{side}"
                count = 1 + sum(other.partition(" #")[0] == name for other in names)
                names.append(f"{name} #{count}" if count > 1 else name)
    return tuple(names)


def _place(begin: Number, end: Number, length: Number) -> str:
    """Return a strip's place in words."""
    if begin != end:
        return f"{begin:g} to {end:g} m"
    return "front" if begin == 0.0 else "rear" if begin >= length * (1.0 - ROUNDING) else f"{begin:g} m"


def outermost(contact: WallContact, lengths: Sequence[Number]) -> tuple[int, int]:
    """Return the first unit's foremost and the last one's rearmost group.

    Both are on the side of the wall; of samples mean places count.

    Parameters
    ----------
    contact : WallContact
        Of the train.
    lengths : sequence of float or ndarray
        Lengths of its units [m].

    Returns
    -------
    (int, int)
        Indices into `group_names`.
    """
    units = strips_of_units(contact, lengths)
    first = int(np.argmin([np.mean(strip.at[0]) for strip in units[0]]))
    before = 2 * sum(len(strips) for strips in units[:-1])
    return first, before + int(np.argmax([np.mean(strip.at[1]) for strip in units[-1]]))


def awaited(contact: WallContact, lengths: Sequence[Number]) -> int:
    """Return the group whose strike is awaited before the end.

    Parameters
    ----------
    contact : WallContact
        Of the train.
    lengths : sequence of float or ndarray
        Lengths of its units [m].

    Returns
    -------
    int
        The rearmost group of a train, and of a vehicle with more strips than two; -1 of others, whose second strike
        is awaited.
    """
    first, last = outermost(contact, lengths)
    return last if first != last and (len(lengths) > 1 or len(contact.strips) > 2) else -1
