"""Confirm a scene by another solver.

The motion of its deck is compared with the exact one and that of this program. Decks start unstressed. The plate then
oscillates about the rigid motion; the speed is bounded by the energy of the elastic state that the start omits. Its
mean over the last periods is compared, which for a stiff plate agrees within `LIMIT`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

import tailslap
from postprocess.comparison.quantities import QUANTITIES, relative_difference
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.units import percent, percent_up
from tailslap.arguments import checked_arguments
from tailslap.case import case_of
from tailslap.case.case import Case
from tailslap.case.of_arguments import Changes, Scene, affordable_case
from tailslap.case.report_parts import study_page
from tailslap.comparing.compare_report import compare_items, compare_report
from tailslap.comparing.source import Item
from tailslap.errors import InputError, one_of
from tailslap.exports import SOLVERS, calculix
from tailslap.exports.deck import Deck, make_deck, write_deck
from tailslap.result.columns import column_units, history
from tailslap.result.result import Result, of_report
from tailslap.scene.vary import vary

if TYPE_CHECKING:
    from tailslap.case.corner.outcome import CornerOutcome

COMPARED = ("t", "v_gx", "v_gy", "omega")
"""Quantities at the tail-slap."""

FITTED = 0.3
"""Fraction of the history to which the mean motion is fitted."""

END_GAIN, MOST_GAIN = 3.2, 2.2
"""Bounds of the gain of an oscillation at the end of a fitted cubic: over the number of periods, and of any."""

LIMIT = 3e-4
"""Difference of a stiff plate with row-sum masses [-]."""

TABLE = (
    Column("title", "Quantity"),
    Column("unit", "Unit", is_unit=True),
    *columns(
        {"rigid": "Exact rigid motion", "fe": "tailslap, FE", "calculix": "CalculiX"},
        form=".7g",
        unit_key="unit",
    ),
    Column("difference", "CalculiX / exact - 1", form=partial(percent, decimals=4)),
)


@dataclass(frozen=True)
class Confirmation:
    """Motion of a scene by another solver and by this program.

    Attributes
    ----------
    deck : Deck
        Deck of the run.
    outcome : CornerOutcome
        Of this program.
    columns : dict of ndarray, shape (instants,)
        Motion of the centre of mass by the other solver: "t", "theta", "omega" and so on, SI.
    seconds : float
        Duration of the run [s].
    files : dict of str
        Texts of the deck by the names of their files.
    """

    deck: Deck
    outcome: CornerOutcome
    columns: Mapping[str, np.ndarray]
    seconds: float
    files: Mapping[str, str]

    @property
    def histories(self) -> dict[str, Mapping[str, np.ndarray]]:
        """Motions of the rigid body and both solvers."""
        return {
            "rigid": self.deck.case.rigid_history(),
            "FE": self.outcome.fe_history,
            "CalculiX": self.columns,
        }

    @property
    def other(self) -> dict[str, float]:
        """Quantities of the other solver, in SI.

        Time is interpolated, velocities are those of the mean motion: a cubic fitted to the last part of the history,
        in which the oscillation averages out.
        """
        t, theta = self.columns["t"], self.columns["theta"]
        strike = float(np.interp(0.0, -theta, t))
        last = t >= (1.0 - FITTED) * t[-1]
        fits = {key: np.polyfit(t[last] - strike, self.columns[key][last], 3) for key in COMPARED[1:]}
        return {"t": strike, **{key: float(fit[-1]) for key, fit in fits.items()}}

    @property
    def difference(self) -> dict[str, float]:
        """Relative differences from the exact motion [-]."""
        return relative_difference(self.other, self.deck.case.tail_slap, COMPARED)

    @property
    def limit(self) -> float:
        """Largest difference that confirms the scene [-]."""
        plan, strike = self.deck.plan, self.deck.case.tail_slap
        amplitude = math.sqrt(2.0 * plan.elastic_energy / plan.model.mass) / abs(strike["v_gy"])
        periods = FITTED * strike["t"] * plan.first_frequency
        return max(LIMIT, amplitude * min(MOST_GAIN, END_GAIN / periods) + plan.deflection_ratio)

    @property
    def passed(self) -> bool:
        """True if no difference exceeds the limit."""
        return all(abs(value) <= self.limit for value in self.difference.values())


def without_friction(case: Case) -> Case:
    """Return the case without friction at the corner.

    Decks of CalculiX have none.
    """
    if case.scene.contact or not case.scene.corner_friction:
        return case
    return case_of(*vary(case.source, {"corner.reaction": "none", "corner.friction": None}))


def run_confirmation(deck: Deck, folder: Path, time_limit: float) -> Confirmation:
    """Run the deck and this program's model.

    The deck is written to the folder. Raises InputError where CalculiX is not installed, and OSError with the last
    lines of a program that fails, or takes longer than the limit [s].
    """
    from tailslap.case.corner.corner_run import run_corner

    write_deck(deck, folder)
    files = {path.name: path.read_text("utf-8") for path in folder.iterdir()}
    columns, seconds = calculix.run_calculix(folder, time_limit, deck.places.shape[1])
    columns["theta"] = deck.plan.start.angle - columns.pop("rotation")
    if columns["theta"][-1] > 0.0:
        raise calculix.failed(f"{calculix.COMMAND} did not reach the tail-slap", folder)
    return Confirmation(deck, run_corner(deck.case), columns, seconds, files)


def confirm_report(confirmation: Confirmation) -> Report:
    """Report a confirmation."""
    case = confirmation.deck.case
    groups = {
        "rigid": case.tail_slap,
        "fe": confirmation.outcome.fe or dict.fromkeys(COMPARED),
        "calculix": confirmation.other,
        "difference": confirmation.difference,
    }
    rows = [
        {**vars(QUANTITIES[key]), **{group: values[key] for group, values in groups.items()}}
        for key in COMPARED
    ]
    table = Table(TABLE, rows, notes=(_limit_sentence(confirmation),))
    items = [Item(label, motion, column_units(motion)) for label, motion in confirmation.histories.items()]
    compared = compare_report(compare_items(items, only=("theta", *COMPARED[1:])))
    sections = (Section("At the tail-slap", tables=[table]), *compared.page.sections)
    files = "plate.inp, the deck, with README.md; calculix.csv and rigid.csv, the motion; summary.json"
    page = study_page(
        case, "Confirmation by another solver", _headline(confirmation), sections, files, confirmation.passed
    )
    head = {
        "scene": case.scene.name,
        "version": tailslap.__version__,
        "with": "calculix",
        "passed": confirmation.passed,
    }
    cost = {"increments": len(confirmation.columns["t"]), "calculix_s": confirmation.seconds}
    summary = {**head, **groups, "limit": confirmation.limit, "cost": cost}
    return Report(
        page, summary, (table,), texts=confirmation.files, histories={"calculix.csv": confirmation.columns}
    )


def _limit_sentence(confirmation: Confirmation) -> str:
    """Describe the compared motion and the limit."""
    return (
        "Velocities of CalculiX: mean motion, a cubic fitted to the last 30 % of the history, since an unstressed "
        f"plate oscillates about the rigid motion. Limit: {percent_up(confirmation.limit)}, the larger of 0.03 % and "
        "the part of this oscillation that its mean can have."
    )


def _headline(confirmation: Confirmation) -> Headline:
    """Return the verdict with the largest difference."""
    case, differences = confirmation.deck.case, confirmation.difference
    key = max(COMPARED, key=lambda key: abs(differences[key]))
    verdict = "confirms" if confirmation.passed else "does not confirm"
    answer = (
        f"CalculiX {verdict} the exact motion at the tail-slap: largest difference "
        f"{percent(differences[key], 4)}, of {QUANTITIES[key].symbol} (limit {percent_up(confirmation.limit)})."
    )
    increments, seconds = len(confirmation.columns["t"]), confirmation.seconds
    certainty = (
        "Friction is omitted from both models: a boundary condition of CalculiX has none. CalculiX: one layer of "
        f"bricks, {increments} increments, {seconds:.3g} s."
    )
    return Headline(f"{case.scene.name} in CalculiX", answer, case.set_up, certainty)


@checked_arguments
def confirm(
    scene: Scene,
    changes: Changes | None = None,
    *,
    program: str = "calculix",
    time_limit: float = 600.0,
    allow_large: bool = False,
) -> Result:
    """Confirm a scene by another solver.

    They are those of the other solver, of the rigid body, which is exact, and of this program's plate.

    Parameters
    ----------
    scene : str, path or mapping
        Name of a scene of the program, path of a TOML file, or tables of a scene; with a constrained corner, whose
        friction is omitted.
    changes : mapping or sequence of str, optional
        Values by dotted key, or texts KEY=VALUE.
    program : str
        "calculix", which must be installed as `ccx`.
    time_limit : float
        Longest time of the other solver [s].
    allow_large : bool
        Run even if the estimate exceeds this machine's memory, threads or time.

    Returns
    -------
    Result
        `summary["difference"]` contains the relative differences from the exact motion at the tail-slap; `passed` is
        True if none exceeds `summary["limit"]`.

    Raises
    ------
    InputError
        For an invalid scene or key, a scene that the solver cannot have, and a solver that is not installed.
    OSError
        For a solver that fails or exceeds the time limit, with its last lines.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.confirm("paper-table-3", {"corner.reaction": "none"}).passed  # doctest: +SKIP
    True
    """
    if program not in SOLVERS:
        raise InputError("--with", program, one_of(program, SOLVERS))
    case = affordable_case(scene, changes, allow_large)
    solver_deck = make_deck(without_friction(case), program)
    with TemporaryDirectory(prefix="tailslap-") as folder:
        confirmation = run_confirmation(solver_deck, Path(folder), time_limit)
    histories = {name: history(motion) for name, motion in confirmation.histories.items()}
    report = confirm_report(confirmation)
    return of_report("confirm", report, histories=histories, changes=case.changes)
