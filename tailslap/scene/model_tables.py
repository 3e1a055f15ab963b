"""Define the tables of a scene on plate, wall and run."""

from typing import Annotated, Literal

from pydantic import Field

from fem.start import start_kinds
from tailslap.scene import types
from tailslap.scene.types import SceneTable, key, needed


class Plate(SceneTable):
    """FE model of the vehicle as a plate in plane stress.

    Either youngs_modulus or first_frequency defines its stiffness.
    """

    thickness: types.Length = needed("thickness of the plate")
    density: types.Density | None = key(
        "density of the plate; default: mass of the vehicle over the volume of the plate"
    )
    youngs_modulus: types.Modulus | None = key("Young's modulus; required unless first_frequency is given")
    first_frequency: types.Frequency | None = key(
        "lowest natural frequency of the free plate in its plane; required unless youngs_modulus is given"
    )
    poissons_ratio: types.PoissonsRatio = needed("Poisson's ratio")
    elements: types.ElementCounts | None = key("number of elements along and across; default: automatic")
    element: types.ElementName = key("element type", "quad4")
    distortion: types.Distortion = key("distortion of the mesh, as a fraction of the element size", 0.0)
    lumping: types.LumpingName = key("mass lumping", "exact")
    start: types.StartName = key("elastic state at t = 0", "inertia-relief")

    @property
    def counts(self) -> tuple[int, int]:
        """Numbers of elements along and across.

        Raises ValueError before they are selected.
        """
        if self.elements is None:
            raise ValueError("the elements are not chosen yet")
        return self.elements

    @property
    def modulus(self) -> float:
        """Young's modulus [Pa].

        Raises ValueError before it follows from the first frequency.
        """
        if self.youngs_modulus is None:
            raise ValueError("the modulus is not resolved yet")
        return self.youngs_modulus

    @property
    def relieved(self) -> bool:
        """True if the start is by inertia relief."""
        return start_kinds.START_KINDS[self.start].relieved


class MaterialTable(SceneTable):
    """Material law of the plate.

    Young's modulus and Poisson's ratio are keys of [plate].
    """

    law: types.MaterialName = needed("material law of the plate")


class Damping(SceneTable):
    """Damping of the plate.

    By default the program selects it.
    """

    kind: Literal["elastic-velocity", "none"] | None = key(
        "damping of the elastic velocities; default: automatic"
    )
    rate: types.Rate | None = key("rate c of the damping of the elastic velocities")
    ratio: types.DampingRatio | None = key(
        "stiffness-proportional damping: damping ratio at the highest natural frequency"
    )
    bulk_viscosity: types.Viscosity | None = key("coefficient of linear bulk viscosity")


class Verify(SceneTable):
    """Limits on the result, and companion runs.

    Companion runs repeat a run on other meshes; the numerical error is estimated from them.
    """

    tolerance: types.Tolerance | None = key(
        "largest allowed difference from the rigid-body motion, constrained corners only"
    )
    mesh: types.Tolerance = key(
        "largest allowed numerical error of peak force, impulse, 50 ms mean and duration, whole impacts only",
        0.02,
    )
    companion: types.Flag = key("estimate the numerical error by companion runs", True)


class Time(SceneTable):
    """Time integration and history."""

    safety_factor: types.Fraction = key("time step divided by the critical time step", 0.9)
    rows: Annotated[int, Field(ge=10, le=1_000_000, strict=True)] = key("number of rows of the history", 400)
    threads: Annotated[int, Field(ge=1, le=256, strict=True)] = key("number of threads of the time loop", 1)
    end: types.EndOfImpact | None = key(
        "end time of a whole impact; default: 0.1 s after the second strike, or the end of a strike then in progress"
    )


class Output(SceneTable):
    """Additional output of a run."""

    fields: Annotated[int, Field(ge=1, le=10_000, strict=True)] = needed(
        "number of instants at which displacement, velocity and stress of the plate are stored"
    )


class Wall(SceneTable):
    """Wall with its mesh, its elasticity or its profile.

    In a whole impact a wall with a mesh is elastic, on an elastic foundation. The default material is the concrete of
    the paper (Table 2). With [body] the wall is rigid and has height and profile only.
    """

    length: types.Length | None = key("length of the wall; required without [body]")
    depth: types.Length | None = key("depth of the wall; required without [body]")
    elements: types.ElementCounts | None = key("number of elements along and across; required without [body]")
    height: types.Length | None = key("height of the elastic wall, or with [body] of any wall")
    profile: types.Profile | None = key(
        "profile with [body], by name or as points [y, z] from [0, 0] upwards; default: vertical"
    )
    foundation_stiffness: types.LayerStiffness | None = key(
        "stiffness of the foundation per length of the elastic wall"
    )
    density: types.Density = key("density of the wall", 2400.0)
    youngs_modulus: types.Modulus = key("Young's modulus of the wall", 24.82e9)
    poissons_ratio: types.PoissonsRatio = key("Poisson's ratio of the wall", 0.18)

    @property
    def mesh(self) -> tuple[float, float, tuple[int, int]]:
        """Length, depth and element counts of the mesh.

        Raises ValueError for a wall without mesh.
        """
        if self.length is None or self.depth is None or self.elements is None:
            raise ValueError("the wall has no mesh")
        return self.length, self.depth, self.elements


class ParapetSection(SceneTable):
    """Reinforced section of the parapet, in place of its strengths.

    Areas of bars are those of the traffic face and of the back.
    """

    thickness: types.Thickness = needed("thickness of the wall, or pairs [height, thickness]")
    concrete_strength: types.Modulus = needed("compressive strength of the concrete")
    yield_strength: types.Modulus = needed("yield strength of the bars")
    cover: types.Length = needed("distance of the axes of the bars from their face")
    vertical_bars: types.Bars = needed("area of upright bars per length of wall")
    horizontal_bars: types.Bars = needed("area of longitudinal bars per height")


class Parapet(SceneTable):
    """Strength of the wall as a plate fixed at the deck.

    Either [parapet.section] or wall_strength and base_strength define it.
    """

    height: types.Length = needed("height of the parapet above the deck")
    length: types.Length | None = key("length of the wall between ends or joints; default: long")
    end_distance: types.Level | None = key(
        "distance from the nearer end or joint to the loaded length; default: middle and end of the wall"
    )
    beam_strength: types.BeamMoment = key("strength M_b of a beam at the top beside the wall", 0.0)
    wall_strength: types.Moment | None = key("strength M_w about the vertical axis, over the height")
    base_strength: types.LineMoment | None = key(
        "strength M_c about the longitudinal axis per length, one value or pairs [height, value]"
    )
    load_length: types.Length | None = key("length L_t of the load; default: that of impact.test_level")
    load_height: types.Length | None = key("height of the load; default: the top")
    section: ParapetSection | None = key("reinforced section, in place of the strengths")
