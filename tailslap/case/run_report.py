"""Report of a finite-element run of either kind of case.

Lines of `tailslap check` are texts by label: all texts of one label belong together.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

import tailslap
from postprocess import units
from postprocess.fields.series import FILE, FieldSeries, write_fields
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Page, Section
from postprocess.report.tables import Column, Table, pairs
from postprocess.units import SI, Units, duration, number
from tailslap.case import report_parts, resources
from tailslap.case.case import NO_BAND, FePlan, Outcome
from tailslap.case.force_band import ForceBand
from tailslap.case.run_fields import field_series
from tailslap.scene import write

Lines = dict[str, list[str]]
"""Texts of `tailslap check` by label."""

Parts = Sequence[tuple[str, str]]
"""Omitted parts of a scene, each with the reason."""

LABEL = 13
"""Columns of a label of `tailslap check`."""

INPUTS = (
    Column("key", "Key", form=lambda key: f"`{key}`"),
    Column("scene_text", "As given", form=lambda text: f"`{text}`" if text else ""),
    Column("value", "Value", form=lambda value: number(value, 6), unit_key="unit"),
    Column("unit", "Unit", is_unit=True),
    Column("origin", "From"),
)
COST: Mapping[str, tuple[str, Callable[[Any], str]]] = {
    "elements": ("elements", units.grouped),
    "nodes": ("nodes", units.grouped),
    "steps": ("time steps", units.grouped),
    "time_step": ("time step", duration),
    "setup_s": ("set-up", duration),
    "time_loop_s": ("time loop", duration),
    "pictures_s": ("pictures", duration),
}
"""Names and forms of sizes and times of a run."""


@dataclass(frozen=True)
class FeReport(ABC):
    """Summary, histories, page and terminal text of a run."""

    outcome: Outcome
    band: ForceBand = NO_BAND

    kicker: ClassVar[str]
    """Line above the headline of the page."""

    about: ClassVar[str]
    """Units and directions, at the foot of the page."""

    @property
    @abstractmethod
    def headline(self) -> Headline:
        """Result, set-up and accuracy of the run."""

    @property
    @abstractmethod
    def histories(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Columns of FE model and rigid vehicle by file name, shape (rows,)."""

    @property
    @abstractmethod
    def sections(self) -> Sequence[Section]:
        """Sections of the page between set-up and cost."""

    @property
    @abstractmethod
    def tables(self) -> Sequence[Table]:
        """Tables on the terminal."""

    @abstractmethod
    def omitted(self, pictures: bool) -> Parts:
        """Return the omitted parts with reasons."""

    @abstractmethod
    def drawn(self, folder: Path, units: Units, size: tuple[int, int] | None) -> Self:
        """Draw the pictures into a folder, and return the report with them.

        Units and size [pixels] are those of the pictures.
        """

    @property
    def is_drawn(self) -> bool:
        """True unless requested pictures could not be drawn."""
        return True

    @property
    def causes(self) -> Sequence[str]:
        """Sentences on the cause of a failure, beside choices of the program."""
        return ()

    @property
    def pictures_s(self) -> float | None:
        """Time for pictures [s], None where it is not reported."""
        return None

    @property
    def fields_of_ends(self) -> Callable[[], FieldSeries] | None:
        """Function that returns the fields at start and tail-slap.

        None without a tail-slap.
        """
        return None

    @property
    def fields(self) -> Callable[[], FieldSeries] | None:
        """Function that returns the fields at the instants of the scene.

        None without any.
        """
        snapshots = self.outcome.run.snapshots
        return None if snapshots is None else partial(field_series, self.outcome.fe_plan.model, snapshots)

    def summary(self, pictures: bool) -> dict[str, Any]:
        """Return the entries of `summary.json` that both kinds of case have, SI.

        pictures: whether they are requested.
        """
        outcome, fe_plan, model = self.outcome, self.outcome.fe_plan, self.outcome.fe_plan.model
        return {
            **vars(self.headline),
            "scene": fe_plan.case.scene.name,
            "version": tailslap.__version__,
            "passed": outcome.passed,
            "force_band": self.band.numbers(),
            "checks": [asdict(check) for check in outcome.checks],
            "design_forces": report_parts.design_ratios(fe_plan.case, outcome.mean_force),
            "chosen": [asdict(decision) for decision in fe_plan.decisions],
            "cost": run_cost(outcome),
            "left_out": [{"part": part, "why": why} for part, why in self.omitted(pictures)],
            "plate": {
                "mass": model.mass,
                "youngs_modulus": fe_plan.plate.youngs_modulus,
                "first_frequency": fe_plan.first_frequency,
                "highest_frequency": model.highest_frequency,
                "stable_time_step": model.stable_time_step,
            },
        }

    def written(
        self, folder: Path, pictures: bool, units: Units = SI, size: tuple[int, int] | None = None
    ) -> Report:
        """Write fields and pictures into a folder, and return the report.

        Units and size [pixels] are those of the pictures.
        """
        if self.fields:
            write_fields(folder / FILE, self.fields())
        report = self.drawn(folder, units, size) if pictures else self
        return report.composed(pictures and report.is_drawn)

    def composed(self, pictures: bool) -> Report:
        """Return the report without writing anything.

        pictures: whether they are requested.
        """
        return Report(self.page(pictures), self.summary(pictures), self.terminal, histories=self.histories)

    def page(self, pictures: bool) -> Page:
        """Return the page, with failed checks first and inputs last."""
        outcome, fe_plan, case = self.outcome, self.outcome.fe_plan, self.outcome.fe_plan.case
        chosen = {decision.key: decision.value for decision in fe_plan.decisions}
        inputs = write.resolved_inputs(case.scene, case.source, fe_plan.plate, chosen)
        spent = run_cost(outcome)
        spent |= {} if self.pictures_s is None else {"pictures_s": self.pictures_s}
        cost = {COST[name][0]: COST[name][1](value) for name, value in spent.items() if name in COST}
        parts = [{"part": part, "why": why} for part, why in self.omitted(pictures)]
        omitted = Table((Column("part", "Part"), Column("why", "Why")), parts)
        sections = [
            report_parts.failed_section(outcome.checks, [*chosen_sentences(fe_plan), *self.causes]),
            Section("Set-up", figures=[case.drawing()]),
            *self.sections,
            report_parts.published_section(self.band),
            Section("Cost", tables=[pairs(cost)], is_folded=True),
            Section("Omitted parts", "" if parts else "None.", tables=[omitted], is_folded=True),
            Section("Inputs", tables=[Table(INPUTS, inputs)], is_folded=True),
        ]
        count = sum(check.passed is outcome.passed for check in outcome.checks)
        checked = f"{count} of {len(outcome.checks)} checks"
        foot, scene_text = f"{report_parts.footer()} {self.about}", write.scene_text(case.source)
        return Page(self.kicker, self.headline, sections, foot, scene_text, outcome.passed, True, checked)

    @property
    def terminal(self) -> tuple[Table | str, ...]:
        """Text on the terminal above the answer, in order of importance."""
        outcome, run, choices = self.outcome, self.outcome.run, self.outcome.fe_plan.decisions
        pictures = "" if self.pictures_s is None else f", pictures {self.pictures_s:.2f} s"
        return (
            *(() if outcome.passed else (*self.causes, "")),
            f"{report_parts.passed_text(outcome.checks)}; {run.steps} steps in {run.time_loop_s:.3f} s, "
            f"set-up {outcome.setup_s:.2f} s{pictures}\n",
            *self.tables,
            *(["\n".join(f"Chosen: {choice.text}" for choice in choices)] if choices else []),
        )


def run_cost(outcome: Outcome) -> dict[str, float | int]:
    """Return sizes and times of a run."""
    parameters = outcome.fe_plan.model.parameters
    return {
        "elements": int(parameters.table.connectivity.shape[1]),
        "nodes": int(parameters.mass.size),
        "steps": outcome.run.steps,
        "time_step": parameters.time_step,
        "setup_s": outcome.setup_s,
        "time_loop_s": outcome.run.time_loop_s,
    }


def fe_lines(
    fe_plan: FePlan, rows: int, contact: Lines, start: str = "", steps: str = "", more: Lines | None = None
) -> Lines:
    """Return the texts of `tailslap check` on the FE model.

    rows: of the history; contact: texts on the contact; start, steps: words after masses and number of steps;
    more: further texts.
    """
    model, plate = fe_plan.model, fe_plan.plate
    elements, step = model.parameters.table.connectivity.shape[1], model.parameters.time_step
    mass, modulus = units.measure(model.mass, "kg", ".1f"), units.measure(plate.modulus, "Pa", ".6g")
    seconds = resources.loop_seconds(
        fe_plan.case.scene, plate.element, plate.counts, fe_plan.expected_steps, rows
    )
    chosen = [decision.text for decision in fe_plan.decisions]
    return {
        "plate": [
            f"{elements} elements, {model.parameters.mass.size} nodes, {mass}, {plate.element}, "
            f"{plate.lumping} masses{start}"
        ],
        "stiffness": [
            f"Young's modulus {modulus}, first frequency of the free plate in its plane "
            f"{fe_plan.first_frequency:.4g} Hz"
        ],
        **contact,
        "time step": [
            f"{step:.4g} s, {step / model.stable_time_step:.2f} of the stable {model.stable_time_step:.4g} s"
        ],
        "steps": [f"{fe_plan.expected_steps} time steps, about {seconds:.2g} s in the time loop{steps}"],
        **(more or {}),
        **({"chosen": chosen} if chosen else {}),
    }


def omitted_lines(omitted: Parts) -> Lines:
    """Return texts of `tailslap check` on omitted parts."""
    return {"omitted": [f"{part}: {why}" for part, why in omitted]} if omitted else {}


def plate_sentence(fe_plan: FePlan) -> str:
    """Return the finite-element model as a sentence."""
    (along, across), element = fe_plan.plate.counts, fe_plan.plate.element
    frequency = f"first natural frequency {fe_plan.first_frequency:.4g} Hz"
    if fe_plan.case.scene.trailer:
        total = len(fe_plan.model.discretisation.cells)
        return f"Hinged plates of {total} {element} elements, {frequency}."
    return f"Plate of {along} x {across} {element} elements, {frequency}."


def chosen_sentences(fe_plan: FePlan) -> list[str]:
    """Return the choices of the program as sentences."""
    return [f"Chosen by the program: {decision.text}." for decision in fe_plan.decisions]
