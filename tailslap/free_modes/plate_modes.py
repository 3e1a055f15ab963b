"""The modes of a scene's plate, what kind each is, and what beam theory says of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fem.modal.beam_theory import (
    Beam,
    euler_bernoulli_frequencies,
    longitudinal_frequencies,
    timoshenko_frequencies,
)
from fem.modal.mode_kinds import mode_kinds
from fem.modal.modes import FreeModes, free_modes, most_modes
from tailslap.errors import InputError
from tailslap.planning.fe_model import plate_density
from tailslap.planning.fe_plan import FePlan

BENDING = ("bending", "shear")
"""Kinds that bend the plate as a beam; they are numbered together, as Timoshenko's frequencies are."""


@dataclass(frozen=True)
class Mode:
    """An elastic mode: number from 1, frequency [Hz], kind, number among its like.

    The shares of energy that make it that kind (`mode_kinds`). theory, slender [Hz]: beam theory with shear and
    rotary inertia, and without; for longitudinal modes `theory` is n c / (2 L). None: no beam does that.
    """

    number: int
    frequency: float
    kind: str
    order: int
    symmetric: float
    along: float
    shear: float
    theory: float | None
    slender: float | None

    @property
    def name(self) -> str:
        """Kind and number among its like: "bending 2"."""
        return f"{self.kind} {self.order}"

    @property
    def difference(self) -> float | None:
        """Frequency over theory - 1."""
        return None if self.theory is None else self.frequency / self.theory - 1.0


@dataclass(frozen=True)
class PlateModes:
    """The modes in rising frequency; shapes as in `fem.modal.modes.FreeModes`; the beam they are compared with."""

    fe_plan: FePlan
    found: FreeModes
    modes: tuple[Mode, ...]
    beam: Beam


def find_modes(fe_plan: FePlan, count: int) -> PlateModes:
    """The lowest `count` elastic modes. Raises InputError for a number that the mesh does not have."""
    model, plate, vehicle = fe_plan.model, fe_plan.plate, fe_plan.plan.scene.vehicle
    most = most_modes(model.loop.mass.size)
    if not 1 <= count <= most:
        raise InputError("--count", count, f"allowed with this mesh is a whole number from 1 to {most}")
    found = free_modes(model, count)
    density = plate_density(fe_plan.plan.scene, plate)
    beam = Beam(vehicle.length, vehicle.width, plate.modulus, plate.poissons_ratio, density)
    return PlateModes(fe_plan, found, tuple(_modes(fe_plan, found, beam)), beam)


def _modes(fe_plan: FePlan, found: FreeModes, beam: Beam) -> Iterator[Mode]:
    count = found.frequencies.size
    kinds = mode_kinds(fe_plan.model, found, fe_plan.plate.thickness)
    bending = zip(timoshenko_frequencies(beam, count), euler_bernoulli_frequencies(beam, count), strict=True)
    pulled = ((frequency, None) for frequency in longitudinal_frequencies(beam, count))
    seen = {"beam": 0, "longitudinal": 0, "transverse": 0}
    for i, (frequency, kind) in enumerate(zip(found.frequencies, kinds.names, strict=True)):
        family = "beam" if kind in BENDING else kind
        seen[family] += 1
        theory: tuple[float | None, float | None] = (None, None)
        if family != "transverse":
            theory = next(bending if family == "beam" else pulled)
        yield Mode(
            i + 1,
            float(frequency) / (2.0 * math.pi),
            kind,
            seen[family],
            *(float(share[i]) for share in (kinds.symmetric, kinds.along, kinds.shear)),
            *(None if value is None else float(value) for value in theory),
        )


def drawn_shape(found: PlateModes, mode: Mode) -> np.ndarray:
    """Displacements of the elements' corner nodes, the largest of length one, shape (nodes, 2)."""
    corners = int(found.fe_plan.model.discretisation.cells.max()) + 1
    shape = found.found.shapes[mode.number - 1, :, :corners].T
    return np.asarray(shape / np.hypot(*shape.T).max())
