"""Report of a constrained corner, with texts of `tailslap check`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem.laws import constraints, friction, materials
from fem.plate import kinds
from fem.start import start_kinds
from postprocess.comparison import quantities
from postprocess.fields.contours import dark_form
from postprocess.fields.series import FieldSeries
from postprocess.report.page import Headline, Picture, Section
from postprocess.report.tables import Column, Table, pairs
from postprocess.units import Units, measure, percent_up
from tailslap.case import run_report
from tailslap.case.check import failed_names, failed_sentence
from tailslap.case.corner import corner_checks, decisions, rigid_stages
from tailslap.case.corner.corner_figures import CAPTIONS, curves, draw_pictures
from tailslap.case.corner.corner_plan import CornerPlan
from tailslap.case.corner.numerical_error import FLOOR
from tailslap.case.corner.outcome import CornerOutcome
from tailslap.case.corner.rigid_stages import RigidStages
from tailslap.case.report_parts import TAIL_SLAP, checks_section, design_table, short
from tailslap.case.run_fields import series_of_ends
from tailslap.scene.schema import Scene

PAPER = (
    Column("paper_analytical", "Paper, analytical", form=".5g", style="soft", unit_key="quantity.unit"),
    Column("paper_abaqus", "Paper, ABAQUS", form=".5g", style="soft", unit_key="quantity.unit"),
)
PEAKS = (
    Column("what", "Lateral force of Stage 3"),
    Column("fe", "By FE", "N", form="#.4g", style="strong"),
    Column("rigid", "By rigid body", "N", form="#.4g", style="strong"),
)
STAGE_3 = (
    "Stage 3 computes the force from the lateral speed at the tail-slap, where the FE run ends: the FE model confirms "
    "the speed, not the pulse. Design loads compare with the 50 ms mean."
)
METRICS = (
    Column("name", "History"),
    Column("magnitude", "Magnitude, M", form="+.2e"),
    Column("phase", "Phase, P", form=".3g"),
    Column("combined", "Combined, C", form=".3g"),
    Column("mean_residual", "Mean residual", form="+.2e"),
    Column("deviation", "Deviation of residuals", form=".3g"),
)
METRICS_NOTE = (
    "M, P and C by Sprague and Geers, with integrals over time; residuals are FE − rigid over the rigid history's "
    "peak, as in the analysis of variance of NCHRP W179. All are 0 for equal histories. Customary limits are wide; "
    "the program's own checks of numerical error and reaction are narrower."
)


@dataclass(frozen=True)
class CornerReport(run_report.FeReport):
    """Report of a run of a constrained corner."""

    outcome: CornerOutcome

    kicker = "Constrained corner: finite elements compared with the exact rigid-body solution"
    about = (
        "SI units; X along the wall in the driving direction, Y away from it, ω positive as the rear rotates towards "
        "the wall."
    )

    @property
    def headline(self) -> Headline:
        """Peak force of the tail-slap, the set-up, and its accuracy."""
        outcome, fe_plan, case = self.outcome, self.outcome.fe_plan, self.outcome.fe_plan.case
        sentence = "No tail-slap within the run."
        if outcome.fe:
            failed = set(failed_names(outcome.checks)) - corner_checks.reaction_checks()
            is_reliable = failed <= {"agreement with rigid"}
            sentence = case.force_sentence(outcome.lateral_force, is_reliable, self.band)
        return Headline(
            case.headline().title,
            failed_sentence(outcome.checks) + sentence,
            f"{case.set_up} {run_report.plate_sentence(fe_plan)}",
            _certainty(outcome) if outcome.fe else "",
            self.band.sentence,
        )

    @property
    def histories(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Histories of plate and rigid body by file name, shape (rows,)."""
        return {"history.csv": self.outcome.fe_history, "rigid.csv": self.outcome.rigid_history}

    @property
    def tables(self) -> list[Table]:
        """Quantities at the tail-slap and forces."""
        peaks, design = _forces(self.outcome)
        return [comparison(self.outcome, " "), short(design), peaks]

    @property
    def causes(self) -> list[str]:
        """The predicted oscillations."""
        return [f"Flutter {flutter_sentence(self.outcome.fe_plan)}."]

    @property
    def pictures_s(self) -> float:
        """Time for the pictures [s]."""
        return self.outcome.pictures_s

    @property
    def fields_of_ends(self) -> Callable[[], FieldSeries] | None:
        """Function that returns the fields at start and tail-slap.

        None without a tail-slap.
        """
        strike = self.outcome.run.strike
        return None if strike is None else partial(series_of_ends, self.outcome.fe_plan, strike)

    @property
    def is_drawn(self) -> bool:
        """True with pictures."""
        return bool(self.outcome.pictures)

    def omitted(self, pictures: bool) -> list[tuple[str, str]]:
        """Return the omitted parts with reasons."""
        return omitted_parts(self.outcome.fe_plan.case.scene, pictures)

    def drawn(self, folder: Path, units: Units, size: tuple[int, int] | None) -> CornerReport:
        """Draw contours at the tail-slap into a folder."""
        return replace(self, outcome=draw_pictures(self.outcome, folder, units, size))

    def summary(self, pictures: bool) -> dict[str, Any]:
        """Return the content of `summary.json`, SI.

        Quantities that were not reached are NaN, which is written as null.
        """
        outcome, fe_plan = self.outcome, self.outcome.fe_plan
        common, rigid_body = super().summary(pictures), fe_plan.case.rigid_numbers()
        missing = dict.fromkeys(quantities.KEYS, float("nan"))
        return common | {
            "rigid": outcome.rigid,
            "fe": outcome.fe or missing,
            "difference": outcome.difference or missing,
            "peak_force": {"fe": outcome.lateral_force, "rigid": float(fe_plan.case.force.peak_force)},
            "numerical_error": {"total": outcome.error.total, **asdict(outcome.error)},
            "companions": [asdict(companion) for companion in outcome.companions],
            "attempts": outcome.attempts,
            "metrics": {name: asdict(metrics) for name, metrics in outcome.metrics.items()},
            "cost": {**common["cost"], "pictures_s": outcome.pictures_s},
            **{stage: rigid_body[stage] for stage in ("stage1", "start", "stage3")},
            "plate": {
                **common["plate"],
                "deflection_ratio": fe_plan.deflection_ratio,
                "penalty_stiffness": fe_plan.model.parameters.corner.spring or None,
            },
            "tolerance": next((check.limit for check in outcome.checks if check.name == "tolerance"), None),
        }

    @property
    def sections(self) -> list[Section]:
        """Sections of the page, with empty ones, which are not shown."""
        outcome, rigid_body = self.outcome, self.outcome.fe_plan.case.rigid_numbers()
        pictures = [Picture(path, CAPTIONS[path.stem], dark_form(path)) for path in outcome.pictures]
        metrics = [{"name": f"`{name}`", **vars(item)} for name, item in outcome.metrics.items()]
        compared = Table(METRICS, metrics, notes=(METRICS_NOTE,))
        titles = {"stage1": "Stage 1: impulse at the front corner", "stage3": "Stage 3: tail-slap"}
        stages = [_stage_table(rigid_body[key] or {}, title) for key, title in titles.items()]
        return [
            Section("Peak lateral force", tables=_forces(outcome)),
            Section("At the tail-slap", tables=[comparison(outcome)]),
            Section("The plate at the tail-slap", figures=pictures, layout="tall"),
            *curves(outcome),
            Section("Model and interpretation", sentences=statements(outcome), is_folded=True),
            checks_section(outcome.checks, {name: kind.group for name, kind in corner_checks.CHECKS.items()}),
            Section("Histories compared with the rigid body", tables=[compared], is_folded=True),
            Section("Stages 1 and 3 of the rigid body", tables=stages, is_folded=True),
        ]


def _stage_table(numbers: dict[str, float], title: str) -> Table:
    labels = {name: rigid_stages.LABELS[name] for name in numbers}
    return pairs([(label, numbers[name], unit) for name, (label, unit) in labels.items()], title=title)


def peak_table(outcome: CornerOutcome) -> Table:
    """Return the peak forces of plate and rigid body by Stage 3."""
    case = outcome.fe_plan.case
    peaks = {"fe": outcome.lateral_force if outcome.fe else None, "rigid": float(case.force.peak_force)}
    means = {name: peak and case.mean_force(peak) for name, peak in peaks.items()}
    rows = (
        {"what": f"Peak of a triangle of {1e3 * case.scene.strike.duration:g} ms", **peaks},
        {"what": "50 ms mean", **means},
    )
    return Table(PEAKS, rows, notes=(STAGE_3,))


def comparison(outcome: CornerOutcome, title: str = "") -> Table:
    """Return the quantities at the tail-slap of plate and rigid body.

    The scene of the paper has its Table 3 beside them. title: of the short table on a terminal.
    """
    of_paper = is_paper_case(outcome.fe_plan.case)
    rows = quantities.comparison_rows(outcome.fe, outcome.rigid, of_paper) if outcome.fe else ()
    columns = TAIL_SLAP + (PAPER if of_paper else ())
    if title:
        return Table((replace(columns[1], label="Tail-slap"), *columns[2:]), rows, title)
    note = f"Paper: {quantities.PAPER_SOURCE}; v_GY has the sign of this report."
    return Table(columns, rows, notes=(note,) if of_paper else ())


def _forces(outcome: CornerOutcome) -> list[Table]:
    return [peak_table(outcome), design_table(outcome.fe_plan.case, outcome.mean_force)]


def omitted_parts(scene: Scene, pictures: bool = True) -> list[tuple[str, str]]:
    """Return a scene's omitted parts with reasons."""
    corner, plate = scene.corner, scene.plate
    fault = plate and kinds.LUMPINGS[plate.lumping].fault
    start, lumping = (plate.start, plate.lumping) if plate else ("", "")
    unstressed = f'plate.start is "{start}": no initial elastic state'
    no_friction = "the coefficient of friction is 0"
    if corner.frictionless:
        no_friction = f'corner.reaction is "{corner.reaction}"'
    rubs = scene.corner_friction and not corner.frictionless
    no_impact = "no [impact] table; [start] defines the state after the impact"
    parts = [
        (scene.impact, "stage 1", no_impact),
        (rubs, "friction", f"{no_friction}: no friction code in the time loop"),
        (scene.damping, "damping", "neither requested nor required: no damping code in the time loop"),
        (not plate or plate.relieved, "inertia relief", unstressed),
        (not fault, "exact inertia", f'plate.lumping is "{lumping}": {fault}'),
        (scene.wall, "wall", "no [wall] table: the wall is the line Y = 0"),
        (pictures, "pictures", "--no-pictures, or no picture could be drawn"),
    ]
    return [(part, why) for included, part, why in parts if not included]


def _rigid_lines(case: RigidStages) -> run_report.Lines:
    """Return the texts of `tailslap check` that need no mesh."""
    start, strike, reaction = case.start, case.motion.strike, case.scene.corner.reaction
    computed = "" if case.stage1 is None else " (see `tailslap rigid`)"
    law = friction.FRICTION_LAWS[reaction]
    return {
        "start": [
            f"angle {start.angle:.6g} rad, omega {start.omega:.6g} rad/s, "
            f"corner speed {measure(start.corner_speed, 'm/s', '.6g')}{computed}"
        ],
        "reaction": [f"{reaction}, friction {case.scene.corner_friction:g}: {law.text}"],
        "tail-slap": [f"expected at {strike.t:.6g} s after {measure(strike.slide, 'm', '.5g')} of sliding"],
        **run_report.omitted_lines(omitted_parts(case.scene)),
    }


def check_lines(case: RigidStages, fe_plan: CornerPlan | None) -> run_report.Lines:
    """Return the texts of `tailslap check` by label.

    fe_plan: None for a scene without [plate].
    """
    if fe_plan is None:
        return _rigid_lines(case)
    model, corner = fe_plan.model, fe_plan.model.parameters.corner
    where = "one node" if len(corner.nodes) == 1 else f"a patch of {len(corner.nodes)} nodes"
    stiffness = "" if corner.is_exact else f" of {measure(corner.stiffness, 'N/m', '.4g')}"
    contact = {
        "corner": [f"{where}, {corner.text}{stiffness}"],
        "frequency": [f"{model.highest_frequency:.6g} rad/s, the highest, with the corner's constraint"],
    }
    flexibility = (
        f"static deflection ratio {fe_plan.deflection_ratio:.1e}: static deflection of the centre under the initial "
        "reaction, over its travel to the wall; expected order of the differences from the rigid motion"
    )
    rows, start = fe_plan.case.scene.time.rows, f", {fe_plan.plate.start} start"
    return {
        **_rigid_lines(fe_plan.case),
        **run_report.fe_lines(fe_plan, rows, contact, start, more={"flexibility": [flexibility]}),
        "flutter": [flutter_sentence(fe_plan)],
    }


def _certainty(outcome: CornerOutcome) -> str:
    """Return the effect of flexibility and the numerical error as sentences."""
    case, difference, stated = outcome.fe_plan.case, quantities.largest(outcome.difference), "not estimated"
    if outcome.companions:
        stated = f"at most {percent_up(outcome.error.total)}"
    text = f"Finite elements and rigid-body method agree within {percent_up(difference)}"
    if not difference <= FLOOR:
        text = f"Vehicle flexibility changes the motion by at most {percent_up(difference)}"
    rings = " The motion is reliable, the history of the reaction is not."
    rings = rings if set(failed_names(outcome.checks)) & corner_checks.reaction_checks() else ""
    return f"{text}; discretisation error {stated}.{rings}{case.other_force()}{case.pull()}"


def flutter_sentence(fe_plan: CornerPlan) -> str:
    """Return the predicted oscillations by friction or rounding, and their remedy."""
    growth, damping = fe_plan.growth, fe_plan.case.scene.damping
    judged = ", judged on coarser meshes" if growth.by_coarser else ""
    needed = decisions.suppressing_rate(growth)
    if math.isnan(growth.rate):
        return "not analysed: no coarser mesh is available; the checks of the run detect it"
    if not needed > 0.0 and not growth.harmless:
        return "none: without friction nothing grows"
    if not needed > 0.0:
        return f"harmless: no mode grows by more than exp({growth.harmless:g}) during the run{judged}"
    text = f"the fastest mode grows by up to exp({growth.exponent:.0f}) during the run{judged}"
    if not growth.rate > 0.0:
        text = f"rounding errors make the reaction oscillate by {100.0 * growth.ripple:.2g} %"
    if damping is not None and (damping.rate or 0.0) >= 0.5 * needed:
        return f"suppressed by damping.rate = {damping.rate:.3g} 1/s; without it {text}"
    if decisions.damping_is_open(fe_plan.original.scene):
        return f"possible: {text}; a run in which the checks detect it is repeated with damping"
    return (
        f'EXPECTED, the run will fail its checks: {text}; damping.kind = "elastic-velocity" with '
        f"damping.rate = {needed:.3g} suppresses it, as does removing damping.kind"
    )


def statements(outcome: CornerOutcome) -> list[str]:
    """Return sentences on the model and its interpretation."""
    fe_plan, case, material = outcome.fe_plan, outcome.fe_plan.case, outcome.fe_plan.case.scene.material
    law = friction.FRICTION_LAWS[case.scene.corner.reaction]
    constraint = constraints.CONSTRAINTS[case.scene.corner.constraint]
    sentences = [
        f"The corner is held on the wall by a two-sided slider, in the FE model by {constraint.text}, with "
        f'{law.text} (reaction "{law.name}"). It is not unilateral contact: a real wall can only push.',
        f"The plate's material: {materials.MATERIALS[material.law].text}." if material else "",
        _plate_mass(fe_plan.model.mass, case.scene.vehicle.mass),
        *run_report.chosen_sentences(fe_plan),
        "The first run oscillated; this run has more damping." if outcome.attempts > 1 else "",
        f"The plate starts {start_kinds.START_KINDS[fe_plan.plate.start].text}.",
        f"Static deflection ratio {fe_plan.deflection_ratio:.1e}: static deflection of the centre under the initial "
        "reaction, over its travel to the wall. Differences of this order from the rigid motion are due to the plate's "
        "flexibility and inversely proportional to its stiffness.",
        _error(outcome),
        _convention(case),
    ]
    return [sentence for sentence in sentences if sentence]


def is_paper_case(case: RigidStages) -> bool:
    """Return whether vehicle and start are those of the paper's Table 3."""
    pairs = (
        (case.body.length, 10.0, 0.0),
        (case.body.width, 2.438, 0.0),
        (case.start.angle, 0.26, 0.002),
        (case.start.omega, 0.707, 2e-4),
        (case.start.corner_speed, 25.053, 1e-3),
        (case.scene.corner_friction, 0.47 if case.scene.corner.reaction == "drag" else 0.0, 0.0),
    )
    return all(
        math.isclose(value, paper, rel_tol=0.0, abs_tol=tolerance) for value, paper, tolerance in pairs
    )


def _plate_mass(plate: float, vehicle: float) -> str:
    """Return the effect of a plate of another mass [kg]."""
    if abs(plate / vehicle - 1.0) < 1e-9:
        return ""
    return (
        f"The plate weighs {measure(plate, 'kg', '.1f')}, the vehicle {measure(vehicle, 'kg', '.1f')}. "
        "Rigid motion does not depend on the mass; "
        "reactions and energies of the rigid solution are computed with the mass of the plate, "
        "Stages 1 and 3 with that of the vehicle."
    )


def _error(outcome: CornerOutcome) -> str:
    """Describe the terms of the numerical error."""
    error = outcome.error
    if not outcome.companions:
        has_companion = outcome.fe_plan.case.scene.verify.companion
        why = "no other mesh is available" if has_companion and outcome.fe else "the run has no result"
        why = why if has_companion else "verify.companion is false"
        return f"The numerical error is not estimated: {why}."
    meshes = " and ".join(companion.mesh for companion in outcome.companions)
    return (
        f"Numerical error of the five quantities at most {error.total:.1e}: mesh {error.mesh:.1e} (compared with "
        f"{meshes}), contact spring {error.contact_spring:.1e}, damping {error.damping:.1e}, rounding "
        f"{error.rounding:.1e}."
    )


def _convention(case: RigidStages) -> str:
    """Return the convention of restitution and the effect of the other one."""
    convention, impact = case.other_convention(), case.scene.impact
    if impact is None:
        return ""
    if convention is None:
        return f'Stage 1, for reference, follows the convention "{impact.convention}"; [start] overrides it.'
    name, other_case = convention
    return (
        f'Restitution follows the convention "{impact.convention}". With "{name}" the angular velocity after the '
        f"impact would be {other_case.start.omega:.4f} instead of {case.start.omega:.4f} rad/s."
    )
