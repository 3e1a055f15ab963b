"""Occupant risk of a planar motion: ASI, THIV and PHD of EN 1317-1, OIV and ORA of MASH.

ASI: the largest value of sqrt((ax / 12 g)^2 + (ay / 9 g)^2 + (az / 10 g)^2), of 50 ms means (EN 1317-1:1998), or, after
CFC 180, of accelerations through a four-pole phaseless Butterworth filter of 13 Hz (EN 1317-1:2010; taken as 3 dB down
forward and backward together). THIV: speed of a free head relative to the inside that it meets; PHD: from then on
the largest 10 ms mean of the resultant acceleration. OIV: velocities of a free occupant relative to the vehicle where
the first of the two flail distances is used up; ORA: from then on the largest 10 ms mean along each axis.

Sources: EN 1317-1; AASHTO, Manual for Assessing Safety Hardware, by way of the manuals of
NI DIAdem (ChnASICalc, ChnTHIVCalc, ChnOIVCalc) and Oasys T/HIS (THIV and PHD).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from postprocess.signals.filters import cfc_filter, low_pass, moving_mean
from postprocess.signals.flail_space import Contact, VehicleMotion, head_contact, occupant_contact

Floats = NDArray[np.float64]

GRAVITY = 9.80665
"""[m/s^2]"""

RIDEDOWN = 0.01
"""Width of the means after contact [s]."""

PLANAR = "planar: without vertical acceleration, roll and pitch a lower bound"
AXES = "planar; the vehicle's turning left out"
HEAD = "planar; head above the centre of mass, not in a seat"
LIMITS = "limits not given"


@dataclass(frozen=True)
class RiskMeasure:
    """A measure: value in its unit, None where the flight does not end; instant [s]; what it lacks; limits."""

    name: str
    value: float | None
    unit: str
    time: float | None
    lacks: str
    limits: str = LIMITS


def occupant_risk(motion: VehicleMotion) -> tuple[RiskMeasure, ...]:
    """All measures. ValueError for a motion sampled below 1800 Hz, or shorter than 77 ms (a period of 13 Hz)."""
    return (*severity_indices(motion), *head_measures(motion), *flail_measures(motion))


def severity_indices(motion: VehicleMotion) -> tuple[RiskMeasure, ...]:
    """ASI after both editions. Before first touch there is no acceleration."""
    interval = motion.interval
    axes = [
        np.concatenate(([0.0], a / (limit * GRAVITY))) for a, limit in ((motion.ax, 12.0), (motion.ay, 9.0))
    ]
    means = [moving_mean(a, interval, 0.05) for a in axes]
    filtered = [low_pass(cfc_filter(a, interval, 180), interval, 13.0) for a in axes]
    return tuple(
        _largest(f"ASI {edition}", "-", PLANAR, motion.t, np.hypot(*found)[1:])
        for edition, found in (("1998, 50 ms mean", means), ("2010, 13 Hz", filtered))
    )


def head_measures(motion: VehicleMotion) -> tuple[RiskMeasure, RiskMeasure]:
    """THIV [m/s] and PHD [g]."""
    contact = head_contact(motion)
    time, speed = (contact.time, contact.speed) if contact else (None, None)
    resultant = np.hypot(motion.ax, motion.ay)
    return (
        RiskMeasure("THIV", speed, "m/s", time, HEAD),
        _after("PHD", HEAD, motion, contact, resultant),
    )


def flail_measures(motion: VehicleMotion) -> tuple[RiskMeasure, ...]:
    """OIV [m/s] and ORA [g], each longitudinal and lateral, without sign."""
    contact = occupant_contact(motion)
    time, speeds = (contact.time, (contact.forward, contact.sideways)) if contact else (None, (None, None))
    axes = (("longitudinal", speeds[0], motion.ax), ("lateral", speeds[1], motion.ay))
    return (
        *(RiskMeasure(f"OIV {axis}", speed and abs(speed), "m/s", time, AXES) for axis, speed, _ in axes),
        *(_after(f"ORA {axis}", AXES, motion, contact, values) for axis, _, values in axes),
    )


def _after(
    name: str, lacks: str, motion: VehicleMotion, contact: Contact | None, values: Floats
) -> RiskMeasure:
    """The largest 10 ms mean [g] that begins after the contact and ends within the history."""
    t, half = motion.t, 0.5 * RIDEDOWN
    means = np.abs(moving_mean(values, motion.interval, RIDEDOWN)) / GRAVITY
    later = np.zeros(t.size, bool) if contact is None else (t >= contact.time + half) & (t <= t[-1] - half)
    return _largest(name, "g", lacks, t[later], means[later])


def _largest(name: str, unit: str, lacks: str, t: Floats, values: Floats) -> RiskMeasure:
    if not values.size:
        return RiskMeasure(name, None, unit, None, lacks)
    place = int(values.argmax())
    return RiskMeasure(name, float(values[place]), unit, float(t[place]), lacks)
