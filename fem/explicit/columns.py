"""Columns of the histories, with units and meanings.

The compiled record of an instant has a field for each of the program's own columns. Other columns are registered as
one object each, here or in any file outside. A column
1. has a name of its own, a unit and a meaning;
2. is computed in Python: of the constrained corner from that record and the state once per recorded row, of a whole
   impact from the columns of the history;
3. changes neither state nor other columns, and depends on no earlier row.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from fem.registry import Registry

COLUMNS: Registry[HistoryColumn] = Registry("column")
"""Columns by name in the order of the history, those of the record first."""

IMPACT_COLUMNS: Registry[HistoryColumn] = Registry("column of a whole impact")
"""Columns of a whole impact's history by name, in its order."""

_AXLES, _RIGID = "; with [[axle]] only", "; 0 for a rigid wall"
_MEANINGS = {
    "t": ("s", "time since first contact"),
    "x_g": ("m", "position of the centre of mass along the wall, from the point of first contact"),
    "y_g": ("m", "distance of the centre of mass from the wall"),
    "theta": ("rad", "angle between the side of the vehicle and the wall"),
    "omega": ("rad/s", "angular velocity, positive as the rear rotates towards the wall"),
    "v_gx": ("m/s", "velocity of the centre of mass along the wall"),
    "v_gy": ("m/s", "velocity of the centre of mass normal to the wall, negative towards it"),
    "slide": ("m", "displacement of the corner along the wall"),
    "v_p": ("m/s", "speed of the corner along the wall"),
    "reaction_normal": ("N", "normal reaction of the wall on the plate, negative in tension"),
    "reaction_tangential": ("N", "friction force of the wall on the plate"),
    "force_normal": ("N", "normal force of the wall on the plate, mean since the previous row"),
    "force_tangential": ("N", "tangential force of the wall on the plate, mean since the previous row"),
    "kinetic_energy": ("J", "kinetic energy of the plate"),
    "strain_energy": ("J", "strain energy of the plate"),
    "contact_energy": ("J", "energy of the penalty spring at the corner"),
    "crush_energy": ("J", "energy dissipated by crush"),
    "friction_work": ("J", "work of friction on the plate since the start"),
    "damping_work": ("J", "work of damping on the plate since the start"),
    "vibration_energy": ("J", "kinetic energy of the deviation from rigid-body motion"),
    "normal_impulse": ("N s", "impulse of the normal reaction since the start"),
    "normal_impulse_magnitude": ("N s", "impulse of the magnitude of the normal reaction since the start"),
    "tangential_impulse": ("N s", "impulse of the tangential force on the plate since the start"),
    "moment_impulse": ("N m s", "angular impulse on the plate about the origin since the start"),
    "angular_momentum": ("kg m^2/s", "angular momentum of the plate about the origin"),
    "tyre_work": ("J", f"work of the tyres on the plate since the start{_AXLES}"),
    "tyre_impulse_tangential": ("N s", f"impulse of the tyres along the wall since the start{_AXLES}"),
    "tyre_impulse_normal": ("N s", f"impulse of the tyres across the wall since the start{_AXLES}"),
    "tyre_impulse_angular": (
        "N m s",
        f"angular impulse of the tyres about the origin since the start{_AXLES}",
    ),
    "gap": ("m", "distance of the corner from the wall"),
    "hourglass_energy": ("J", "energy of hourglass control"),
    "wall_energy": ("J", f"kinetic and strain energy of the wall and its foundation{_RIGID}"),
    "wall_deflection": ("m", f"largest deflection of the face of the wall{_RIGID}"),
    "wall_deflection_place": ("m", f"position of the largest deflection along the wall{_RIGID}"),
    "foundation_impulse": ("N s", f"impulse of the foundation on the wall since the start{_RIGID}"),
    "force_foundation": ("N", f"force of the foundation on the wall, mean since the previous row{_RIGID}"),
}
"""Units and meanings of the built-in columns."""

_ON_IMPACT = {
    "contact_energy": "recoverable energy of the contact",
    "normal_impulse": "impulse of the normal force on the plate since the start",
}
"""Meanings that differ in a whole impact."""

_IMPACT_NAMES = """t x_g y_g theta omega v_gx v_gy force_normal force_tangential kinetic_energy strain_energy
hourglass_energy contact_energy crush_energy friction_work damping_work vibration_energy normal_impulse
tangential_impulse moment_impulse angular_momentum wall_energy wall_deflection wall_deflection_place
foundation_impulse force_foundation tyre_work tyre_impulse_tangential tyre_impulse_normal tyre_impulse_angular"""


class Measures(NamedTuple):
    """Measures of the constrained plate at an instant.

    Attributes
    ----------
    theta, omega : float
        Angle between side and wall [rad], and spin [rad/s], positive as the rear rotates towards the wall.
    v_gx, v_gy : float
        Velocity of the centre of mass [m/s].
    slide, v_p : float
        Place [m] and speed [m/s] of the corner along the wall.
    reaction_normal, reaction_tangential : float
        Reaction of the wall on the plate [N].
    kinetic_energy, strain_energy, contact_energy, hourglass_energy : float
        Energies of the model [J].
    friction_work, damping_work : float
        Work on the plate since the start [J].
    vibration_energy : float
        Kinetic energy of the deviation from rigid motion [J].
    normal_impulse, normal_impulse_magnitude : float
        Impulse of the normal reaction, and of its magnitude [N s]. They differ where the reaction oscillates through
        zero.
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
class HistoryColumn:
    """A column of the history.

    Attributes
    ----------
    name : str
        In `history.csv`.
    unit : str
        SI.
    value : callable or None
        (measures, state, model) -> number; of a whole impact (history, model) -> array of shape (rows,). None for the
        record's own field of that name.
    symbol, caption : str
        Symbol and caption of its plot; a column without a symbol has none of its own.
    meaning : str
        In words, for the reference.
    """

    name: str
    unit: str
    value: Callable[..., Any] | None = None
    symbol: str = ""
    caption: str = ""
    meaning: str = ""


for _name in Measures._fields:
    COLUMNS.register(HistoryColumn(_name, _MEANINGS[_name][0], meaning=_MEANINGS[_name][1]))

for _name in _IMPACT_NAMES.split():
    _meaning = _ON_IMPACT.get(_name, _MEANINGS[_name][1])
    IMPACT_COLUMNS.register(HistoryColumn(_name, _MEANINGS[_name][0], meaning=_meaning))


def row_of(measures: Measures, state: object, model: object) -> tuple[float, ...]:
    """Return the columns' values at an instant.

    Those of the record come first.
    """
    functions = [column.value for column in COLUMNS.values() if column.value is not None]
    return (*measures, *(float(function(measures, state, model)) for function in functions))
