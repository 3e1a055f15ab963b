"""A scene in another solver: its deck, the run, and its motion beside the exact one and this program's.

Decks start unstressed. The plate then oscillates about the rigid motion, at a speed that the energy of the elastic
state bounds which it starts without. Its mean over the last periods is compared: for a stiff plate within `LIMIT`.
"""

from __future__ import annotations

import math
import shutil
import subprocess
import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import tailslap
from postprocess.comparison.nodal import read_centre_of_mass
from postprocess.comparison.quantities import QUANTITIES, relative_difference
from postprocess.report.page import Column, Headline, Section, Table, columns
from postprocess.report.report import Report
from postprocess.units import percent, percent_up
from tailslap.case.report import study_page
from tailslap.comparing.report import compare_items, compare_report
from tailslap.comparing.source import Item
from tailslap.errors import InputError
from tailslap.exports.deck import Deck, write_deck
from tailslap.files.load import column_units
from tailslap.progress import announced

if TYPE_CHECKING:
    from tailslap.case.corner.outcome import CornerOutcome

COMPARED = ("t", "v_gx", "v_gy", "omega")
"""Quantities at the tail-slap."""

FITTED = 0.3
"""Part of the history to which the mean motion is fitted."""

END_GAIN, MOST_GAIN = 3.2, 2.2
"""Bounds of the part of an oscillation that the end of a fitted cubic keeps: over the number of periods, and at all."""

LIMIT = 3e-4
"""Difference of a stiff plate with row-sum masses [-]."""

LAST_LINES = 12
"""Lines of a failed program that the message repeats."""

COMMAND = "ccx"
INSTALL = (
    "`ccx` was not found on the PATH; install CalculiX: `apt-get install calculix-ccx`, or www.calculix.de"
)

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
    """A scene that another solver has run.

    Attributes
    ----------
    deck : Deck
        That it has run.
    outcome : CornerOutcome
        Of this program.
    columns : dict of ndarray, shape (instants,)
        The other's motion of the centre of mass: "t", "theta", "omega" and so on, SI.
    seconds : float
        That it took [s].
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
        """Exact motion, this program's plate and the other's, by label."""
        return {
            "rigid": self.deck.case.rigid_history(),
            "FE": self.outcome.fe_history,
            "CalculiX": self.columns,
        }

    @property
    def other(self) -> dict[str, float]:
        """Its quantities at the tail-slap, SI: time by interpolation, velocities of the mean motion.

        The mean motion is a cubic fitted to the last part of the history, in which the oscillation averages out.
        """
        t, theta = self.columns["t"], self.columns["theta"]
        strike = float(np.interp(0.0, -theta, t))
        last = t >= (1.0 - FITTED) * t[-1]
        fits = {key: np.polyfit(t[last] - strike, self.columns[key][last], 3) for key in COMPARED[1:]}
        return {"t": strike, **{key: float(fit[-1]) for key, fit in fits.items()}}

    @property
    def difference(self) -> dict[str, float]:
        """Their relative differences from the exact motion [-]."""
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
        """True if no difference is above the limit."""
        return all(abs(value) <= self.limit for value in self.difference.values())


def run_confirmation(deck: Deck, folder: Path, time_limit: float) -> Confirmation:
    """Write the deck to a folder, run it and this program's model, and read what it has computed.

    Raises InputError where CalculiX is not installed, and OSError with the last lines of a program that fails, or takes
    longer than the limit [s].
    """
    from tailslap.case.corner.run import run_corner

    if shutil.which(COMMAND) is None:
        raise InputError("--with", deck.program, INSTALL)
    write_deck(deck, folder)
    files = {path.name: path.read_text("utf-8") for path in folder.iterdir()}
    began = time.monotonic()
    with announced("Running CalculiX ..."):
        said = _run(folder, time_limit)
    seconds = time.monotonic() - began
    try:
        columns = read_centre_of_mass(folder / "plate.dat")
    except (OSError, ValueError) as error:
        raise _failed(f"{COMMAND} wrote no complete result, {error}", said) from None
    columns["theta"] = deck.plan.start.angle - columns.pop("rotation")
    if columns["theta"][-1] > 0.0:
        raise _failed(f"{COMMAND} did not reach the tail-slap", said)
    return Confirmation(deck, run_corner(deck.case), columns, seconds, files)


def _run(folder: Path, time_limit: float) -> Path:
    """Run the deck in its folder; returns the file with what the program prints. Raises OSError."""
    said = folder / "ccx.log"
    try:
        with said.open("wb") as log:
            streams: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": log, "stderr": log}
            subprocess.run([COMMAND, "plate"], cwd=folder, check=True, timeout=time_limit, **streams)
    except subprocess.TimeoutExpired:
        raise _failed(f"{COMMAND} ran longer than --time-limit {time_limit:g} s", said) from None
    except subprocess.CalledProcessError as error:
        raise _failed(f"{COMMAND} ended with status {error.returncode}", said) from None
    return said


def _failed(why: str, said: Path) -> OSError:
    lines = [line for line in said.read_text("utf-8", "replace").splitlines() if line.strip()]
    return ChildProcessError("\n".join([f"{why}; its last lines:", *lines[-LAST_LINES:]]))


def confirm_report(found: Confirmation) -> Report:
    """Report of a confirmation."""
    case = found.deck.case
    groups = {
        "rigid": case.tail_slap,
        "fe": found.outcome.fe or dict.fromkeys(COMPARED),
        "calculix": found.other,
        "difference": found.difference,
    }
    rows = [
        {**vars(QUANTITIES[key]), **{group: its[key] for group, its in groups.items()}} for key in COMPARED
    ]
    table = Table(TABLE, rows, notes=(_limit_sentence(found),))
    items = [Item(label, its, column_units(its)) for label, its in found.histories.items()]
    compared = compare_report(compare_items(items, only=("theta", *COMPARED[1:])))
    sections = (Section("At the tail-slap", tables=[table]), *compared.page.sections)
    files = "plate.inp, the deck, with README.md; calculix.csv and rigid.csv, the motion; summary.json"
    page = study_page(case, "Confirmation by another solver", _headline(found), sections, files, found.passed)
    head = {
        "scene": case.scene.name,
        "version": tailslap.__version__,
        "with": "calculix",
        "passed": found.passed,
    }
    cost = {"increments": len(found.columns["t"]), "calculix_s": found.seconds}
    summary = {**head, **groups, "limit": found.limit, "cost": cost}
    return Report(page, summary, (table,), texts=found.files, histories={"calculix.csv": found.columns})


def _limit_sentence(found: Confirmation) -> str:
    return (
        "Velocities of CalculiX: mean motion, a cubic fitted to the last 30 % of the history, since an unstressed "
        f"plate oscillates about the rigid motion. Limit: {percent_up(found.limit)}, the larger of 0.03 % and the part "
        "of this oscillation that its mean can have."
    )


def _headline(found: Confirmation) -> Headline:
    case, differences = found.deck.case, found.difference
    key = max(COMPARED, key=lambda key: abs(differences[key]))
    words = "confirms" if found.passed else "does not confirm"
    answer = (
        f"CalculiX {words} the exact motion at the tail-slap: largest difference "
        f"{percent(differences[key], 4)}, of {QUANTITIES[key].symbol} (limit {percent_up(found.limit)})."
    )
    certainty = f"CalculiX: one layer of bricks, {len(found.columns['t'])} increments, {found.seconds:.3g} s."
    return Headline(f"{case.scene.name} in CalculiX", answer, case.set_up, certainty)
