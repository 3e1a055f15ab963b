"""The crush law of a point: loading along F0 + k d, unloading along a line that gives back e^2 of the energy."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.elementary import Array, Number
from solver.errors import Gate
from solver.impact import rules


def virgin_force(law: Any, crush: Any) -> Any:
    """F0 + k d for whatever has a law's parameters, as numbers or arrays."""
    return law.initial_force + law.stiffness * np.asarray(crush, dtype=np.float64)


def energy_taken(law: Any, max_crush: Any) -> Any:
    """W = F0 D + k D^2/2."""
    crush = np.asarray(max_crush, dtype=np.float64)
    return crush * (law.initial_force + 0.5 * law.stiffness * crush)


def line_length(law: Any, max_crush: Any) -> Any:
    """Length of the unloading line, 2 e^2 W/F(D)."""
    force = np.asarray(virgin_force(law, max_crush))
    share = np.divide(energy_taken(law, max_crush), force, out=np.zeros_like(force), where=force > 0.0)
    return 2.0 * law.restitution**2 * share


def line_share(law: Any, crush: Any, max_crush: Any) -> Any:
    """F/F(D) on the unloading line: 0 at its end and below, 1 at the greatest crush."""
    length = np.asarray(line_length(law, max_crush))
    above = crush - max_crush + length
    return np.clip(np.divide(above, length, out=np.zeros_like(above), where=length > 0.0), 0.0, 1.0)


def stored_energy(law: Any, crush: Any, max_crush: Any) -> Any:
    """What unloading from d <= D would give back."""
    return law.restitution**2 * energy_taken(law, max_crush) * line_share(law, crush, max_crush) ** 2


@dataclass(frozen=True)
class CrushLaw:
    """Force over crush, of a corner or per metre of side.

    Loading follows the virgin curve F0 + k d. From the greatest crush D the force falls along a straight line which
    gives back e^2 of the energy taken up, W = F0 D + k D^2/2, and ends at the permanent crush D - 2 e^2 W/F(D);
    reloading follows that line up to D and then the virgin curve. The force is never negative.

    Parameters
    ----------
    stiffness : float
        k [N/m], or per metre of side [N/m^2].
    initial_force : float
        F0 [N], or per metre of side [N/m].
    restitution : float
        e [-].

    Raises
    ------
    RigidBodyError
        Unless the stiffness is positive and finite, the initial force 0 or more and finite, and the restitution from 0
        to 1; with an initial force up to sqrt(1/2), for a line beyond that would end in front of the wall.
    """

    stiffness: float
    initial_force: float = 0.0
    restitution: float = 0.0

    def __post_init__(self) -> None:
        gate, e = Gate(), rules.one("restitution", self.restitution)
        rules.positive(rules.STIFFNESS, self.stiffness)
        force = rules.one("initial_force", self.initial_force)
        gate.demand(rules.INITIAL_FORCE, 0.0 <= force < math.inf, force)
        gate.demand(rules.RESTITUTION, 0.0 <= e <= 1.0, e)
        gate.demand(rules.LINE, force == 0.0 or 2.0 * e * e <= 1.0 + 1e-12, e)

    def virgin_force(self, crush: Number) -> Array:
        """Force of the virgin curve, F0 + k d.

        Parameters
        ----------
        crush : float or ndarray, of any shape
            d > 0 [m].

        Returns
        -------
        ndarray
            [N], of that shape.
        """
        return np.asarray(virgin_force(self, crush))

    def energy_taken(self, max_crush: Number) -> Array:
        """Energy taken up on the virgin curve, W = F0 D + k D^2/2.

        Parameters
        ----------
        max_crush : float or ndarray, of any shape
            Greatest crush so far, D [m].

        Returns
        -------
        ndarray
            [J], of that shape.
        """
        return np.asarray(energy_taken(self, max_crush))

    def recovery(self, max_crush: Number) -> Array:
        """Length of the unloading line, 2 e^2 W/F(D).

        Parameters
        ----------
        max_crush : float or ndarray, of any shape
            Greatest crush so far, D [m].

        Returns
        -------
        ndarray
            [m], of that shape.
        """
        return np.asarray(line_length(self, max_crush))

    def residual(self, max_crush: Number) -> Array:
        """Permanent crush, at which the unloading line ends.

        Parameters
        ----------
        max_crush : float or ndarray, of any shape
            Greatest crush so far, D [m].

        Returns
        -------
        ndarray
            [m], of that shape.
        """
        return np.maximum(np.asarray(max_crush, dtype=np.float64) - self.recovery(max_crush), 0.0)

    def unloading_stiffness(self, max_crush: Number) -> Array:
        """Slope of the unloading line, F(D)^2/(2 e^2 W(D)): k/e^2 without an initial force.

        Parameters
        ----------
        max_crush : float or ndarray, of any shape
            Greatest crush so far, D [m].

        Returns
        -------
        ndarray
            [N/m], of that shape; infinite for e = 0.
        """
        force, length = self.virgin_force(max_crush), self.recovery(max_crush)
        limit = (
            self.stiffness / self.restitution**2 if self.restitution and not self.initial_force else math.inf
        )
        return np.divide(force, length, out=np.full_like(force, limit), where=length > 0.0)

    def force(self, crush: Number, max_crush: Number) -> Array:
        """Force at a crush, after a greatest crush.

        Parameters
        ----------
        crush : float or ndarray
            d [m]; negative in front of the wall.
        max_crush : float or ndarray
            Greatest crush before, D [m], 0 or more; of a shape that broadcasts with the other.

        Returns
        -------
        ndarray
            [N], of the common shape, 0 or more.
        """
        d, most = np.broadcast_arrays(
            np.asarray(crush, dtype=np.float64), np.asarray(max_crush, dtype=np.float64)
        )
        line = virgin_force(self, most) * line_share(self, d, most)
        return np.where(d > most, virgin_force(self, d), np.where(d > 0.0, line, 0.0))

    def stored_energy(self, crush: Number, max_crush: Number) -> Array:
        """Energy that unloading from a crush would give back.

        Parameters
        ----------
        crush : float or ndarray
            d [m].
        max_crush : float or ndarray
            Greatest crush so far, D >= d [m]; of a shape that broadcasts with the other.

        Returns
        -------
        ndarray
            [J], of the common shape.
        """
        return np.asarray(stored_energy(self, crush, np.maximum(crush, max_crush)))
