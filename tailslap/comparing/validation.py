"""Validation of a comparison in the form of NCHRP Web-Only Document 179, on one page: `validation.html`.

Solution verification, metrics of single channels and of all together, phenomena, verdict. Source: Ray, Mongiardini,
Plaxico and Anghileri, NCHRP Web-Only Document 179 (2010), Table E-1 for the limits of solution verification, in which
energies are those at the end of the run. Channels are velocities here, where W179 takes accelerations.
"""

import datetime
import math
import platform
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

import tailslap
from postprocess.comparison.metrics import COVERED, LIMITS, weighted_metrics
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Page, Section, page_text
from postprocess.report.tables import Column, Table, columns, pairs
from postprocess.units import percent
from tailslap.case.report import footer
from tailslap.comparing.report import METRICS, WORDS, Comparison
from tailslap.comparing.source import Item

PAGE = "validation.html"
BLANK = "\N{NO-BREAK SPACE}" * 40
"""To be filled in by hand."""

ENERGIES = ("kinetic_energy", "strain_energy", "contact_energy", "crush_energy", "hourglass_energy")
LOST = ("damping_work", "friction_work")
TRANSLATION, ROTATION = ("v_gx", "v_gy"), "omega"
"""Channels with a momentum: velocities, and the angular velocity, whose momentum requires the radius of gyration."""

POSITIONS = ("x_g", "y_g")
"""Integrals of channels, without a row among the phenomena."""

NOT_IN_THE_MODEL = (
    "Not in the planar model and not validated: pitch, suspension and tyres, failure of parts of vehicle and wall; the "
    "crush law of a whole impact is assumed."
)


def radius_of_gyration(items: Sequence[Item]) -> float | None:
    """Radius of gyration [m] of the first result of a single vehicle: its kinetic energy where it spins fastest."""
    for item in items:
        known = item.columns
        mass = ((item.summary or {}).get("plate") or {}).get("mass")
        if (
            mass
            and {"kinetic_energy", *TRANSLATION, ROTATION} <= known.keys()
            and "articulation_1" not in known
        ):
            k = int(np.argmax(np.abs(np.nan_to_num(known[ROTATION]))))
            spinning = 2.0 * known["kinetic_energy"][k] / mass - sum(
                known[name][k] ** 2 for name in TRANSLATION
            )
            if spinning > 0.0 and abs(known[ROTATION][k]) > 0.0:
                return math.sqrt(spinning) / abs(float(known[ROTATION][k]))
    return None


def multi_channel(found: Comparison) -> dict[str, dict[str, Any]]:
    """Weights of the channels and weighted metrics of each result, by label; empty without channels with a momentum.

    The momentum of a channel is its largest change in the reference, over the mass: of a velocity the difference of its
    extremes [m/s], of the angular velocity that times the radius of gyration.
    """
    gyration, made = radius_of_gyration(found.items), {}
    factors = dict.fromkeys(TRANSLATION, 1.0) | ({ROTATION: gyration} if gyration else {})
    for label in dict.fromkeys(label for label, _ in found.pairs):
        channels = [each for name, each in found.pairs if name == label and each.name in factors]
        momenta = [factors[each.name] * float(np.ptp(each.reference)) for each in channels]
        if sum(momenta):
            weights = [momentum / sum(momenta) for momentum in momenta]
            metrics = weighted_metrics([each.metrics for each in channels], momenta)
            made[label] = {
                "weights": {each.name: weight for each, weight in zip(channels, weights, strict=True)},
                **asdict(metrics),
                "within": metrics.within,
            }
    return made


def solution_verification(found: Comparison) -> list[dict[str, Any]]:
    """Rows of energies and mass of each result of this program, with the limits of W179."""
    return [row | {"item": item.label} for item in found.items for row in _verified(item)]


def _verified(item: Item) -> Iterator[dict[str, Any]]:
    known = item.columns
    if item.summary is None or "kinetic_energy" not in known:
        return
    total = np.sum([known[name] for name in ENERGIES if name in known], axis=0)
    kept = total - np.sum([known[name] for name in LOST if name in known], axis=0)
    hourglass = known["hourglass_energy"][-1] if "hourglass_energy" in known else 0.0
    internal = total[-1] - known["kinetic_energy"][-1]
    added = [check["value"] for check in item.summary.get("checks", ()) if check["name"] == "added mass"]
    values = {
        "change of total energy": (abs(kept[-1] / kept[0] - 1.0), 0.10),
        "hourglass over initial energy": (hourglass / total[0], 0.05),
        "hourglass over internal energy": (hourglass / internal if internal else 0.0, 0.10),
        "added mass over mass": (added[0] if added else 0.0, 0.05),
    }
    for name, (value, limit) in values.items():
        yield {"name": name, "value": float(value), "limit": limit, "passed": bool(value < limit)}


def phenomena(found: Comparison) -> list[dict[str, Any]]:
    """Rows of what was validated and how: the largest force, and other quantities at the end of the common time."""
    rows = []
    for label, each in found.pairs:
        if each.name in POSITIONS:
            continue
        title, extreme = (
            WORDS.get(each.name, ("", f"Column {each.name}"))[1].partition(",")[0],
            each.name.startswith(("force", "reaction")),
        )
        both = each.reference, each.value
        reference, value = (float(np.abs(v).max() if extreme else v[-1]) for v in both)
        rows.append(
            {
                "item": label,
                "name": f"{title}, largest" if extreme else title,
                "reference": reference,
                "value": value,
                "unit": found.reference.units.get(each.name, ""),
                "difference": value / reference - 1.0 if reference else None,
                "agrees": yes(each.within),
                "how": f"history to {each.t[-1]:.4g} s, metrics",
            }
        )
    return rows


def with_validation(made: Report, found: Comparison, author: str) -> Report:
    """Report of the comparison with the page of its validation, and the numbers of that in its summary."""
    summary = {"multi_channel": multi_channel(found), "solution_verification": solution_verification(found)}
    texts = {PAGE: page_text(validation_page(found, author))}
    return replace(made, summary={**made.summary, **summary}, texts=texts)


def validation_page(found: Comparison, author: str = "") -> Page:
    """Page of the validation.

    Parameters
    ----------
    found : Comparison
        Results, of which the first is the reference.
    author : str
        Who validates; a blank to be filled in without it.

    Returns
    -------
    Page
        `passed`: solution verification and single channels are within the limits.
    """
    verified, weighted = solution_verification(found), multi_channel(found)
    passed = found.within and all(row["passed"] for row in verified)
    labels = ", ".join(item.label for item in found.items[1:])
    answer = "Valid" if passed else "Not valid"
    together = {True: "within", False: "beyond"}
    multi = "; ".join(f"{label} {together[each['within']]} them" for label, each in weighted.items())
    headline = Headline(
        f"Validation of {labels} with {found.reference.label}",
        f"{answer} by the criteria of NCHRP W179 for the channels below.",
        f"Weighted metrics of all channels with the same limits: {multi}." if multi else "",
    )
    sections = (
        Section("Basic information", tables=(_basic(author),), layout="half"),
        Section("Solution verification", tables=(_verification_table(found, verified),), layout="half"),
        Section(
            "Metrics of single channels and of all together",
            tables=(_metrics_table(found, weighted),),
            sentences=found.notes,
        ),
        Section("Phenomena", tables=(_phenomena_table(found),)),
    )
    return Page(
        "Validation by NCHRP W179",
        headline,
        sections,
        footer("summary.json"),
        passed=passed,
        checked="criteria",
    )


def _basic(author: str) -> Table:
    entries = {
        "Validated by": author or BLANK,
        "Date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "Program": f"tailslap {tailslap.__version__}, Python {platform.python_version()}, {platform.system()}",
    }
    return pairs(entries)


def _verification_table(found: Comparison, rows: Sequence[dict[str, Any]]) -> Table:
    heads = columns({"item": "Result", "name": "At the end of the run"})
    heads += columns({"value": "Value [%]"}, form=lambda ratio: f"{100.0 * ratio:.2g}")
    heads += columns({"limit": "Limit [%]"}, form=lambda ratio: f"{100.0 * ratio:g}")
    heads += (Column("passed", "Within", form=yes),)
    others = [item.label for item in found.items if item.label not in {row["item"] for row in rows}]
    notes = [
        "Limits: W179, Table E-1. The change excludes the work of friction and damping; mass is not scaled."
    ]
    notes += [f"Histories alone, to be verified in their program: {', '.join(others)}."] if others else []
    return Table(heads, rows, notes=(" ".join(notes),), marks=failed(rows, "passed"))


def yes(within: bool) -> str:
    """Word for a criterion."""
    return "yes" if within else "NO"


def failed(rows: Sequence[dict[str, Any]], key: str) -> dict[int, str]:
    """Marks of rows that are beyond a limit."""
    return {k: "failed" for k, row in enumerate(rows) if not row[key]}


def _metrics_table(found: Comparison, weighted: dict[str, dict[str, Any]]) -> Table:
    rows = []
    for label in dict.fromkeys(label for label, _ in found.pairs):
        weights = weighted.get(label, {}).get("weights", {})
        own = [each for name, each in found.pairs if name == label]
        rows += [
            {"item": label, "name": each.name, "weight": weights.get(each.name), **asdict(each.metrics)}
            | {"largest": each.largest[0], "covered": each.covered, "within": each.within}
            for each in own
        ]
        if weights:
            rows.append(
                {"item": label, "name": "weighted", "weight": 1.0, "largest": None, "covered": None}
                | weighted[label]
            )
    heads = (*METRICS[:2], Column("weight", "Weight", form=".3f"), *METRICS[2:])
    sizes = (100 * LIMITS[name] for name in ("magnitude", "mean_residual", "deviation"))
    limits = "{:.0f}, {:.0f} and {:.0f} %".format(*sizes)
    note = (
        f"In %; limits {limits} for Sprague-Geers M, P and C, mean and standard deviation of the residuals. Weight: "
        "largest change of momentum of the channel in the reference (angular velocity: over the radius of gyration); "
        f"weighted: mean of the sizes of the metrics. Time: compared part of the time of the reference, at least "
        f"{100 * COVERED:.0f} %. Channels are velocities, where W179 uses accelerations."
    )
    return Table(heads, rows, notes=(note,), marks=failed(rows, "within"))


def _phenomena_table(found: Comparison) -> Table:
    heads = (
        *columns({"item": "Result", "name": "Phenomenon"}),
        *columns({"reference": "Reference", "value": "Value"}, form=".4g", unit_key="unit"),
        Column("unit", "Unit", is_unit=True),
        Column("difference", "Difference", form=percent),
        *columns({"agrees": "Agrees", "how": "Validated by"}),
    )
    return Table(
        heads,
        phenomena(found),
        notes=(f"Values other than the largest: at the end of the common time. {NOT_IN_THE_MODEL}",),
    )
