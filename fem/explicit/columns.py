"""Columns of the history. Each is one object; adding one is adding it here, or in any file that registers it.

The compiled record of an instant has a field for each of the program's own columns; what other columns need is worked
out from that record and the state, in Python, once a recorded row.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from fem.registry import Registry


class Measures(NamedTuple):
    """The compiled record of an instant.

    Attributes
    ----------
    theta, omega : float
        Angle between side and wall [rad], and spin [rad/s], positive where it closes the angle.
    v_gx, v_gy : float
        Velocity of the centre of mass [m/s].
    slide, v_p : float
        Place [m] and speed [m/s] of the corner along the wall.
    reaction_normal, reaction_tangential : float
        Of the wall on the plate [N].
    kinetic_energy, strain_energy, contact_energy, hourglass_energy : float
        What the model holds [J].
    friction_work, damping_work : float
        Done on the plate since the start [J].
    vibration_energy : float
        Kinetic energy that is not rigid motion's [J].
    normal_impulse, normal_impulse_magnitude : float
        Of the normal reaction, and of its magnitude [N s]: they part where the reaction rings through zero.
    gap : float
        Distance of the corner from the wall's line [m].
    """

    theta: float
    omega: float
    v_gx: float
    v_gy: float
    slide: float
    v_p: float
    reaction_normal: float
    reaction_tangential: float
    kinetic_energy: float
    strain_energy: float
    contact_energy: float
    friction_work: float
    damping_work: float
    vibration_energy: float
    normal_impulse: float
    normal_impulse_magnitude: float
    gap: float
    hourglass_energy: float


@dataclass(frozen=True)
class Column:
    """A column of the history.

    Attributes
    ----------
    name : str
        In `history.csv`.
    unit : str
        SI.
    value : callable or None
        (measures, state, model) -> number; None for the record's own field of that name.
    symbol, caption : str
        Of its plot; without a symbol it has none of its own.
    meaning : str
        In words, for the reference.
    """

    name: str
    unit: str
    value: Callable[[Measures, Any, Any], float] | None = None
    symbol: str = ""
    caption: str = ""
    meaning: str = ""


COLUMNS: Registry[Column] = Registry("column")
"""Columns by name, in the order of the history; the record's own come first."""

_OWN = {
    "theta": ("rad", "angle between side and wall"),
    "omega": ("rad/s", "spin, positive where it closes the angle"),
    "v_gx": ("m/s", "velocity of the centre of mass along the wall"),
    "v_gy": ("m/s", "velocity of the centre of mass across the wall, negative towards it"),
    "slide": ("m", "displacement of the corner along the wall"),
    "v_p": ("m/s", "speed of the corner along the wall"),
    "reaction_normal": ("N", "of the wall on the plate, negative where it pulls"),
    "reaction_tangential": ("N", "friction of the wall on the plate"),
    "kinetic_energy": ("J", "of the plate"),
    "strain_energy": ("J", "of the plate"),
    "contact_energy": ("J", "of the corner's constraint"),
    "friction_work": ("J", "done on the plate by friction since the start"),
    "damping_work": ("J", "done on the plate by damping since the start"),
    "vibration_energy": ("J", "kinetic energy that is not rigid motion's"),
    "normal_impulse": ("N s", "of the normal reaction since the start"),
    "normal_impulse_magnitude": ("N s", "of the magnitude of the normal reaction since the start"),
    "gap": ("m", "distance of the corner from the wall's line"),
    "hourglass_energy": ("J", "of hourglass control"),
}

for _name in Measures._fields:
    COLUMNS.register(Column(_name, _OWN[_name][0], meaning=_OWN[_name][1]))


def row_of(measures: Measures, state: Any, model: Any) -> tuple[float, ...]:
    """Values of all columns: the record, then what other columns make of it."""
    others = [column.value for column in COLUMNS.values() if column.value is not None]
    return (*measures, *(float(value(measures, state, model)) for value in others))
