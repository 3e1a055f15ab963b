"""Input files of a scene with a constrained corner for other programs: numbers of the model, and what a program takes.

The texts stand in `templates`. Plates start unstressed with the velocities of the rigid body; masses are those that the
other program makes of density and thickness.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import tailslap
from postprocess.comparison.nodal import NODES
from postprocess.report.page import write_history
from tailslap.errors import InputError

if TYPE_CHECKING:
    from tailslap.case.case import Case
    from tailslap.case.corner.plan import CornerPlan

INCREMENTS = 400
"""Increments to the tail-slap; their ends are the instants of `rigid.csv`."""

BEYOND = 8
"""Increments after the instant at which the rigid body strikes."""

SOLIDS = {3: "C3D6", 4: "C3D8"}
"""Bricks by the number of nodes of a cell of the plate."""

SHELLS = {3: "S3", 4: "S4"}


@dataclass(frozen=True)
class Program:
    """A program that decks are written for.

    Attributes
    ----------
    name : str
        After `--to`.
    title : str
        Its own.
    decks : tuple of str
        Names of the files, which have templates of these names.
    layers : int
        Layers of nodes over the thickness.
    frictional : tuple of str
        Reactions with friction that it can have.
    why : str
        Why it has no others.
    """

    name: str
    title: str
    decks: tuple[str, ...]
    layers: int
    frictional: tuple[str, ...]
    why: str


PROGRAMS = {
    each.name: each
    for each in (
        Program(
            *("calculix", "CalculiX", ("plate.inp",), 2, ()),
            "the corner is held by a boundary condition, which has no friction in CalculiX",
        ),
        Program(
            *("abaqus", "ABAQUS", ("plate.inp", "slide-plane.inp", "contact-pair.inp"), 1, ("drag",)),
            "the friction of a connector is mu |N|",
        ),
    )
}
"""Programs by name."""


@dataclass(frozen=True)
class Deck:
    """Numbers of a deck: the plate in its place at the start, SI.

    Attributes
    ----------
    case : Case
        Of the scene.
    plan : CornerPlan
        Of this program's own run: elements, modulus.
    program : Program
        That it is for.
    """

    case: Any
    plan: CornerPlan
    program: Program

    @cached_property
    def discretisation(self) -> Any:
        """The plate's mesh with linear elements, as all these programs have them."""
        from fem.plate.discretisation import discretise
        from tailslap.case.model import fe_mesh

        mesh = fe_mesh(self.case.scene, self.plan.plate)
        kind = "quad4" if "quad" in mesh.cells_dict else "tri3"
        return discretise(mesh, self.plan.plate.thickness, kind)

    @cached_property
    def places(self) -> np.ndarray:
        """Positions of the nodes of a layer [m], shape (2, nodes)."""
        from fem.start.inertia_relief import to_global

        positions = self.discretisation.positions
        return np.asarray(
            to_global(self.plan.start.angle) @ (positions - positions[:, [self.discretisation.corner]])
        )

    @property
    def velocities(self) -> np.ndarray:
        """Their velocities as of the rigid body [m/s], shape (2, nodes)."""
        x, y = self.places
        start = self.plan.start
        return np.array([start.corner_speed - start.omega * y, start.omega * x])

    @cached_property
    def masses(self) -> np.ndarray:
        """Masses of the nodes of a layer: row sums [kg], shape (nodes,)."""
        from fem.plate.kinds import row_sum_masses

        plate = self.plan.plate
        scalar = self.discretisation.scalar
        return row_sum_masses(scalar, self.density, plate.thickness) / self.program.layers

    @property
    def density(self) -> float:
        """[kg/m^3]."""
        from tailslap.case.model import plate_density

        return plate_density(self.case.scene, self.plan.plate)

    @property
    def step(self) -> float:
        """Increment of time [s]."""
        return float(self.case.duration) / INCREMENTS

    def numbers(self) -> dict[str, Any]:
        """Variables of the templates."""
        from fem.model.plate_model import corner_weights

        plate, scene = self.plan.plate, self.case.scene
        held = corner_weights(self.discretisation, scene.corner.patch_length or 0.0)
        cells = _counter_clockwise(self.discretisation.cells, self.places)
        increments, count = INCREMENTS + BEYOND, self.places.shape[1]
        return {
            "scene": scene.name,
            "version": tailslap.__version__,
            "thickness": plate.thickness,
            "density": self.density,
            "modulus": plate.modulus,
            "ratio": plate.poissons_ratio,
            "friction": scene.corner_friction,
            "nodes": self.places.T.tolist(),
            "velocities": self.velocities.T.tolist(),
            "cells": (cells + 1).tolist(),
            "corner": [
                (node + 1, weight) for node, weight in zip(*map(np.ndarray.tolist, held), strict=True)
            ],
            "layers": [(k * plate.thickness, k * count) for k in range(self.program.layers)],
            "solid": SOLIDS[cells.shape[1]],
            "shell": SHELLS[cells.shape[1]],
            "omega": self.plan.start.omega,
            "side": (self.discretisation.side + 1).tolist(),
            "ground": count + 1,
            "wall": (float(self.places[0].min()) - 1.0, self.case.tail_slap["slide"] + 2.0),
            "step": self.step,
            "increments": increments,
            "end": increments * self.step,
            "strike": self.case.tail_slap,
        }


def _counter_clockwise(cells: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Cells with their nodes counter-clockwise, shape (elements, 3 or 4)."""
    x, y = places[:, cells]
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    return np.where(area[:, None] > 0.0, cells, cells[:, [0, *range(cells.shape[1] - 1, 0, -1)]])


def make_deck(case: Case, program: str) -> Deck:
    """Make the deck of a scene. Raises InputError for a scene that the program cannot have."""
    from tailslap.case.corner.case import CornerCase

    chosen = PROGRAMS[program]
    corner = CornerCase(case.scene, case.source)  # refuses whole impacts
    scene = corner.scene
    reaction = scene.corner.reaction
    if scene.corner_friction and reaction not in chosen.frictional:
        allowed = " or ".join(f'"{name}"' for name in (*chosen.frictional, "none"))
        raise InputError("corner.reaction", reaction, f"{chosen.why}; allowed is {allowed}")
    if scene.corner.patch_length and chosen.layers == 1:
        allowed = "the connector holds one node; remove this key"
        raise InputError("corner.patch_length", scene.corner.patch_length, allowed)
    if scene.material and scene.material.law != "st-venant-kirchhoff":
        allowed = 'decks have linear elasticity at finite rotation; allowed is "st-venant-kirchhoff"'
        raise InputError("material.law", scene.material.law, allowed)
    return Deck(corner, corner.plan(), chosen)


def write_deck(deck: Deck, folder: Path) -> None:
    """Write input files, README, `nodes.csv` with the masses, and the exact motion of the rigid body `rigid.csv`."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("tailslap.exports"),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["number"] = "{:.12g}".format  # at most 19 characters: fields are read up to the 20th
    numbers = deck.numbers()
    for name in (*deck.program.decks, "README.md"):
        text = environment.get_template(f"{deck.program.name}/{name}.j2").render(numbers)
        (folder / name).write_text(text, encoding="utf-8")
    layers = deck.program.layers
    x, y, masses = (np.tile(values, layers) for values in (*deck.places, deck.masses))
    write_history(folder / NODES, {"node": 1 + np.arange(x.size), "x": x, "y": y, "mass": masses})
    write_history(folder / "rigid.csv", deck.case.rigid_history())
