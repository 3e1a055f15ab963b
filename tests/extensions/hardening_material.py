"""A material from outside, W = U + U^2/c.

U is the energy of linear plane stress and c its first modulus.
"""

from typing import Any, NamedTuple

from fem import MATERIALS, Material
from fem.laws.materials import st_venant_kirchhoff


class Hardening(NamedTuple):
    """Plane-stress constants [Pa]."""

    c_11: float
    c_12: float
    c_33: float


def linear(material: Any, e_11: float, e_22: float, g_12: float) -> tuple[float, float, float, float]:
    s_11 = material.c_11 * e_11 + material.c_12 * e_22
    s_22 = material.c_12 * e_11 + material.c_11 * e_22
    s_12 = material.c_33 * g_12
    return s_11, s_22, s_12, 0.5 * (s_11 * e_11 + s_22 * e_22 + s_12 * g_12)


def stress(material: Any, e_11: float, e_22: float, g_12: float) -> tuple[float, float, float]:
    s_11, s_22, s_12, energy = linear(material, e_11, e_22, g_12)
    factor = 1.0 + 2.0 * energy / material.c_11
    return factor * s_11, factor * s_22, factor * s_12


def energy_density(material: Any, e_11: float, e_22: float, g_12: float) -> float:
    energy = linear(material, e_11, e_22, g_12)[3]
    return energy * (1.0 + energy / material.c_11)


MATERIAL = Material(
    name="hardening",
    constants=Hardening,
    make=lambda youngs_modulus, poissons_ratio: Hardening(
        *st_venant_kirchhoff(youngs_modulus, poissons_ratio)
    ),
    stress=stress,
    energy_density=energy_density,
    text="a plate that hardens",
)
MATERIALS.register(MATERIAL)
