"""Materials: stress from strain, in plane stress.

A material is a NamedTuple of its constants and two functions of the Green strain (11, 22, twice 12): `stress`,
the second Piola-Kirchhoff stress [Pa] (11, 22, 12), and `energy_density` [J/m^3]. They are registered for the
tuple with `implements` and chosen by its type when the loop is compiled.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from fem.compiled import compiled, implements


class StVenantKirchhoff(NamedTuple):
    """Linear between Green strain and second Piola-Kirchhoff stress: large rotation, small strain.

    Plane-stress constants [Pa]. It softens without bound in compression: not for strains above a few per cent.
    """

    c_11: float
    c_12: float
    c_33: float


class NeoHookean(NamedTuple):
    """W = mu/2 (tr C - 3 - 2 ln J) + lambda/2 (ln J)^2, the stretch of the thickness free; Lamé constants [Pa]."""

    lame: float
    shear: float


def st_venant_kirchhoff(youngs_modulus: float, poissons_ratio: float) -> StVenantKirchhoff:
    """Plane-stress constants [Pa] from Young's modulus [Pa] and Poisson's ratio."""
    c_11 = youngs_modulus / (1.0 - poissons_ratio**2)
    return StVenantKirchhoff(c_11, poissons_ratio * c_11, 0.5 * youngs_modulus / (1.0 + poissons_ratio))


def neo_hookean(youngs_modulus: float, poissons_ratio: float) -> NeoHookean:
    """Lamé constants [Pa] from Young's modulus [Pa] and Poisson's ratio."""
    shear = 0.5 * youngs_modulus / (1.0 + poissons_ratio)
    return NeoHookean(2.0 * shear * poissons_ratio / (1.0 - 2.0 * poissons_ratio), shear)


MATERIALS = {"st-venant-kirchhoff": st_venant_kirchhoff, "neo-hookean": neo_hookean}
"""Materials by name, made from Young's modulus and Poisson's ratio; all are linear elastic at small strain."""


def stress(material: Any, e_11: float, e_22: float, g_12: float) -> tuple[float, float, float]:
    """Second Piola-Kirchhoff stress of any material above; compiled code only."""
    raise NotImplementedError(type(material))


def energy_density(material: Any, e_11: float, e_22: float, g_12: float) -> float:
    """Strain energy per reference volume of any material above; compiled code only."""
    raise NotImplementedError(type(material))


@implements(stress, StVenantKirchhoff, inline="always")
def _st_venant_kirchhoff_stress(material, e_11, e_22, g_12):
    return (
        material.c_11 * e_11 + material.c_12 * e_22,
        material.c_12 * e_11 + material.c_11 * e_22,
        material.c_33 * g_12,
    )


@implements(energy_density, StVenantKirchhoff)
def _st_venant_kirchhoff_energy(material, e_11, e_22, g_12):
    s_11, s_22, s_12 = stress(material, e_11, e_22, g_12)
    return 0.5 * (s_11 * e_11 + s_22 * e_22 + s_12 * g_12)


@compiled
def logarithms(lame, shear, area):
    """ln det C in the plane and ln C_33, from det C - 1 and S_33 = 0: 2 mu (C_33 - 1) + lambda ln(det C C_33) = 0.

    Newton from the linear answer; the function is convex and rising, five steps reach rounding for det C from
    0.2 to 20. Written with log1p and expm1, so that small strains keep their digits.
    """
    plane = math.log1p(area)
    thickness = -lame / (lame + 2.0 * shear) * plane
    for _ in range(5):
        residual = 2.0 * shear * math.expm1(thickness) + lame * (plane + thickness)
        thickness -= residual / (2.0 * shear * math.exp(thickness) + lame)
    return plane, thickness


@implements(stress, NeoHookean)
def _neo_hookean_stress(material, e_11, e_22, g_12):
    area = 2.0 * (e_11 + e_22) + 4.0 * e_11 * e_22 - g_12 * g_12
    plane, thickness = logarithms(material.lame, material.shear, area)
    volume = 0.5 * material.lame * (plane + thickness)
    scale = 1.0 / (1.0 + area)
    # S = mu (1 - C^-1) + lambda ln J C^-1, the first part written as mu C^-1 (C - 1).
    return (
        scale * (material.shear * (area - 2.0 * e_22) + volume * (1.0 + 2.0 * e_22)),
        scale * (material.shear * (area - 2.0 * e_11) + volume * (1.0 + 2.0 * e_11)),
        scale * g_12 * (material.shear - volume),
    )


@implements(energy_density, NeoHookean)
def _neo_hookean_energy(material, e_11, e_22, g_12):
    area = 2.0 * (e_11 + e_22) + 4.0 * e_11 * e_22 - g_12 * g_12
    plane, thickness = logarithms(material.lame, material.shear, area)
    volume = plane + thickness
    shear = material.shear * (2.0 * (e_11 + e_22) + math.expm1(thickness) - volume)
    return 0.5 * shear + 0.125 * material.lame * volume * volume
