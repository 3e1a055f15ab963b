"""CornerOutcome: a run of a constrained corner beside the rigid motion, and the evidence that it is judged by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fem.laws.friction import FRICTION_LAWS, FrictionLaw
from postprocess.comparison.metrics import Metrics, compare_histories
from tailslap.case.case import Outcome, energy_surplus
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.case.corner.numerical_error import (
    Companion,
    NumericalError,
    friction_by_ringing,
    numerical_error,
)

if TYPE_CHECKING:
    from fem.run.corner import Run

Columns = Mapping[str, np.ndarray]

COMPARED_HISTORIES = ("v_gx", "v_gy", "omega", "theta", "reaction_normal")
"""Histories that are compared with the rigid motion's."""

STORED_ENERGIES = ("kinetic_energy", "strain_energy", "hourglass_energy", "contact_energy")
"""Columns of the energy that the model stores."""


@dataclass(frozen=True)
class CornerOutcome(Outcome):
    """A run of a constrained corner, and the evidence that it is judged by.

    Attributes
    ----------
    rigid_history : dict of str to ndarray, shape (rows,)
        Columns of the rigid motion by name, SI, at the run's instants.
    rigid, fe : dict of str to float
        The five quantities at the tail-slap; `fe`, and `difference`, are empty without a tail-slap.
    companions : tuple of Companion
        Runs on other meshes, by which the numerical error is judged.
    attempts : int
        2 where the first run rang.
    pictures : tuple of Path
        Contour pictures.
    pictures_s : float
        Time that the pictures took [s].
    """

    fe_plan: CornerPlan
    run: Run
    rigid_history: dict[str, np.ndarray]
    rigid: dict[str, float]
    fe: dict[str, float]
    companions: tuple[Companion, ...] = ()
    attempts: int = 1
    pictures: tuple[Path, ...] = ()
    pictures_s: float = 0.0

    @property
    def history(self) -> Columns:
        """The run's history."""
        return self.run.history

    @cached_property
    def fe_history(self) -> dict[str, np.ndarray]:
        """The run's history, and the gap of the energy balance."""
        return self.run.history | {"energy_error": energy_error(self.run.history)}

    @property
    def relieved(self) -> bool:
        """True where the plate starts by inertia relief."""
        return self.fe_plan.plate.relieved

    @property
    def friction(self) -> FrictionLaw:
        """The friction law of the scene."""
        return FRICTION_LAWS[self.fe_plan.case.scene.corner.reaction]

    @cached_property
    def ringing(self) -> float:
        """Friction by ringing at the end of the run; 0 for an unstressed plate, which rings by itself."""
        last = {name: float(column[-1]) for name, column in self.history.items()}
        return friction_by_ringing(self.fe_plan, last) if self.relieved else 0.0

    @cached_property
    def error(self) -> NumericalError:
        """Distance of the run from its own limit of fine meshes."""
        return numerical_error(self.fe_plan, self.difference, self.companions)

    @cached_property
    def metrics(self) -> dict[str, Metrics]:
        """Metrics of each compared history while the rigid solution is known."""
        fe, rigid, known = self.history, self.rigid_history, np.isfinite(self.rigid_history["v_gx"])
        pairs = {name: (fe[name][known], rigid[name][known]) for name in COMPARED_HISTORIES}
        return {name: compare_histories(fe["t"][known], *pair) for name, pair in pairs.items()}

    @cached_property
    def lateral_force(self) -> float:
        """Peak lateral force of the tail-slap [N] by Stage 3, with the plate's speed; NaN without a tail-slap."""
        return self.fe_plan.case.peak_force(self.fe["v_gy"]) if self.fe else float("nan")

    @property
    def by_flexibility(self) -> float:
        """Change of the answer by the plate's flexibility: that of companions, or by statics alone."""
        ratio = self.fe_plan.deflection_ratio
        return max(ratio, self.error.flexibility) if self.companions else ratio


def energy_error(history: Columns) -> np.ndarray:
    """Energy [J] that the balance has too much at each instant, shape (rows,)."""
    return energy_surplus(history, STORED_ENERGIES)
