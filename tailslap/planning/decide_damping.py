"""Damping of the elastic velocities where friction would make the plate flutter: as much as that takes, none else."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tailslap.case.corner.rigid import RigidStages
from tailslap.errors import InputError
from tailslap.planning.decisions import Decision
from tailslap.planning.fe_model import make_static_model
from tailslap.planning.flexibility import friction_lost, oscillation_lost, rigid_start
from tailslap.scene.schema import Plate, Scene

if TYPE_CHECKING:
    from fem.model.plate_model import PlateModel
    from fem.stability.flutter import Flutter

REQUIRED_DAMPING = 4.0
"""Rate of the damping over that of the fastest growing mode: above 2 it decays."""

HARMLESS_UNSTRESSED = 2.0
"""Exponent of growth that an unstressed start stands, whose oscillation is there from the beginning."""

STAND_IN, STAND_INS = 2.0, 2
"""For a mesh too large for all its modes, coarser ones stand in: factor on their rates, and how many are looked at."""

OVERDAMPS = 0.5
"""Rate of damping over the lowest frequency above which that mode no longer follows its loads."""

SEEN, MISSED = 1e-3, 5e-4
"""Deflection ratio from which on it is seen that an overdamped plate does not follow its loads, and part of the result
that an unstressed plate's oscillation may lose: below, damping stays within the numerical error that is allowed."""

HEARD = 0.005
"""Ripple of the reaction by rounding, over the reaction at the start, from which on it is damped: to this."""


@dataclass(frozen=True)
class Growth:
    """What the linearised model predicts of friction: the fastest rate [1/s], 0 where none counts, NaN where no mesh
    could be analysed; its exponent over the run; the exponent that counts; whether coarser meshes stood in; the lowest
    elastic frequency [rad/s]. And of rounding: the ripple at the end of the run over the reaction at the start, and
    the rate of damping that keeps it unheard, 0 where it is."""

    rate: float
    exponent: float
    harmless: float
    stand_in: bool = False
    ripple: float = 0.0
    ripple_rate: float = 0.0
    lowest: float = 0.0

    @property
    def overdamps(self) -> bool:
        """Whether the damping that suppresses it would keep the plate from following its loads."""
        return REQUIRED_DAMPING * self.rate > OVERDAMPS * self.lowest

    @property
    def counts(self) -> bool:
        """Whether there is friction, by which anything could grow."""
        return self.harmless > 0.0


def predict_growth(plan: RigidStages, plate: Plate, model: PlateModel, normal: float) -> Growth:
    """Growth of the fastest mode by friction, the scene's stiffness-proportional damping included, and of rounding.

    normal: the rigid body's reaction at the start [N].
    """
    from fem.stability.flutter import HARMLESS, MAX_UNKNOWNS, predict_flutter, rounding_noise, viscous_rate

    harmless = HARMLESS if plate.relieved else HARMLESS_UNSTRESSED
    duration, start = plan.motion.strike.t, rigid_start(plan)
    noise, viscous = rounding_noise(model), viscous_rate(model)
    ripple = noise.ripple(duration) / abs(normal)
    ripple_rate = noise.rate_for(HEARD * abs(normal)) if ripple > HEARD else 0.0
    if model.loop.friction is None:
        growth = Growth(0.0, 0.0, 0.0)
    elif 2 * model.loop.mass.size <= MAX_UNKNOWNS:
        growth = _growth(predict_flutter(model, start, duration, viscous, harmless), harmless)
    else:
        growth = _by_stand_ins(
            [
                predict_flutter(coarse, start, duration, viscous, harmless / STAND_IN)
                for coarse in _coarser_models(plan, plate, MAX_UNKNOWNS)
            ],
            harmless,
        )
    return replace(growth, ripple=ripple, ripple_rate=ripple_rate)


def _by_stand_ins(found: list[Flutter], harmless: float) -> Growth:
    """Growth of a large mesh from that of coarser ones."""
    fastest: Flutter | None = max(found, key=lambda each: each.rate, default=None)
    if fastest is None:
        return Growth(math.nan, math.nan, harmless, stand_in=True)
    more = replace(fastest, rate=STAND_IN * fastest.rate, growth=STAND_IN * fastest.growth)
    return replace(_growth(more, harmless), stand_in=True)


def _growth(found: Flutter, harmless: float) -> Growth:
    """What was found; no more than half the exponent that counts is harmless whatever the rate is for a moment."""
    rate = found.rate if found.growth > 0.5 * harmless else 0.0
    return Growth(rate, found.growth, harmless, lowest=found.lowest)


def _coarser_models(plan: RigidStages, plate: Plate, most_unknowns: int) -> Iterator[PlateModel]:
    """The finest coarser meshes of the same element that make a model and can be analysed."""
    (along, across), found = plate.counts, 0
    while found < STAND_INS and max(along, across) > 2:
        along, across = max(2, round(along / 1.5)), max(2, round(across / 1.5))
        if 2 * (along + 1) * (across + 1) > most_unknowns:  # without other nodes than the elements' corners
            continue
        try:
            model = make_static_model(plan, plate.model_copy(update={"elements": (along, across)}))
        except InputError:
            continue
        if 2 * model.loop.mass.size <= most_unknowns:
            found += 1
            yield model


def suppressing_rate(growth: Growth) -> float:
    """Rate [1/s] of the damping of elastic velocities that suppresses what is foreseen."""
    return max(
        growth.ripple_rate, REQUIRED_DAMPING * growth.rate
    )  # in this order a rate that is not known, NaN, asks for none


def damping_is_open(scene: Scene) -> bool:
    """Whether the program may choose the damping."""
    return scene.damping is None or scene.damping.kind is None


def harms(
    plan: RigidStages, plate: Plate, model: PlateModel, growth: Growth, deflection_ratio: float
) -> bool:
    """Whether damping against this growth would be seen in the result: it keeps a soft plate from following its loads,
    and takes an unstressed one's oscillation off."""
    from fem.start.inertia_relief import elastic_energy

    if not growth.rate > 0.0:
        return False
    if plate.relieved:
        return growth.overdamps and deflection_ratio > SEEN
    energy, rate = elastic_energy(model, rigid_start(plan)), suppressing_rate(growth)
    return oscillation_lost(plan, energy, model.mass, rate) + friction_lost(plan, rate) > MISSED


def decide_damping(
    plan: RigidStages, growth: Growth, factor: float = 1.0, harmful: bool = False
) -> tuple[RigidStages, tuple[Decision, ...]]:
    """The plan with damping for this growth, times `factor`; as it is where the scene says what it wants.

    A plate that this would harm is run without it at first (factor 1): what is predicted is the worst that may come,
    and the checks watch for it.
    """
    if not damping_is_open(plan.scene):
        return plan, ()
    if factor == 1.0 and harmful:
        return _undamped(plan, growth)
    least = (growth.harmless or HARMLESS_UNSTRESSED) / plan.motion.strike.t if factor > 1.0 else 0.0
    rate = factor * max(suppressing_rate(growth), REQUIRED_DAMPING * least)
    again = f"; {factor:g} times as much as foreseen, since the first run rang" if factor > 1.0 else ""
    return _damped(plan, rate, _why(growth) + again)


def _undamped(plan: RigidStages, growth: Growth) -> tuple[RigidStages, tuple[Decision, ...]]:
    """Without damping against friction; that against rounding stays, and what the scene gives."""
    if growth.ripple_rate or plan.scene.damping:
        return _damped(plan, growth.ripple_rate, _why_rounding(growth))
    why = f"{_why(growth)}, but damping enough against that would be seen in the result"
    decision = Decision("damping.kind", "none", why)
    return plan.with_changes({decision.key: decision.value}), (decision,)


def _damped(plan: RigidStages, rate: float, why: str) -> tuple[RigidStages, tuple[Decision, ...]]:
    if not rate > 0.0:
        return plan, ()
    decisions = (
        Decision("damping.kind", "elastic-velocity", why),
        Decision("damping.rate", rate, "1/s, as much as that takes"),
    )
    return plan.with_changes({decision.key: decision.value for decision in decisions}), decisions


def _why(growth: Growth) -> str:
    if growth.ripple_rate > REQUIRED_DAMPING * growth.rate:
        return _why_rounding(growth)
    if growth.rate > 0.0:
        return f"friction would make the plate flutter, growing by exp({growth.exponent:.0f}) during the run"
    return "the plate would ring"


def _why_rounding(growth: Growth) -> str:
    return f"in so many steps rounding would make the reaction ring by {100.0 * growth.ripple:.2g} %"
