"""How alike two histories are: Sprague and Geers' metrics, and the residuals of an analysis of variance.

Inner products are taken over time by the trapezoidal rule, (f, g) = integral of f g dt, of a history f and its
reference g at common instants:

    magnitude      M = sqrt((f, f) / (g, g)) - 1, blind to phase
    phase          P = arccos((f, g) / sqrt((f, f) (g, g))) / pi, blind to magnitude
    combined       C = sqrt(M^2 + P^2)
    residuals      r = (f - g) / max |g|; their mean over time, and their standard deviation about it

Sources: Sprague and Geers, A spectral-element method for modelling cavitation in transient fluid-structure
interaction, Int. J. Numer. Meth. Engng 60 (2004); the integrals also in Schwer, Validation metrics for response
histories, Engineering with Computers 23 (2007). Residuals: Ray, Repeatability of full-scale crash tests and criteria
for validating simulation results, Transportation Research Record 1528 (1996), as the program RSVVP of NCHRP Web-Only
Document 179 has them.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Metrics:
    """Of a history against its reference, dimensionless; 0 where the two are equal."""

    magnitude: float
    phase: float
    combined: float
    mean_residual: float
    deviation: float


def compare_histories(instants: Floats, history: Floats, reference: Floats) -> Metrics:
    """Metrics of `history` against `reference`, both of shape (instants,), in any one unit.

    Instants [s] rise, and need not be evenly spaced. Numbers that are not finite, less than two instants, and a
    reference that is zero throughout give NaN.
    """
    if instants.size < 2:
        return Metrics(*(5 * (math.nan,)))
    weights = _trapezoidal(instants)
    with np.errstate(all="ignore"):
        size, its = _norm(weights, history), _norm(weights, reference)
        magnitude = float(size / its - 1.0)
        phase = _angle(weights, history / size, reference / its) / math.pi
        residual = (history - reference) / np.abs(reference).max(initial=0.0)
        mean = np.sum(weights * residual) / weights.sum()
        deviation = np.sqrt(np.sum(weights * (residual - mean) ** 2) / weights.sum())
    found = (magnitude, phase, math.hypot(magnitude, phase), float(mean), float(deviation))
    return Metrics(*(value if math.isfinite(value) else math.nan for value in found))


def _trapezoidal(instants: Floats) -> Floats:
    """Weights [s] of the trapezoidal rule, shape (instants,)."""
    steps = np.diff(instants)
    return 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))


def _norm(weights: Floats, values: Floats) -> np.float64:
    return np.sqrt(np.sum(weights * values**2))


def _angle(weights: Floats, unit: Floats, other: Floats) -> float:
    """Angle [rad] between two functions of norm 1; unlike the arccosine it keeps its digits where it is small."""
    return 2.0 * math.atan2(_norm(weights, unit - other), _norm(weights, unit + other))
