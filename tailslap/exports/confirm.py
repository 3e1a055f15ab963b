"""A scene in another solver: its deck, the run, and its motion beside the exact one and this program's.

Decks start unstressed. The plate then oscillates about the rigid motion, at a speed that the energy of the elastic
state bounds which it starts without. Its mean over the last periods is compared: for a stiff plate within `LIMIT`.
"""

from __future__ import annotations

import contextlib
import math
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

import tailslap
from postprocess.comparison.nodal import read_centre_of_mass
from postprocess.comparison.quantities import QUANTITIES, relative_difference
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.units import percent, percent_up
from tailslap.case.report import study_page
from tailslap.comparing.report import compare_items, compare_report
from tailslap.comparing.source import Item
from tailslap.errors import InputError, shortened
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

MAX_LOG, TAIL = 16_000_000, 65_536
"""Bytes that a program may print, and those at their end that are read."""

BYTES_PER_NODE = 200_000
"""Files that a program may write, over the nodes of a layer: twice what CalculiX writes."""

POLL, GRACE = 0.05, 2.0
"""Seconds between looks at a program, and between SIGTERM and SIGKILL."""

COMMAND = "ccx"
DECK, RESULT, LOG = "plate.inp", "plate.dat", "ccx.log"
INSTALL = (
    "`ccx` was not found on the PATH; install CalculiX: `apt-get install calculix-ccx`, or www.calculix.de"
)
TESTED = "tested with CalculiX 2.20, `ccx -v` prints the version"

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
        _run(folder, time_limit, MAX_LOG + BYTES_PER_NODE * deck.places.shape[1])
    seconds = time.monotonic() - began
    try:
        columns = read_centre_of_mass(_result_in(folder))
    except (OSError, ValueError) as error:
        raise _failed(f"{COMMAND} wrote no complete result, {error} ({TESTED})", folder) from None
    columns["theta"] = deck.plan.start.angle - columns.pop("rotation")
    if columns["theta"][-1] > 0.0:
        raise _failed(f"{COMMAND} did not reach the tail-slap", folder)
    return Confirmation(deck, run_corner(deck.case), columns, seconds, files)


def _run(folder: Path, time_limit: float, room: int) -> None:
    """Run the deck in its folder, of at most `room` bytes. Raises OSError."""
    with (folder / LOG).open("wb") as log, _program([COMMAND, DECK.removesuffix(".inp")], folder) as program:
        why = _watch(program, log, folder, time_limit, room)
    if why or program.returncode:
        raise _failed(f"{COMMAND} {why or f'ended with status {program.returncode}'}", folder)


@contextlib.contextmanager
def _program(command: list[str], folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Yield a program in a process group of its own, which ends with the block."""
    with subprocess.Popen(
        command,
        cwd=folder,
        start_new_session=True,
        bufsize=0,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    ) as program:
        try:
            yield program
        finally:
            _end_group(program)


def _end_group(leader: subprocess.Popen[bytes]) -> None:
    """End all processes of a group by SIGTERM, after the grace by SIGKILL."""
    deadline = time.monotonic() + GRACE
    try:
        os.killpg(leader.pid, signal.SIGTERM)
        while time.monotonic() < deadline:
            leader.poll()
            os.killpg(leader.pid, 0)
            time.sleep(POLL)
    except ProcessLookupError:
        pass
    finally:  # also where a second interrupt ends the grace
        with contextlib.suppress(ProcessLookupError):
            os.killpg(leader.pid, signal.SIGKILL)
        leader.wait()


def _watch(
    program: subprocess.Popen[bytes], log: IO[bytes], folder: Path, time_limit: float, room: int
) -> str:
    """Log what a program prints until it ends; returns the limit that it exceeds, or ""."""
    assert program.stdout is not None
    os.set_blocking(program.stdout.fileno(), False)
    deadline = time.monotonic() + time_limit
    while True:
        has_ended = program.poll() is not None
        text = program.stdout.read(TAIL) or b""
        if log.tell() + len(text) > MAX_LOG:
            return f"printed more than {MAX_LOG / 1e6:g} MB"
        log.write(text)
        if has_ended and not text:
            return ""
        if time.monotonic() > deadline:
            return f"ran longer than --time-limit {time_limit:g} s"
        if _size(folder) > room:
            return f"wrote files of more than {room / 1e6:.0f} MB"
        if not text:
            time.sleep(POLL)


def _size(folder: Path) -> int:
    """Return the bytes on disk of all files below a folder."""
    size = 0
    for place, _, names in os.walk(folder):
        for name in names:
            with contextlib.suppress(FileNotFoundError):
                size += 512 * os.lstat(os.path.join(place, name)).st_blocks
    return size


def _result_in(folder: Path) -> Path:
    """Return the file of the motion. Raises ValueError for one that is not of this run."""
    deck, result = folder / DECK, folder / RESULT
    if not result.is_file():
        raise ValueError(f"{RESULT} is missing")
    if result.stat().st_mtime_ns < deck.stat().st_mtime_ns:
        raise ValueError(f"{RESULT} is older than {DECK}: an earlier run has left it")
    return result


def _failed(why: str, folder: Path) -> OSError:
    with (folder / LOG).open("rb") as log:
        log.seek(max(0, log.seek(0, os.SEEK_END) - TAIL))
        text = log.read(TAIL).decode("utf-8", "replace")
    lines = [shortened(line) for line in text.splitlines() if line.strip()]
    said = "its last lines:" if lines else "it printed nothing"
    return ChildProcessError("\n".join([f"{why}; {said}", *lines[-LAST_LINES:]]))


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
