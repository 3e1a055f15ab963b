"""Picks the cheapest setting that is expected to meet a tolerance.

What a run's answer is held against depends on the plate. Where its flexibility stays below the tolerance, it is
the exact rigid motion; where it does not, the flexible plate's own limit of fine meshes and a stiff hold. Either
error is foretold from the plate's give, which needs no run: the answer is off by SENSITIVITY times the give in the
first case, and times the give's distance from its limit in the second.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from tailslap.errors import InputError, Verbatim
from tailslap.fe_model import make_model
from tailslap.fe_plan import needed_plate, rigid_start, share_given
from tailslap.plan import Plan
from tailslap.scene import Scene
from tailslap.tolerance.ladder import Rung, ladder, seconds

if TYPE_CHECKING:
    from fem.model import PlateModel

FLAT, STEEP = 0.8, 2.6
"""Sensitivity of the answer to the give: so much at small angles, and so much more per radian of start angle.
Largest ratios seen by `benchmarks/tolerance.py`, with a third on top."""

BESIDE_THE_GIVE = 3.0
"""What is left near the limit is not in proportion to the give alone: there is vibration, and what hardly moves."""

LEAST = 1e-8
"""Tolerances below this are beyond the rounding of the run and of the answer it is held against."""

MOST_TRIED, SETTLED = 4_000, 0.1
"""Elements up to which the give's limit is sought, and the share of the needed accuracy to which it is known then."""

MARGIN = 2.0
"""Times the damping that calms the linearised model, which looks at few of the angles that the plate goes through."""

MOST_NODES = 350
"""Nodes up to which flutter is foretold for the setting itself: the analysis is dense."""

RIGID, LIMIT = "rigid", "limit"
"""What the answer is held against."""


@dataclass(frozen=True)
class Choice:
    """What was picked. against: RIGID or LIMIT; errors are relative, the largest of the five quantities.

    limit: the give of ever finer meshes, NaN where it was not sought; flexibility: by how much, at most, the plate's
    own flexibility moves the answer; damping: ratio added against flutter, or 0.
    """

    tolerance: float
    against: str
    rung: Rung
    damping: float
    expected_error: float
    expected_seconds: float
    flexibility: float
    limit: float = math.nan

    @property
    def changes(self) -> tuple[str, ...]:
        """The setting as --set would give it."""
        damping = (f"damping.ratio={self.damping:g}",) if self.damping else ()
        return (*self.rung.changes, *damping)


@dataclass(frozen=True, eq=False)
class _Candidate:
    rung: Rung
    give: float
    seconds: float
    model: PlateModel


def sensitivity(angle: float) -> float:
    """Error of the answer over the give, at most, for a start at this angle [rad]."""
    return FLAT + STEEP * angle


def choose(plan: Plan, tolerance: float) -> Choice:
    """The cheapest setting expected to meet the tolerance. Raises InputError where there is none."""
    if not LEAST <= tolerance < 1.0:
        raise InputError("--tolerance", Verbatim(f"{tolerance:g}"), f"allowed is from {LEAST:g} to below 1")
    factor = sensitivity(plan.start.angle)
    flexibility, choices = math.inf, []
    for constraint in _constraints(plan.scene):
        coarse = _coarsest(plan, constraint)
        error = factor * max(candidate.give for candidate in coarse)
        flexibility = min(flexibility, error)
        if error <= tolerance:
            choices.append(_choice(plan, tolerance, RIGID, coarse[0], error, flexibility))
            if not choices[-1].damping:
                break
    if choices:  # the hold that needs the least damping against flutter
        return min(choices, key=lambda choice: choice.damping)
    return _towards_the_limit(plan, tolerance, factor, flexibility)


def _towards_the_limit(plan: Plan, tolerance: float, factor: float, flexibility: float) -> Choice:
    """The cheapest mesh whose give is near enough to that of ever finer meshes."""
    if plan.scene.corner.patch_length is None:
        allowed = (
            f"the plate's flexibility moves the answer by up to {flexibility:.1e}, and a corner held at one node has "
            "no limit of fine meshes to come closer to; allowed is that much, or a scene with corner.patch_length"
        )
        raise InputError("--tolerance", Verbatim(f"{tolerance:g}"), allowed)
    factor = BESIDE_THE_GIVE * factor
    found = _until_settled(plan, _constraints(plan.scene)[-1], tolerance / factor)
    limit = found[-1].give
    errors = {candidate: factor * abs(candidate.give - limit) for candidate in found[:-1]}
    good = [candidate for candidate, error in errors.items() if error <= tolerance]
    if not good:
        nearest = min(errors.values(), default=math.inf)
        allowed = f"the finest mesh tried is expected to come within {nearest:.1e} of the limit"
        raise InputError("--tolerance", Verbatim(f"{tolerance:g}"), allowed)
    best = min(good, key=lambda candidate: candidate.seconds)
    return replace(_choice(plan, tolerance, LIMIT, best, errors[best], flexibility), limit=limit)


def _constraints(scene: Scene) -> tuple[str, ...]:
    """Holds to try: the scene's own if it says anything of it."""
    given = scene.corner.model_fields_set & {"constraint", "penalty_scale", "damping_ratio"}
    return (scene.corner.constraint,) if given else ("penalty", "exact")


def _coarsest(plan: Plan, constraint: str) -> list[_Candidate]:
    """The coarsest mesh that makes a model, with linear elements and with quadratic ones, which do not lock."""
    rungs = ladder(plan.scene, constraint)
    for linear, quadratic in zip(rungs, rungs, strict=True):
        found = [candidate for rung in (linear, quadratic) if (candidate := _candidate(plan, rung))]
        if len(found) == 2:
            return found
    raise InputError(
        "plate.elements", Verbatim("none"), "no mesh of the ladder makes a model of this vehicle"
    )


def _until_settled(plan: Plan, constraint: str, within: float) -> list[_Candidate]:
    """Candidates from coarse to fine, until three quadratic meshes agree to a share of `within`."""
    found: list[_Candidate] = []
    for rung in ladder(plan.scene, constraint):
        if rung.elements[0] * rung.elements[1] > MOST_TRIED:
            break
        candidate = _candidate(plan, rung)
        found += [candidate] if candidate else []
        gives = [candidate.give for candidate in found if candidate.rung.element == "quad9"][-3:]
        if len(gives) == 3 and max(gives) - min(gives) < SETTLED * within:
            break
    if len(found) < 2:
        raise InputError(
            "corner.patch_length", plan.scene.corner.patch_length, "no mesh tried has a node within it"
        )
    return sorted(found, key=lambda candidate: candidate.rung.fineness)


def _candidate(plan: Plan, rung: Rung) -> _Candidate | None:
    """The rung's model and give, or None where the mesh cannot carry the inertia or the patch."""
    plate, corner = needed_plate(plan.scene), plan.scene.corner
    update: dict[str, Any] = {"element": rung.element, "elements": rung.elements, "hourglass": 0.1}
    plate = plate.model_copy(update=update)
    scene = plan.scene.model_copy(
        update={"plate": plate, "corner": corner.model_copy(update={"constraint": rung.constraint})}
    )
    try:
        model = make_model(replace(plan, scene=scene), plate)
    except InputError:
        return None
    steps = math.ceil(plan.motion.strike.t / model.loop.time_step)
    return _Candidate(rung, share_given(plan, model), seconds(rung, steps, plan.scene.time.rows), model)


def _choice(
    plan: Plan, tolerance: float, against: str, best: _Candidate, error: float, flexibility: float
) -> Choice:
    """The choice, with damping where the setting would flutter and the scene has none of its own."""
    damping = _calming(plan, best) if plan.scene.damping is None else 0.0
    return Choice(tolerance, against, best.rung, damping, error, best.seconds, flexibility)


def _calming(plan: Plan, best: _Candidate) -> float:
    """Damping ratio that keeps the setting from fluttering, or 0: the cure foretold, with a margin.

    For a large model it is that of a small one, at the same modes, with the margin twice: fine meshes flutter sooner.
    """
    from fem.flutter import CALM, foresee_flutter

    model, start, duration = best.model, rigid_start(plan), plan.motion.strike.t
    judged = model if model.loop.mass.size <= MOST_NODES else _coarsest(plan, best.rung.constraint)[1].model
    flutter = foresee_flutter(judged, start, duration)
    if flutter is None or flutter.growth <= CALM or flutter.cure is None:
        return 0.0
    ratio = MARGIN * flutter.cure
    if judged is not model:
        ratio *= MARGIN * model.highest_frequency / judged.highest_frequency
    return min(1.0, ratio)
