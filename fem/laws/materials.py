"""Stress and energy of materials in plane stress.

Each is one object, registered here or in any other file.

Kernels are functions of the constants and the Green strain (11, 22, twice 12), which comes from the positions of an
element's nodes. All materials are linear elastic at small strain. `stress` and `energy_density` are those of any
material, as the compiled loops call them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from fem.registry import Law, LawRegistry
from machine_code.compiled import by_law, inlined

MATERIALS: "LawRegistry[Material]" = LawRegistry("material")
"""Materials by their names in a scene."""


@inlined
def green_strain(f_11, f_12, f_21, f_22):
    """Return the Green strain (11, 22, twice 12)."""
    return (
        0.5 * (f_11 * f_11 + f_21 * f_21 - 1.0),
        0.5 * (f_12 * f_12 + f_22 * f_22 - 1.0),
        f_11 * f_12 + f_21 * f_22,
    )


@dataclass(frozen=True, kw_only=True)
class Material(Law):
    """Material of the plate.

    Strains are Green's, 11, 22 and twice 12.

    Attributes
    ----------
    make : callable
        Constants from Young's modulus [Pa] and Poisson's ratio.
    stress : callable
        Kernel (constants, e_11, e_22, g_12) -> second Piola-Kirchhoff stress [Pa], 11, 22 and 12.
    energy_density : callable
        Kernel of the same arguments -> energy per reference volume [J/m^3].
    text : str
        Description for reports.
    nanoseconds : float
        Time of a stress at a point, beyond that of the linear law [ns].
    """

    make: Callable[[float, float], Any]
    stress: Callable[[Any, float, float, float], tuple[float, float, float]]
    energy_density: Callable[[Any, float, float, float], float]
    text: str
    nanoseconds: float = 0.0


class StVenantKirchhoff(NamedTuple):
    """Linear law of Green strain and second Piola-Kirchhoff stress.

    Plane-stress constants [Pa], for large rotation and small strain. It softens without bound in compression: not for
    strains above a few per cent.
    """

    c_11: float
    c_12: float
    c_33: float


def st_venant_kirchhoff(youngs_modulus: float, poissons_ratio: float) -> StVenantKirchhoff:
    """Return the plane-stress constants [Pa] of these moduli."""
    c_11 = youngs_modulus / (1.0 - poissons_ratio**2)
    return StVenantKirchhoff(c_11, poissons_ratio * c_11, 0.5 * youngs_modulus / (1.0 + poissons_ratio))


def _linear_stress(
    material: StVenantKirchhoff, e_11: float, e_22: float, g_12: float
) -> tuple[float, float, float]:
    return (
        material.c_11 * e_11 + material.c_12 * e_22,
        material.c_12 * e_11 + material.c_11 * e_22,
        material.c_33 * g_12,
    )


def _quadratic_energy(material: StVenantKirchhoff, e_11: float, e_22: float, g_12: float) -> float:
    s_11, s_22, s_12 = _linear_stress(material, e_11, e_22, g_12)
    return 0.5 * (s_11 * e_11 + s_22 * e_22 + s_12 * g_12)


MATERIALS.register(
    Material(
        name="st-venant-kirchhoff",
        constants=StVenantKirchhoff,
        make=st_venant_kirchhoff,
        stress=_linear_stress,
        energy_density=_quadratic_energy,
        text="St. Venant-Kirchhoff, linear between Green strain and second Piola-Kirchhoff stress",
        inlined=("stress", "energy_density"),
    )
)


class NeoHookean(NamedTuple):
    """Neo-Hookean material in plane stress, by its Lamé constants [Pa].

    W = mu/2 (tr C - 3 - 2 ln J) + lambda/2 (ln J)^2; the stretch of the thickness is free.
    """

    lame: float
    shear: float


def neo_hookean(youngs_modulus: float, poissons_ratio: float) -> NeoHookean:
    """Return the Lamé constants [Pa] of these moduli."""
    shear = 0.5 * youngs_modulus / (1.0 + poissons_ratio)
    return NeoHookean(2.0 * shear * poissons_ratio / (1.0 - 2.0 * poissons_ratio), shear)


COEFFICIENTS = tuple(1.0 / math.factorial(power) for power in range(13, 0, -1))
"""Taylor's series of (exp(x) - 1) / x, the highest power first."""


@inlined
def _volume_logarithm(ratio, area):
    """Return v = 2 ln J of the free thickness.

    ratio: lambda / (2 mu). area: det C - 1 in the plane. S_33 = 0 requires C_33 = 1 - ratio v, thus
    f(v) = exp(v) - (1 + area) (1 - ratio v) = 0, which is convex and rising. Householder's method of fourth order from
    v = 0 is exact to rounding after three steps for det C from 0.2 to 20. There are no branches and no calls, so that
    it is computed in vector instructions; small strains keep their digits.
    """
    v = _householder(ratio, area, 0.0, 0.0)
    v = _householder(ratio, area, v, _exponential(v))
    return _householder(ratio, area, v, _exponential(v))


@inlined
def _householder(ratio, area, v, grown):
    """Return the next v, where grown = exp(v) - 1."""
    linear = ratio * (1.0 + area)
    f, slope, curvature = grown - area + linear * v, 1.0 + grown + linear, 1.0 + grown
    square, product = slope * slope, f * curvature
    return v - f * (6.0 * square - 3.0 * product) / (slope * (6.0 * square - 6.0 * product) + f * product)


@inlined
def _exponential(v):
    """Return exp(v) - 1 by Taylor's series, for |v| below 3.

    It is evaluated at v / 8, and its argument doubled three times.
    """
    x = 0.125 * v
    series = 0.0
    for coefficient in COEFFICIENTS:
        series = series * x + coefficient
    grown = series * x
    grown *= 2.0 + grown
    grown *= 2.0 + grown
    return grown * (2.0 + grown)


def _neo_hookean_stress(
    material: NeoHookean, e_11: float, e_22: float, g_12: float
) -> tuple[float, float, float]:
    area = 2.0 * (e_11 + e_22) + 4.0 * e_11 * e_22 - g_12 * g_12
    volume = 0.5 * material.lame * _volume_logarithm(0.5 * material.lame / material.shear, area)
    scale = 1.0 / (1.0 + area)
    # S = mu (1 - C^-1) + lambda ln J C^-1, the first part written as mu C^-1 (C - 1).
    return (
        scale * (material.shear * (area - 2.0 * e_22) + volume * (1.0 + 2.0 * e_22)),
        scale * (material.shear * (area - 2.0 * e_11) + volume * (1.0 + 2.0 * e_11)),
        scale * g_12 * (material.shear - volume),
    )


def _neo_hookean_energy(material: NeoHookean, e_11: float, e_22: float, g_12: float) -> float:
    area = 2.0 * (e_11 + e_22) + 4.0 * e_11 * e_22 - g_12 * g_12
    ratio = 0.5 * material.lame / material.shear
    v = _volume_logarithm(ratio, area)
    return 0.5 * material.shear * (2.0 * (e_11 + e_22) - (ratio + 1.0) * v) + 0.125 * material.lame * v * v


MATERIALS.register(
    Material(
        name="neo-hookean",
        constants=NeoHookean,
        make=neo_hookean,
        stress=_neo_hookean_stress,
        energy_density=_neo_hookean_energy,
        text="neo-Hookean, plane stress",
        nanoseconds=7.5,
        inlined=("stress", "energy_density"),
    )
)


stress = by_law(MATERIALS, "stress")
"""Second Piola-Kirchhoff stress [Pa] (11, 22, 12) of constants and Green strain (11, 22, twice 12)."""

energy_density = by_law(MATERIALS, "energy_density")
"""Strain energy per reference volume [J/m^3] of the same arguments."""
