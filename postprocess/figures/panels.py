"""Which plots there are: the columns of a history that each shows, with its words. Data, no drawing.

Known columns, SI: t, theta, omega, v_gx, v_gy, slide, reaction_normal, reaction_tangential, kinetic_energy,
strain_energy, contact_energy, vibration_energy, friction_work, damping_work, energy_error. Others are
ignored, and a plot of which no column is there is not drawn.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Panel:
    """A plot: short name, columns with their labels, axis symbol and unit, group and caption."""

    name: str
    columns: tuple[tuple[str, str], ...]
    symbol: str
    unit: str
    group: str
    caption: str
    from_start: bool = False


def _compared(name: str, symbol: str, unit: str, group: str, caption: str) -> Panel:
    return Panel(name, ((name, "FE"),), symbol, unit, group, caption)


COMPARED = (
    _compared("theta", "θ", "rad", "Motion", "Angle θ between the side PE and the wall"),
    _compared("omega", "ω", "rad/s", "Motion", "Angular velocity ω, positive where it closes the angle"),
    _compared("v_gx", "v_GX", "m/s", "Motion", "Velocity of G along the wall"),
    _compared("v_gy", "v_GY", "m/s", "Motion", "Velocity of G across the wall, negative towards it"),
    _compared("slide", "s", "m", "Motion", "Slide of the corner P along the wall"),
    _compared("reaction_normal", "N", "N", "Reaction", "Wall reaction on the vehicle, below zero a pull"),
    _compared("reaction_tangential", "R", "N", "Reaction", "Friction force on the vehicle along the wall"),
)

LEDGER = (
    Panel(
        "energy_exchanged",
        (("kinetic_energy", "kinetic, change"), ("friction_work", "work of friction")),
        "energy",
        "J",
        "Energy",
        "What the motion loses, and what friction does",
        from_start=True,
    ),
    Panel(
        "energy_stored",
        (
            ("strain_energy", "strain"),
            ("contact_energy", "spring"),
            ("vibration_energy", "vibration"),
            ("damping_work", "damping"),
        ),
        "energy",
        "J",
        "Energy",
        "Strain, contact spring and vibration of the plate, and the work of damping",
    ),
    Panel(
        "energy_error",
        (("energy_error", "error"),),
        "energy",
        "J",
        "Energy",
        "What the energy balance leaves unaccounted for",
    ),
)
