"""Properties of plate, corner, contact, wall and time step.

Choices among registered objects are names.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from fem.laws.contact_forces import PointCrush

if TYPE_CHECKING:
    import meshio


class ModelError(ValueError):
    """No model exists for these properties.

    Parameters
    ----------
    wrong : str
        The property at fault, "elements", "patch_length" or "inertia"; or one of the wall, "wall.length",
        "wall.elements" or "wall.foundation_stiffness"; or one of a trailer by its number, "trailer.0.hitch_length".
        Also an attribute.
    why : str
        The message.
    """

    def __init__(self, wrong: str, why: str) -> None:
        self.wrong = wrong
        super().__init__(why)


@dataclass(frozen=True)
class RigidStart:
    """Motion of the rigid body at t = 0.

    Attributes
    ----------
    angle : float
        Angle of side PE to the wall [rad].
    omega : float
        Angular velocity [rad/s], positive as the rear rotates towards the wall.
    corner_speed : float
        Speed of the corner along the wall [m/s].
    """

    angle: float
    omega: float
    corner_speed: float


@dataclass(frozen=True)
class Inertia:
    """Inertia of a vehicle that is not a uniform rectangle.

    Attributes
    ----------
    centre : float
        Distance of the centre of mass behind the front, on the middle line [m].
    yaw_inertia : float
        Inertia about that centre [kg m^2].
    """

    centre: float
    yaw_inertia: float


@dataclass(frozen=True)
class PlateProperties:
    """Thickness and material of the plate, and choices by name.

    Attributes
    ----------
    thickness : float
        Thickness [m].
    density : float
        Density [kg/m^3].
    youngs_modulus : float
        Young's modulus [Pa].
    poissons_ratio : float
        Poisson's ratio [-].
    lumping : str
        A name of `LUMPINGS`.
    element : str
        A name of `ELEMENT_KINDS`.
    material : str
        A name of `MATERIALS`.
    inertia : Inertia or None
        Prescribed for the nodal masses; None for the plate's own.
    """

    thickness: float
    density: float
    youngs_modulus: float
    poissons_ratio: float
    lumping: str = "exact"
    element: str = "quad4"
    material: str = "st-venant-kirchhoff"
    inertia: Inertia | None = None


@dataclass(frozen=True)
class CornerProperties:
    """Constraint of the corner on the wall.

    Attributes
    ----------
    friction : NamedTuple or None
        Constants of a law of `FRICTION_LAWS`.
    constraint : str
        A name of `CONSTRAINTS`.
    penalty_scale : float
        Multiple of the constraint's usual stiffness [-].
    patch_length : float
        Length of the support patch [m]; 0 for the corner node alone.
    damping_ratio : float
        Damping of the constraint's dashpot over critical damping [-].
    angles : tuple of float
        Angles of the plate during the run [rad] for which the stable time step is computed.
    """

    friction: tuple[float, ...] | None = None
    constraint: str = "penalty"
    penalty_scale: float = 1.0
    patch_length: float = 0.0
    damping_ratio: float = 0.0
    angles: tuple[float, ...] = (0.26, 0.13, 0.0)


class StripProperties(NamedTuple):
    """Point or line along both long sides that the wall can push.

    begin, end: behind the front [m], equal for a point; inset: inwards from the side [m]; law: crush of the point, or
    per metre of the line, with a number in each field.
    """

    begin: float
    end: float
    inset: float
    law: PointCrush


@dataclass(frozen=True)
class ContactProperties:
    """Unilateral contact of the boundary with the wall.

    Attributes
    ----------
    friction : NamedTuple or None
        Constants of a law of `FRICTION_LAWS`.
    law : str
        "crush" for a vehicle that crushes; "penalty" or "exact" for one that does not.
    strips : tuple of StripProperties
        What the wall can push of a vehicle that crushes.
    penalty_scale : float
        Multiple of the stiffness of `unilateral.penalty_stiffness` [-].
    patch_length : float
        Length of the long side over which a point that crushes is distributed [m]; 0 for the point alone.
    """

    friction: tuple[float, ...] | None = None
    law: str = "crush"
    strips: tuple[StripProperties, ...] = ()
    penalty_scale: float = 1.0
    patch_length: float = 0.0


class AxleProperties(NamedTuple):
    """Axle of a unit.

    position: behind the front [m]; load [N]; friction and cornering: coefficients [-].
    """

    position: float
    load: float
    friction: float
    cornering: float


@dataclass(frozen=True)
class UnitProperties:
    """A unit of a train, with the hinge to the unit ahead.

    Attributes
    ----------
    mesh : meshio.Mesh
        Mesh of its plate in its own body frame.
    plate : PlateProperties
        Thickness, modulus, material and element are those of the first unit; the density is its own.
    contact : ContactProperties
        The law and friction are those of the first unit; the crush is its own.
    hitch, kingpin : float
        Distances of the hinge, behind the front of the unit ahead and behind its own front [m]; without meaning for the
        first unit.
    hitch_length : float
        Length of the middle line of both plates over which the hinge is distributed [m]; 0 for a point.
    axles : tuple of AxleProperties
        Axles whose tyres resist sliding across.
    """

    mesh: meshio.Mesh
    plate: PlateProperties
    contact: ContactProperties
    hitch: float = 0.0
    kingpin: float = 0.0
    hitch_length: float = 0.0
    axles: tuple[AxleProperties, ...] = ()


@dataclass(frozen=True)
class WallProperties:
    """A deformable wall with free ends on a continuous foundation.

    Attributes
    ----------
    mesh : meshio.Mesh
        Mesh of quadrilaterals with the group "wall_face": the wall in Y <= 0, its face Y = 0, X counted from the place
        of the first touch. Its elements have nine nodes.
    thickness : float
        Its height above the deck [m].
    density : float
        Density [kg/m^3].
    youngs_modulus : float
        Young's modulus [Pa].
    poissons_ratio : float
        Poisson's ratio [-].
    foundation_stiffness : float
        Force across the wall per length and displacement [N/m per m]. It is the same along the wall, so that friction
        does not displace the wall without limit, and is distributed over the depth in proportion to the mass.
    """

    mesh: meshio.Mesh
    thickness: float
    density: float
    youngs_modulus: float
    poissons_ratio: float
    foundation_stiffness: float


@dataclass(frozen=True)
class StepProperties:
    """Time step and damping of the plate.

    Attributes
    ----------
    safety_factor : float
        Fraction of the stable time step [-].
    longest : float
        Upper bound of the time step [s].
    damping_ratio : float
        Stiffness-proportional damping over critical damping at the highest frequency [-].
    bulk_viscosity : float
        Linear viscosity: coefficient of density x wave speed x element size [-].
    elastic_rate : float
        Rate at which elastic velocities are damped [1/s].
    """

    safety_factor: float = 0.9
    longest: float = math.inf
    damping_ratio: float = 0.0
    bulk_viscosity: float = 0.0
    elastic_rate: float = 0.0
