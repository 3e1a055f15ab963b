"""Write input files for other programs.

They are of scenes with a constrained corner, by the texts in `templates`. Plates start unstressed with the velocities
of the rigid body; masses are those that the other program computes from density and thickness.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import tailslap
from postprocess.comparison.nodal import NODES
from postprocess.report.data_files import write_history
from tailslap.errors import InputError, typed_command
from tailslap.scene.vary import shown

if TYPE_CHECKING:
    from fem.plate.discretisation import Discretisation
    from tailslap.case.case import Case
    from tailslap.case.corner.corner_case import CornerCase
    from tailslap.case.corner.corner_plan import CornerPlan

INCREMENTS = 400
"""Increments to the tail-slap; their ends are the instants of `rigid.csv`."""

BEYOND = 8
"""Increments after the tail-slap of the rigid body."""

DECKS = {
    "calculix": ("plate.inp", "README.md"),
    "abaqus": ("plate.inp", "slide-plane.inp", "contact-pair.inp", "README.md"),
}
"""Files of each program, which have templates of these names."""

FRICTION = {
    "calculix": ((), "the corner is held by a boundary condition, which has no friction in CalculiX"),
    "abaqus": (("drag",), "the friction of a connector is mu |N|"),
}
"""Reactions with friction that a program supports, and why not all."""

LAYERS = {"calculix": 2, "abaqus": 1}
"""Layers of nodes over the thickness: of bricks, of shells."""


@dataclass(frozen=True)
class Deck:
    """Plate of a scene for another program.

    It is in its position at the start.

    Attributes
    ----------
    program : str
        A key of `DECKS`.
    case : CornerCase
        Of the scene.
    plan : CornerPlan
        Of the run of this program: elements, modulus.
    density : float
        [kg/m^3].
    discretisation : Discretisation
        Nodes and elements, in the body frame.
    places, velocities : ndarray, shape (2, nodes)
        Of the nodes of a layer, as of the rigid body [m], [m/s].
    """

    program: str
    case: CornerCase
    plan: CornerPlan
    density: float
    discretisation: Discretisation
    places: np.ndarray
    velocities: np.ndarray


def make_deck(case: Case, program: str) -> Deck:
    """Make the deck of a scene.

    Raises InputError for a scene that the program does not support.
    """
    from fem.plate.discretisation import discretise
    from fem.start.inertia_relief import to_global
    from tailslap.case.corner.corner_case import CornerCase
    from tailslap.case.plate_input import fe_mesh, plate_density

    corner = CornerCase(case.scene, case.source)  # refuses whole impacts
    _demand_possible(corner, program)
    plan = corner.plan()
    mesh, start = fe_mesh(corner.scene, plan.plate), plan.start
    linear = "quad4" if "quad" in mesh.cells_dict else "tri3"
    d = discretise(mesh, plan.plate.thickness, linear)
    x, y = to_global(start.angle) @ (d.positions - d.positions[:, [d.corner]])
    velocities = np.array([start.corner_speed - start.omega * y, start.omega * x])
    density = plate_density(corner.scene, plan.plate)
    return Deck(program, corner, plan, density, d, np.array([x, y]), velocities)


def _demand_possible(case: Case, program: str) -> None:
    """Raise InputError for a scene that the program does not support."""
    scene, corner, (frictional, why) = case.scene, case.scene.corner, FRICTION[program]
    if scene.corner_friction and corner.reaction not in frictional:
        allowed = " or ".join(f'"{name}"' for name in (*frictional, "none"))
        needed: dict[str, str | None] = {"corner.reaction": "none"}
        if corner.friction is not None and "corner.friction" not in case.source.changed:
            needed["corner.friction"] = None
        command = typed_command(*(part for change in shown(needed) for part in ("--set", change)))
        instead = command or f"changes={needed}"
        raise InputError("corner.reaction", corner.reaction, f"{why}; allowed is {allowed}: {instead}")
    if corner.patch_length and program == "abaqus":
        raise InputError(
            "corner.patch_length", corner.patch_length, "the connector holds one node; remove this key"
        )
    if scene.material and scene.material.law != "st-venant-kirchhoff":
        allowed = 'decks have linear elasticity at finite rotation; allowed is "st-venant-kirchhoff"'
        raise InputError("material.law", scene.material.law, allowed)


def write_deck(deck: Deck, folder: Path) -> None:
    """Write all files of a deck.

    They are input files, README, masses of the nodes in `nodes.csv`, and the motion of the rigid body in `rigid.csv`.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    from fem.plate.nodal_masses import row_sum_masses

    loader = PackageLoader("tailslap.exports")
    environment = Environment(
        loader=loader, undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True
    )
    environment.filters["number"] = "{:.12g}".format  # at most 19 characters: fields are read up to the 20th
    numbers, layers = _numbers(deck), LAYERS[deck.program]
    for name in DECKS[deck.program]:
        text = environment.get_template(f"{deck.program}/{name}.j2").render(numbers)
        (folder / name).write_text(text, encoding="utf-8")
    masses = row_sum_masses(deck.discretisation.scalar, deck.density, deck.plan.plate.thickness) / layers
    x, y, masses = (np.tile(values, layers) for values in (*deck.places, masses))
    write_history(folder / NODES, {"node": 1 + np.arange(x.size), "x": x, "y": y, "mass": masses})
    write_history(folder / "rigid.csv", deck.case.rigid_history())


def _numbers(deck: Deck) -> dict[str, object]:
    """Return the variables of the templates.

    Nodes are counted from 1.
    """
    from fem.plate.discretisation import corner_weights

    d, case = deck.discretisation, deck.case
    nodes, weights = corner_weights(d, case.scene.corner.patch_length or 0.0)
    return {
        "version": tailslap.__version__,
        "scene": case.scene,
        "plate": deck.plan.plate,
        "start": deck.plan.start,
        "strike": case.tail_slap,
        "density": deck.density,
        "nodes": deck.places.T.tolist(),
        "velocities": deck.velocities.T.tolist(),
        "cells": (1 + d.cells).tolist(),
        "corner": list(zip((1 + nodes).tolist(), weights.tolist(), strict=True)),
        "side": (1 + d.side).tolist(),
        "step": case.duration / INCREMENTS,
        "increments": INCREMENTS + BEYOND,
    }
