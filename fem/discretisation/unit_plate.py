"""The plate alone with a Young's modulus of 1 Pa: what many runs share, whose stiffness is in proportion to theirs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem.constitutive.materials import StVenantKirchhoff, st_venant_kirchhoff
from fem.discretisation.element_kinds import ELEMENT_KINDS
from fem.discretisation.elements import Discretisation, Hourglass, discretise, hourglass_control
from fem.discretisation.lumpings import LUMPINGS
from fem.discretisation.mass import given_inertia_masses
from fem.discretisation.properties import PlateProperties
from fem.discretisation.stiffness import hourglass_matrix, stiffness_matrix
from fem.kept import kept
from fem.start.elastic import Inverse

if TYPE_CHECKING:
    import meshio

LARGE = 10_000
"""Nodes from which on a plate is not kept."""


@dataclass(frozen=True, eq=False)
class UnitPlate:
    """The plate of unit modulus.

    Attributes
    ----------
    discretisation : Discretisation
        Nodes and elements.
    masses : ndarray, shape (nodes,)
        [kg].
    hourglass : Hourglass or None
        Control of what one point does not see, its stiffness over the modulus.
    inverse : Inverse
        Of the stiffness, which it holds, over the modulus [m].
    """

    discretisation: Discretisation
    masses: np.ndarray
    hourglass: Hourglass | None
    inverse: Inverse


def unit_plate(mesh: meshio.Mesh, plate: PlateProperties) -> UnitPlate:
    """The plate of these properties but for modulus and material, which it has none of.

    Raises ModelError where the mesh cannot carry the inertia.
    """
    assemble = _assembled if len(mesh.points) < LARGE else _assembled.__wrapped__
    made: UnitPlate = assemble(mesh, replace(plate, youngs_modulus=1.0, material=""))
    return made


@kept("assembly")
def _assembled(mesh: meshio.Mesh, plate: PlateProperties) -> UnitPlate:
    d = discretise(mesh, plate.thickness, plate.element)
    moduli = st_venant_kirchhoff(1.0, plate.poissons_ratio)
    masses = LUMPINGS[plate.lumping].masses(d.scalar, plate.density, plate.thickness)
    if plate.inertia is not None:
        masses = given_inertia_masses(d.positions, masses, plate.inertia)
    stiffness: Any = stiffness_matrix(d.scalar, plate.thickness, moduli)
    hourglass = _hourglass(d, plate, moduli)
    if hourglass is not None:
        stiffness = stiffness + hourglass_matrix(d.table, hourglass, masses.size)
    return UnitPlate(d, masses, hourglass, Inverse(stiffness, masses, d.positions))


def _hourglass(d: Discretisation, plate: PlateProperties, moduli: StVenantKirchhoff) -> Hourglass | None:
    if not ELEMENT_KINDS[plate.element].hourglass:
        return None
    return hourglass_control(d, plate.thickness, moduli)
