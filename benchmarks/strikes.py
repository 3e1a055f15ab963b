"""Whole impacts over the angle, by every command.

    .venv/bin/python benchmarks/strikes.py [STEP in deg]

Three vehicles, 10 to 20 deg in steps of half a degree. The rigid vehicle of `rigid`, `explore` and a row of `sweep` is
held to its motion followed longer, to the samples of `study uncertainty`, to the rigid vehicle beside `run`, and to the
limit of a rigid plate of `run`, by two moduli, against the error that the stiffer one states.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import command_line
import numpy as np

from postprocess.report.tables import pairs
from postprocess.report.terminal import printed
from tailslap.case.impact import answers, error, strike_columns
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.read import read_scene

VEHICLES = ("impact-mash-tl4-sut", "impact-mash-tl3-pickup", "impact-mash-tl3-car")
FROM, TO, STEP = 10.0, 20.0, 0.5
STIFFER = 16.0
"""Times the modulus, whose plate keeps a sixteenth of the effect of flexibility."""
LONGER = 0.5
"""Time that the motion is followed beyond its end [s]."""
TEXTS = {
    "longer": "strikes, from those of a motion followed 0.5 s longer",
    "many": "strikes and forces, from those of samples",
    "beside": "50 ms mean, from that beside the plate",
    "plate": "strikes and 50 ms means, from the plate's",
    "over": "the limit of a rigid plate, over the stated error",
}


@dataclass(frozen=True)
class Angle:
    """Relative differences at an angle, each the largest.

    longer: of strikes from those of the motion followed longer; many: of both strikes and their forces from those of a
    sample; beside: of the 50 ms mean from that of the rigid vehicle beside the plate; plate: of the plate's strikes and
    50 ms means from the rigid vehicle's; over: of the limit of a rigid plate, over the stated error. cut: strikes of
    any model that are not over at the end.
    """

    longer: float
    many: float
    beside: float
    plate: float
    over: float
    cut: int
    passed: bool


def measured(scene: str, angle: float) -> Angle:
    """Compute the impact of a scene at an angle [deg] by all."""
    change = f"impact.angle={angle} deg"
    case = ImpactCase(*read_scene(scene, (change,)))
    outcome = case.run()
    modulus = f"plate.youngs_modulus={STIFFER * float(outcome.fe_plan.plate.modulus)!r}"
    stiff = ImpactCase(*read_scene(scene, (change, modulus))).run()
    longer = case.motion_until(case.motion.t_end + LONGER).strikes
    apart = [
        abs(getattr(strike, name) / getattr(longer_strike, name) - 1.0)
        for strike, longer_strike in zip(case.motion.strikes, longer, strict=False)
        for name in answers.COMPARED
    ]
    strikes = strike_columns.both_strikes(case.in_plane)
    sampled = case.many({"impact.angle": np.array([np.radians(angle)])})
    names = [name for name in strike_columns.COLUMNS if strikes[name] == strikes[name]]
    many = [abs(float(sampled[name][0]) / strikes[name] - 1.0) for name in names]
    mean = case.row(None)["rigid.peaks.mean_50ms"]
    soft, hard = (error.changes(result.rigid, result.fe) for result in (outcome, stiff))
    limits = {name: (STIFFER * hard[name] - soft[name]) / (STIFFER - 1.0) for name in soft}
    return Angle(
        max(apart),
        max(many),
        abs(outcome.rigid.peaks["mean_50ms"] / mean - 1.0),
        max(map(abs, soft.values())),
        max(abs(limit) / stiff.mesh_error[name] for name, limit in limits.items()),
        sum(len(answer.cut) for answer in (case.in_plane, outcome.fe, outcome.rigid)),
        outcome.passed,
    )


def rows(scene: str, step: float) -> Iterator[tuple[str, str]]:
    """Measure a vehicle over all angles."""
    angles = np.arange(FROM, TO + 0.5 * step, step)
    impacts = [measured(scene, float(angle)) for angle in angles]
    failed, cut = sum(not impact.passed for impact in impacts), sum(impact.cut for impact in impacts)
    yield f"{scene}: impacts; failed; strikes cut", f"{len(impacts)}; {failed}; {cut}"
    for name, text in TEXTS.items():
        yield f"  {text}: most", f"{max(getattr(impact, name) for impact in impacts):.1e}"


def main() -> None:
    """Print the rows of each vehicle as they come."""
    step = command_line.options(__doc__, ("step", STEP)).step
    for scene in VEHICLES:
        print(printed([pairs(list(rows(scene, step)))]), flush=True)


if __name__ == "__main__":
    main()
