"""Materials: stress from strain, in plane stress.

A material is a NamedTuple of its constants and two functions of the Green strain (11, 22, twice 12): `stress`,
the second Piola-Kirchhoff stress [Pa] (11, 22, 12), and `energy_density` [J/m^3]. They are registered for the
tuple with `overload` and chosen by its type when the loop is compiled.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import types
from numba.extending import overload


class StVenantKirchhoff(NamedTuple):
    """Linear between Green strain and second Piola-Kirchhoff stress: large rotation, small strain."""

    c_11: float
    c_12: float
    c_33: float


def st_venant_kirchhoff(youngs_modulus: float, poissons_ratio: float) -> StVenantKirchhoff:
    """Plane-stress constants [Pa] from Young's modulus [Pa] and Poisson's ratio."""
    c_11 = youngs_modulus / (1.0 - poissons_ratio**2)
    return StVenantKirchhoff(c_11, poissons_ratio * c_11, 0.5 * youngs_modulus / (1.0 + poissons_ratio))


def stress(material: Any, e_11: float, e_22: float, g_12: float) -> tuple[float, float, float]:
    """Second Piola-Kirchhoff stress of any material above; compiled code only."""
    raise NotImplementedError(type(material))


def energy_density(material: Any, e_11: float, e_22: float, g_12: float) -> float:
    """Strain energy per reference volume of any material above; compiled code only."""
    raise NotImplementedError(type(material))


def _is(material: Any, kind: type) -> bool:
    return isinstance(material, types.BaseNamedTuple) and material.instance_class is kind


@overload(stress, inline="always")
def _st_venant_kirchhoff_stress(material: Any, e_11: Any, e_22: Any, g_12: Any) -> Any:
    if not _is(material, StVenantKirchhoff):
        return None

    def law(material: Any, e_11: Any, e_22: Any, g_12: Any) -> Any:
        return (
            material.c_11 * e_11 + material.c_12 * e_22,
            material.c_12 * e_11 + material.c_11 * e_22,
            material.c_33 * g_12,
        )

    return law


@overload(energy_density)
def _st_venant_kirchhoff_energy(material: Any, e_11: Any, e_22: Any, g_12: Any) -> Any:
    if not _is(material, StVenantKirchhoff):
        return None

    def law(material: Any, e_11: Any, e_22: Any, g_12: Any) -> Any:
        s_11, s_22, s_12 = stress(material, e_11, e_22, g_12)
        return 0.5 * (s_11 * e_11 + s_22 * e_22 + s_12 * g_12)

    return law
