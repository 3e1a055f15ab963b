"""Report of the study `stability`."""

import heapq
import math
from collections import Counter
from collections.abc import Iterable
from itertools import combinations
from operator import itemgetter
from typing import Any

from postprocess.figures.plates import MapAxis, draw_map, draw_meanings
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns, text_table
from postprocess.svg.chart import Chart
from postprocess.units import known
from tailslap.case.case import advice
from tailslap.case.corner.checks import CHECKS
from tailslap.case.impact import checks as impact_checks
from tailslap.case.report import study_page, study_summary
from tailslap.scene import vary, write
from tailslap.studies.stability import compute
from tailslap.studies.stability.axes import cell_key
from tailslap.studies.stability.compute import CAUGHT, GOOD, REFUSED, UNKNOWN, WRONG, Row, StabilityResult

MAP = "Verdicts on stiff and extreme cases"
RANDOM = "Verdicts on random scenes"
FILES = "cells.csv (all cells with verdicts); summary.json; cell-NUMBER.toml (scenes of cells)"
ADVISED = "what could be changed"
APART, PART = compute.WRONG_FROM
RANDOM_LIMIT = f"{APART:g} and {100 * PART:g} % of the effect of flexibility"
WORDS = {
    compute.RIGHT: "correct",
    compute.FLEXIBLE: "flexible, confirmed by refinement",
    REFUSED: "refused as invalid",
    CAUGHT: "rejected by the checks",
    compute.REACTION_ONLY: "correct except for the reaction",
    GOOD: "correct but rejected",
    compute.UNJUDGED: "undecided",
}
"""Verdicts in the headline."""

AXES = (
    *columns({"name": "Axis", "meaning": "Quantity"}),
    Column("values", "Range", form=lambda values: f"{values[0]:.3g} to {values[-1]:.3g}"),
)
VERDICTS = (Column("kind", "Verdict"), Column("meaning", "Meaning"), Column("cells", "Cells", form="d"))
SMALL = known(".1e")
COSTLIEST = 10
"""Cells that the table of cost shows."""
COST = (
    *columns({"cell": "Cell", "kind": "Verdict", "model": "Elements"}),
    Column("steps", "Steps", form="d"),
    Column("processor_seconds", "Processor time [s]", form=".3g"),
    Column("share", "Share", form=".1%"),
)
LISTED = (
    *columns({"cell": "Cell", "kind": "Verdict", "why": "Failed checks or reason"}),
    *columns({"distance": "Distance", "allowed": "Allowed"}, form=SMALL),
    *columns({"error": "Estimated error", "reference": "Flexibility"}, form=SMALL),
)


def report(found: StabilityResult) -> Report:
    """Page, summary, table of cells, and cells that matter as scene files, to run again."""
    name, counted = found.case.scene.name, counts(found)
    verdicts = [{"kind": k, "meaning": found.kinds[k], "cells": count} for k, count in counted.items()]
    title = f"{name}: {len(found.rows)} cells in {found.seconds:.0f} s"
    checks = Counter(row["failed"] for row in found.of_kind(CAUGHT).values())
    impact = found.case.scene.contact is not None
    caught = [
        (name, advised([name], impact), str(n), str(checks[name])) for name, n in caught_by(found).items()
    ]
    refused = [(key, str(n)) for key, n in refused_by(found).items()]
    why = (
        text_table(
            "Check", ADVISED.capitalize(), "Cells", "Alone", rows=caught, texts=2, title="Rejections by check"
        ),
        text_table("Key", "Cells", rows=refused, title="Refusals by key"),
        _listed(found, LISTED, *listed_kinds(found)),
    )
    sections = (
        Section("Verdicts", tables=(Table(VERDICTS, verdicts), Table(AXES, found.axes, "Axes"))),
        Section("Maps", figures=maps(found), layout="narrow"),
        Section("Reasons", tables=why),
        Section("Cost", tables=(costliest(found),)),
    )
    opening, kicker = headline(found), MAP if found.axes else RANDOM
    page = study_page(found.case, kicker, opening, sections, FILES, not counted[WRONG])
    named = (WRONG, GOOD if GOOD in found.kinds else compute.UNJUDGED)
    shown = (Table(VERDICTS, verdicts, title), _listed(found, LISTED[:5], *named))
    numbers = {key: number for number, key in enumerate(found.rows)}
    texts = {f"cell-{numbers[key]:04d}.toml": _scene_file(found, key) for key in found.of_kind(WRONG, GOOD)}
    return Report(page, summary(found), shown, {"cells.csv": cells_table(found)}, texts=texts)


def counts(found: StabilityResult) -> dict[str, int]:
    """Number of cells by verdict."""
    return {kind: len(found.of_kind(kind)) for kind in found.kinds}


def caught_by(found: StabilityResult) -> dict[str, int]:
    """Number of cells that each check caught, the most first."""
    caught = found.of_kind(CAUGHT).values()
    return dict(Counter(name for row in caught for name in row["failed"].split(", ")).most_common())


def refused_by(found: StabilityResult) -> dict[str, int]:
    """Number of cells by reason of refusal, the most first: the key and, unless it has numbers, what is allowed."""
    names: Counter[str] = Counter()
    for row in found.of_kind(REFUSED).values():
        key, _, rest = row["reason"].partition(": given ")
        allowed = rest.partition("; ")[2]
        names[key if any(map(str.isdigit, allowed[:60])) else f"{key}: {allowed}"] += 1
    return dict(names.most_common())


def listed_kinds(found: StabilityResult) -> tuple[str, ...]:
    """Kinds whose cells are listed; what is drawn is valid by itself, so that a refusal needs its reason."""
    return (WRONG, GOOD, compute.UNJUDGED) if found.axes else (WRONG, GOOD, compute.UNJUDGED, REFUSED)


def headline(found: StabilityResult) -> Headline:
    """Numbers of cells by verdict, the scene, and the limit up to which a cell is correct."""
    number, case = counts(found), found.case
    parts = [f"{n} {WORDS[kind]}" for kind, n in number.items() if n and kind != WRONG]
    answer = f"{len(found.rows)} cells: {', '.join(parts)}, {number[WRONG] or 'none'} wrong and undetected."
    limit, judge = RANDOM_LIMIT, "a refined model of the same plate"
    if "tolerance" in found.settings:
        limit, judge = f"{found.settings['tolerance']:g}", "the rigid motion or a refined model"
    certainty = f"Correct: within {limit} of {judge}."
    return Headline(f"Stability: {case.subject}", answer, case.set_up, certainty)


def summary(found: StabilityResult) -> dict[str, Any]:
    """The numbers of the study."""
    return {
        **study_summary("stability" if found.axes else "stability, random", found.case),
        "passed": not counts(found)[WRONG],
        **found.settings,
        "cells": len(found.rows),
        "counts": counts(found),
        "axes": Table(AXES, found.axes).records(),
        "caught_by": caught_by(found),
        "wrong": _records(found, WRONG),
        "listed": _records(found, *listed_kinds(found)),
        "cost": {
            "seconds": found.seconds,
            "processor_seconds": processor_seconds(found),
            "costliest": costliest(found).records(),
        },
    }


def processor_seconds(found: StabilityResult) -> float:
    """Return the processor time of all cells [s]."""
    return math.fsum(row["processor_seconds"] for row in found.rows.values())


def costliest(found: StabilityResult) -> Table:
    """Return the cells that took most processor time, and their shares in all of it."""
    total = processor_seconds(found)
    rows = [
        {"cell": key, **row, "share": row["processor_seconds"] / total if total else 0.0}
        for key, row in found.rows.items()
    ]
    rows = heapq.nlargest(COSTLIEST, rows, key=itemgetter("processor_seconds"))
    share = math.fsum(row["share"] for row in rows)
    note = (
        f"Processor time of all {len(found.rows)} cells: {total:.3g} s; these {len(rows)} take {share:.0%}."
    )
    return Table(COST, rows, "Costliest cells", (note,))


def cells_table(found: StabilityResult) -> Table:
    """Every cell with its verdict; an entry that a cell lacks is empty."""
    places = dict.fromkeys((name for row in found.rows.values() for name in row if name not in UNKNOWN), "")
    rows = []
    for row in found.rows.values():
        impact = found.case.scene.contact is not None
        told = advised(row["failed"].split(", "), impact) if row["kind"] == CAUGHT else ""
        rows.append({**places, **UNKNOWN, **row, ADVISED: told})
    return Table(tuple(Column(key, key) for key in rows[0]), rows)


def advised(failed: Iterable[str], impact: bool = False) -> str:
    """Advice on the checks of a constrained corner, or of a whole impact, by their names."""
    kinds = {kind.name: kind for kind in (impact_checks.CHECKS if impact else CHECKS.values())}
    return advice(kinds[name].advice for name in failed if name in kinds)


def _scene_file(found: StabilityResult, key: str) -> str:
    row, settings = found.rows[key], ", ".join(f"{name} {value}" for name, value in found.settings.items())
    off = f"difference {row['distance']:.1e}, limit {row['allowed']:.1e}, estimated error {row['error']:.1e}"
    why = row["failed"] or row["reason"] or "no check failed"
    title = f"Cell {key} from {found.case.scene.name}, {settings}: {row['kind']}; {off}; {why}"
    return write.scene_file(vary.changed_tables(found.base.given, found.cells[key])[0], title)


def _records(found: StabilityResult, *kinds: str) -> list[Row]:
    return [
        {"cell": key, "why": row["failed"] or row["reason"]} | {name: row[name] for name in UNKNOWN}
        for key, row in found.of_kind(*kinds).items()
    ]


def _listed(found: StabilityResult, shown: tuple[Column, ...], *kinds: str) -> Table:
    return Table(shown, _records(found, *kinds), "Cells", ("Distance: difference from the refined model.",))


def maps(found: StabilityResult) -> tuple[Chart, ...]:
    """A picture of every pair of axes, and before them what the colours mean."""
    charts = [draw_meanings(found.kinds, "Colours of all maps")] if found.axes else []
    for across, up in combinations(found.axes, 2):
        points = [[{across.name: x, up.name: y} for x in across.values] for y in up.values]
        kinds = [[found.rows[cell_key(point)]["kind"] for point in row] for row in points]
        axes = MapAxis(across.meaning, across.values), MapAxis(up.meaning, up.values)
        name = f"map-{across.name}-{up.name}".replace(" ", "-")
        charts.append(draw_map(name, *axes, kinds, f"{up.name} over {across.name}".capitalize()))
    return tuple(charts)
