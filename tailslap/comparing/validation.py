"""Validate a comparison in the form of NCHRP Web-Only Document 179.

The page `validation.html` has solution verification, metrics of single channels and of all together, phenomena and a
verdict. Source: Ray, Mongiardini, Plaxico and Anghileri, NCHRP Web-Only Document 179 (2010), Table E-1 for the limits
of solution verification, in which energies are those at the end of the run. Channels are velocities here, where W179
takes accelerations.
"""

import datetime
import math
import platform
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

import tailslap
from postprocess.comparison.metrics import weighted_metrics
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Page, Section, page_text
from postprocess.report.tables import Column, Table, columns, pairs
from postprocess.units import percent
from tailslap.case.report_parts import footer
from tailslap.comparing.compare_report import WORDS, Comparison, failed, metrics_table, yes
from tailslap.comparing.source import Item

Row = dict[str, Any]
"""Row of a table of the summary."""

PAGE = "validation.html"
BLANK = "\N{NO-BREAK SPACE}" * 40
"""Space to be filled in by hand."""

ENERGIES = ("kinetic_energy", "strain_energy", "contact_energy", "crush_energy", "hourglass_energy")
LOST = ("damping_work", "friction_work")
TRANSLATION, ROTATION = ("v_gx", "v_gy"), "omega"
"""Channels with a momentum: velocities, and the angular velocity, whose momentum requires the radius of gyration."""

POSITIONS = ("x_g", "y_g")
"""Integrals of channels, without a row among the phenomena."""

VERIFICATION = (
    *columns({"item": "Result", "name": "At the end of the run"}),
    Column("value", "Value [%]", form=lambda ratio: f"{100.0 * ratio:.2g}"),
    Column("limit", "Limit [%]", form=lambda ratio: f"{100.0 * ratio:g}"),
    *columns({"passed": "Within"}, form=yes),
)
PHENOMENA = (
    *columns({"item": "Result", "name": "Phenomenon"}),
    *columns({"reference": "Reference", "value": "Value"}, form=".4g", unit_key="unit"),
    Column("unit", "Unit", is_unit=True),
    Column("difference", "Difference", form=percent),
    *columns({"agrees": "Agrees"}, form=yes),
    Column("how", "Validated by"),
)
NOT_IN_THE_MODEL = (
    "Not in the planar model and not validated: pitch, suspension and tyres, failure of parts of vehicle and wall; the "
    "crush law of a whole impact is assumed."
)


def radius_of_gyration(items: Sequence[Item]) -> float | None:
    """Return the radius of gyration [m] of the first single vehicle.

    It follows from the kinetic energy at the largest angular velocity.
    """
    for item in items:
        columns, mass = item.columns, ((item.summary or {}).get("plate") or {}).get("mass")
        has_energy = {"kinetic_energy", *TRANSLATION, ROTATION} <= columns.keys()
        if not mass or not has_energy or "articulation_1" in columns:
            continue
        k = int(np.argmax(np.abs(np.nan_to_num(columns[ROTATION]))))
        spin, squares = abs(float(columns[ROTATION][k])), (columns[name][k] ** 2 for name in TRANSLATION)
        rotational = 2.0 * columns["kinetic_energy"][k] / mass - sum(squares)
        if rotational > 0.0 and spin > 0.0:
            return math.sqrt(rotational) / spin
    return None


def multi_channel(comparison: Comparison) -> dict[str, dict[str, Any]]:
    """Return weights and weighted metrics by label.

    Empty without channels with a momentum. The momentum of a channel is its largest change in the reference, over the
    mass: of a velocity the difference of its extremes [m/s], of the angular velocity that times the radius of gyration.
    """
    gyration, metrics_of_all = radius_of_gyration(comparison.items), {}
    factors = dict.fromkeys(TRANSLATION, 1.0) | ({ROTATION: gyration} if gyration else {})
    for label in comparison.labels:
        channels = [pair for name, pair in comparison.pairs if name == label and pair.name in factors]
        momenta = [factors[channel.name] * float(np.ptp(channel.reference)) for channel in channels]
        if sum(momenta):
            metrics = weighted_metrics([channel.metrics for channel in channels], momenta)
            weights = {x.name: momentum / sum(momenta) for x, momentum in zip(channels, momenta, strict=True)}
            metrics_of_all[label] = {"weights": weights, **asdict(metrics), "within": metrics.within}
    return metrics_of_all


def solution_verification(comparison: Comparison) -> list[Row]:
    """Return energies and mass of each result, with the limits of W179.

    Results are those of this program.
    """
    return [row | {"item": item.label} for item in comparison.items for row in _verified(item)]


def _verified(item: Item) -> Iterator[Row]:
    """Yield values of the solution verification of a result, with limits."""
    columns = item.columns
    if item.summary is None or "kinetic_energy" not in columns:
        return
    total = np.sum([columns[name] for name in ENERGIES if name in columns], axis=0)
    balance = total - np.sum([columns[name] for name in LOST if name in columns], axis=0)
    hourglass = columns["hourglass_energy"][-1] if "hourglass_energy" in columns else 0.0
    internal = total[-1] - columns["kinetic_energy"][-1]
    added = [check["value"] for check in item.summary.get("checks", ()) if check["name"] == "added mass"]
    values = {
        "change of total energy": (abs(balance[-1] / balance[0] - 1.0), 0.10),
        "hourglass over initial energy": (hourglass / total[0], 0.05),
        "hourglass over internal energy": (hourglass / internal if internal else 0.0, 0.10),
        "added mass over mass": (added[0] if added else 0.0, 0.05),
    }
    for name, (value, limit) in values.items():
        yield {"name": name, "value": float(value), "limit": limit, "passed": bool(value < limit)}


def phenomena(comparison: Comparison) -> list[Row]:
    """Return rows of the validated quantities.

    They are the largest force, and other quantities at the end of the common time.
    """
    rows = []
    for label, pair in comparison.pairs:
        if pair.name in POSITIONS:
            continue
        title = WORDS.get(pair.name, ("", f"Column {pair.name}"))[1].partition(",")[0]
        is_force = pair.name.startswith(("force", "reaction"))
        name, how = f"{title}, largest" if is_force else title, f"history to {pair.t[-1]:.4g} s, metrics"
        histories = pair.reference, pair.value
        reference, value = (float(np.abs(v).max() if is_force else v[-1]) for v in histories)
        row: Row = {"item": label, "name": name, "how": how, "reference": reference, "value": value}
        row["difference"] = value / reference - 1.0 if reference else None
        row |= {"unit": comparison.reference.units.get(pair.name, ""), "agrees": pair.within}
        rows.append(row)
    return rows


def with_validation(report: Report, comparison: Comparison, author: str) -> Report:
    """Add the validation to a report of a comparison.

    Its page is added, and its numbers to the summary.
    """
    verified = {"solution_verification": solution_verification(comparison)}
    summary = {**report.summary, "multi_channel": multi_channel(comparison), **verified}
    return replace(report, summary=summary, texts={PAGE: page_text(validation_page(comparison, author))})


def validation_page(comparison: Comparison, author: str = "") -> Page:
    """Return the page of the validation.

    The first result of the comparison is the reference. author: name on the page, by default a blank to be filled in.
    `passed`: solution verification and single channels are within the limits.
    """
    verified, weighted = solution_verification(comparison), multi_channel(comparison)
    passed = comparison.within and all(row["passed"] for row in verified)
    together = {True: "within", False: "beyond"}
    multi = "; ".join(f"{label} {together[metrics['within']]} them" for label, metrics in weighted.items())
    headline = Headline(
        f"Validation of {', '.join(comparison.labels)} with {comparison.reference.label}",
        f"{'Valid' if passed else 'Not valid'} by the criteria of NCHRP W179 for the channels below.",
        f"Weighted metrics of all channels with the same limits: {multi}." if multi else "",
    )
    program = f"tailslap {tailslap.__version__}, Python {platform.python_version()}, {platform.system()}"
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    basic = pairs({"Validated by": author or BLANK, "Date": today, "Program": program})
    metrics, remarks = metrics_table(comparison, weighted), comparison.missing
    notes = (f"Values other than the largest: at the end of the common time. {NOT_IN_THE_MODEL}",)
    sections = (
        Section("Basic information", tables=(basic,), layout="half"),
        Section("Solution verification", tables=(_verification_table(comparison, verified),), layout="half"),
        Section("Metrics of single channels and of all together", tables=(metrics,), sentences=remarks),
        Section("Phenomena", tables=(Table(PHENOMENA, phenomena(comparison), notes=notes),)),
    )
    below = footer("summary.json")
    return Page("Validation by NCHRP W179", headline, sections, below, passed=passed, checked="criteria")


def _verification_table(comparison: Comparison, rows: Sequence[Row]) -> Table:
    """Return the table of the solution verification."""
    note = "Limits: W179, Table E-1. The change excludes work of friction and damping; mass is not scaled."
    verified = {row["item"] for row in rows}
    if unverified := ", ".join(item.label for item in comparison.items if item.label not in verified):
        note += f" Histories alone, to be verified in their program: {unverified}."
    return Table(VERIFICATION, rows, notes=(note,), marks=failed(rows, "passed"))
