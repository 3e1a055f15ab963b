"""Outcome of a run of a constrained corner."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fem.laws.friction import FRICTION_LAWS, FrictionLaw
from postprocess.comparison.metrics import Metrics, compare_histories
from tailslap.case.case import Outcome
from tailslap.case.check import energy_surplus
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.case.corner.numerical_error import (
    Companion,
    NumericalError,
    friction_by_ringing,
    numerical_error,
)

if TYPE_CHECKING:
    from fem.run.corner import Run

Columns = Mapping[str, NDArray[np.float64]]

COMPARED_HISTORIES = ("v_gx", "v_gy", "omega", "theta", "reaction_normal")
"""Columns that are compared with the rigid motion."""

STORED_ENERGIES = ("kinetic_energy", "strain_energy", "hourglass_energy", "contact_energy")
"""Columns of the energy that the model stores."""


@dataclass(frozen=True)
class CornerOutcome(Outcome):
    """A run of a constrained corner beside the rigid motion.

    Attributes
    ----------
    rigid_history : dict of str to ndarray, shape (rows,)
        Rigid motion by column at the instants of the run, SI.
    rigid, fe : dict of str to float
        The five quantities at the tail-slap; `fe` and `difference` are empty without a tail-slap.
    companions : tuple of Companion
        Runs on other meshes, by which the numerical error is estimated.
    attempts : int
        2 where the first run oscillated.
    pictures : tuple of Path
        Contour pictures.
    pictures_s : float
        Time for the pictures [s].
    """

    fe_plan: CornerPlan
    run: Run
    rigid_history: dict[str, NDArray[np.float64]]
    rigid: dict[str, float]
    fe: dict[str, float]
    companions: tuple[Companion, ...] = ()
    attempts: int = 1
    pictures: tuple[Path, ...] = ()
    pictures_s: float = 0.0

    @property
    def history(self) -> Columns:
        """History of the run."""
        return self.run.history

    @cached_property
    def fe_history(self) -> dict[str, NDArray[np.float64]]:
        """History of the run with the error of the energy balance."""
        return self.run.history | {"energy_error": energy_error(self.run.history)}

    @property
    def relieved(self) -> bool:
        """True if the plate starts by inertia relief."""
        return self.fe_plan.plate.relieved

    @property
    def friction(self) -> FrictionLaw:
        """Friction law of the scene."""
        return FRICTION_LAWS[self.fe_plan.case.scene.corner.reaction]

    @property
    def ringing(self) -> float:
        """Effect of friction by an oscillating reaction, at the end.

        It is 0 for an unstressed start, which oscillates in any case.
        """
        return self.rectified if self.relieved else 0.0

    @cached_property
    def rectified(self) -> float:
        """Effect of friction by an oscillating reaction after any start."""
        return friction_by_ringing(self.fe_plan, {k: float(column[-1]) for k, column in self.history.items()})

    @cached_property
    def error(self) -> NumericalError:
        """Numerical error of the run."""
        return numerical_error(self.fe_plan, self.difference, self.companions)

    @property
    def stated_error(self) -> float:
        """Largest relative error of the five quantities, NaN without a tail-slap."""
        return self.error.total if self.fe else float("nan")

    @cached_property
    def metrics(self) -> dict[str, Metrics]:
        """Metrics of the compared histories while the rigid motion lasts."""
        fe, rigid, rows = self.history, self.rigid_history, np.isfinite(self.rigid_history["v_gx"])
        pairs = {name: (fe[name][rows], rigid[name][rows]) for name in COMPARED_HISTORIES}
        return {name: compare_histories(fe["t"][rows], *pair) for name, pair in pairs.items()}

    @cached_property
    def lateral_force(self) -> float:
        """Peak lateral force of the tail-slap by Stage 3 [N].

        It has the speed of the plate. NaN without a tail-slap.
        """
        return self.fe_plan.case.peak_force(self.fe["v_gy"]) if self.fe else float("nan")

    @property
    def mean_force(self) -> float:
        """50 ms mean of that pulse [N]."""
        return self.fe_plan.case.mean_force(self.lateral_force)

    @property
    def by_flexibility(self) -> float:
        """Effect of the plate's flexibility by companions, without any by statics."""
        ratio = self.fe_plan.deflection_ratio
        return max(ratio, self.error.flexibility) if self.companions else ratio


def energy_error(history: Columns) -> NDArray[np.float64]:
    """Return the energy error [J], shape (rows,)."""
    return energy_surplus(history, STORED_ENERGIES)
