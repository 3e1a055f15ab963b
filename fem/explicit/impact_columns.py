"""Columns of a whole impact's history: name, SI unit, meaning."""

from __future__ import annotations

from fem.explicit.columns import Column

_COLUMNS = {
    "t": ("s", "time since the first touch"),
    "x_g": ("m", "centre of mass along the wall, from where the corner first touches"),
    "y_g": ("m", "centre of mass across the wall"),
    "theta": ("rad", "angle between side and wall"),
    "omega": ("rad/s", "spin, positive where it closes the angle"),
    "v_gx": ("m/s", "velocity of the centre of mass along the wall"),
    "v_gy": ("m/s", "velocity of the centre of mass across the wall, negative towards it"),
    "force_normal": ("N", "of the wall on the plate across it, mean since the row before"),
    "force_tangential": ("N", "of the wall on the plate along it, mean since the row before"),
    "kinetic_energy": ("J", "of the plate"),
    "strain_energy": ("J", "of the plate"),
    "hourglass_energy": ("J", "of hourglass control"),
    "contact_energy": ("J", "that contact will give back"),
    "crush_energy": ("J", "that crush has taken for good"),
    "friction_work": ("J", "done on the plate by friction since the start"),
    "damping_work": ("J", "done on the plate by damping since the start"),
    "vibration_energy": ("J", "kinetic energy that is not rigid motion's"),
    "normal_impulse": ("N s", "of the wall on the plate across it since the start"),
    "tangential_impulse": ("N s", "of the wall on the plate along it since the start"),
    "moment_impulse": ("N m s", "of the wall on the plate about the wall's frame since the start"),
    "angular_momentum": ("kg m^2/s", "of the plate about the wall's frame"),
    "wall_energy": ("J", "kinetic and elastic, of the wall and its foundation; 0 for a rigid wall"),
    "wall_deflection": ("m", "the largest of the wall's face; 0 for a rigid wall"),
    "wall_deflection_place": ("m", "where along the wall that is; 0 for a rigid wall"),
    "foundation_impulse": ("N s", "of the foundation on the wall since the start; 0 for a rigid wall"),
    "force_foundation": ("N", "of the foundation on the wall, mean since the row before; 0 for a rigid wall"),
}

IMPACT_COLUMNS: dict[str, Column] = {
    name: Column(name, unit, meaning=meaning) for name, (unit, meaning) in _COLUMNS.items()
}
"""Columns by name."""
