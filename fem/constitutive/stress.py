"""Stress and energy density of any material, as the compiled loops call them."""

from __future__ import annotations

from typing import Any

from fem.compiled import by_law
from fem.constitutive.materials import MATERIALS


@by_law(MATERIALS, "stress")
def stress(material: Any, e_11: float, e_22: float, g_12: float) -> tuple[float, float, float]:
    """Second Piola-Kirchhoff stress [Pa] (11, 22, 12) of Green strain (11, 22, twice 12); compiled code only."""
    raise NotImplementedError(type(material))


@by_law(MATERIALS, "energy_density")
def energy_density(material: Any, e_11: float, e_22: float, g_12: float) -> float:
    """Strain energy per reference volume [J/m^3] of the same strain; compiled code only."""
    raise NotImplementedError(type(material))
