"""What the first strike's vibration may change in the second strike, where the mesh does not tell its phase."""

from __future__ import annotations

import math

import numpy as np

from solver.impact import Strike
from tailslap.impact.outcome import ImpactOutcome

MODAL_SHARE = 0.25
"""Mass that a free beam's first mode moves as its ends do, over the beam's."""


def unknown_by_vibration(outcome: ImpactOutcome) -> float:
    """Largest relative change of the second strike's impulse by the vibration's phase, as far as it is not known.

    The end of the plate moves with v cos(2 pi f t + phase); over a strike of duration T such a velocity is in the mean
    at most v/(pi f T) and at most v. Over n cycles between the strikes the phase is off by 2 pi n times the relative
    error of the frequency; without a second mesh it is unknown. 0 without a second strike, or a flight between the two.
    """
    strikes, frequency = outcome.fe.strikes, outcome.fe_plan.first_frequency
    if len(strikes) < 2 or strikes[1].start <= strikes[0].end:
        return 0.0
    first, second = strikes[:2]
    cycles = frequency * (second.start - first.end)
    phase = min(1.0, 2.0 * math.pi * cycles * abs(outcome.frequency_error))  # NaN: 1
    mean = min(1.0, 1.0 / (math.pi * frequency * second.duration))
    return _velocity(outcome, first, second) / _approach(outcome, second) * mean * phase


def _velocity(outcome: ImpactOutcome, first: Strike, second: Strike) -> float:
    """Of an end, from the energy of the plate in flight, all of it in the first mode [m/s]."""
    h = outcome.run.history
    free = (h["t"] > first.end) & (h["t"] < second.start)
    energy = float(h["strain_energy"][free].max(initial=0.0))
    return math.sqrt(2.0 * energy / (MODAL_SHARE * outcome.fe_plan.model.mass))


def _approach(outcome: ImpactOutcome, second: Strike) -> float:
    """Speed towards the wall of the corner that strikes, as of a rigid vehicle [m/s]."""
    h, vehicle = outcome.run.history, outcome.fe_plan.case.vehicle
    k = int(np.searchsorted(h["t"], second.start)) - 1
    ahead = vehicle.front_distance - (vehicle.length if second.corner.startswith("rear") else 0.0)
    return abs(float(h["v_gy"][k] + h["omega"][k] * ahead * math.cos(h["theta"][k])))
