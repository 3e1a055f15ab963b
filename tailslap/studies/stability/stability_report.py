"""Report of the study `stability`."""

import heapq
import math
from collections import Counter
from collections.abc import Iterable
from itertools import combinations
from operator import itemgetter

from postprocess.figures.plates import MapAxis, draw_map, draw_meanings
from postprocess.report.command_report import Report
from postprocess.report.page import Headline, Section
from postprocess.report.tables import Column, Table, columns
from postprocess.svg.chart import Chart
from postprocess.units import known
from tailslap.campaign.records import Record
from tailslap.case.check import advice
from tailslap.case.corner.corner_checks import CHECKS
from tailslap.case.impact import checks as impact_checks
from tailslap.case.report_parts import study_page, study_summary
from tailslap.scene import vary, write
from tailslap.studies.stability import cell_verdicts
from tailslap.studies.stability.cell_verdicts import CAUGHT, GOOD, REFUSED, UNKNOWN, WRONG
from tailslap.studies.stability.stability_axes import cell_key
from tailslap.studies.stability.stability_study import StabilityResult

MAP = "Verdicts on stiff and extreme cases"
RANDOM = "Verdicts on random scenes"
FILES = "cells.csv (all cells with verdicts); summary.json; cell-NUMBER.toml (scenes of cells)"
ADVISED = "what could be changed"
APART, PART = cell_verdicts.WRONG_FROM
RANDOM_LIMIT = f"{APART:g} and {100 * PART:g} % of the effect of flexibility"
WORDS = {
    cell_verdicts.RIGHT: "correct",
    cell_verdicts.FLEXIBLE: "flexible, confirmed by refinement",
    REFUSED: "refused as invalid",
    CAUGHT: "rejected by the checks",
    cell_verdicts.REACTION_ONLY: "correct except for the reaction",
    GOOD: "correct but rejected",
    cell_verdicts.UNJUDGED: "undecided",
}
"""Verdicts in the headline."""

AXES = (
    *columns({"name": "Axis", "meaning": "Quantity"}),
    Column("values", "Range", form=lambda values: f"{values[0]:.3g} to {values[-1]:.3g}"),
)
VERDICTS = (Column("kind", "Verdict"), Column("meaning", "Meaning"), Column("cells", "Cells", form="d"))
REJECTIONS = (
    *columns({"0": "Check", "1": ADVISED.capitalize()}),
    *columns({"2": "Cells", "3": "Alone"}, form="d"),
)
REFUSALS = Column("0", "Key"), Column("1", "Cells", form="d")
SMALL = known(".1e")
COSTLIEST = 10
"""Number of cells in the table of cost."""
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


def report(result: StabilityResult) -> Report:
    """Return page, summary and table of cells.

    Wrong cells are written as scene files, so that they can be run again.
    """
    name, numbers_of_kind = result.case.scene.name, counts(result)
    verdicts = [
        {"kind": k, "meaning": result.kinds[k], "cells": count} for k, count in numbers_of_kind.items()
    ]
    title = f"{name}: {len(result.rows)} cells in {result.seconds:.0f} s"
    checks = Counter(row["failed"] for row in result.of_kind(CAUGHT).values())
    impact = result.case.scene.contact is not None
    caught = [(name, advised([name], impact), n, checks[name]) for name, n in caught_by(result).items()]
    reasons = (
        Table(REJECTIONS, caught, "Rejections by check"),
        Table(REFUSALS, [*refused_by(result).items()], "Refusals by key"),
        _listed(result, LISTED, *listed_kinds(result)),
    )
    sections = (
        Section("Verdicts", tables=(Table(VERDICTS, verdicts), Table(AXES, result.axes, "Axes"))),
        Section("Maps", figures=maps(result), layout="narrow"),
        Section("Reasons", tables=reasons),
        Section("Cost", tables=(costliest(result),)),
    )
    opening, kicker = headline(result), MAP if result.axes else RANDOM
    page = study_page(result.case, kicker, opening, sections, FILES, not numbers_of_kind[WRONG])
    named = (WRONG, GOOD if GOOD in result.kinds else cell_verdicts.UNJUDGED)
    terminal = (Table(VERDICTS, verdicts, title), _listed(result, LISTED[:5], *named))
    places = {key: number for number, key in enumerate(result.rows)}
    texts = {f"cell-{places[key]:04d}.toml": _scene_file(result, key) for key in result.of_kind(WRONG, GOOD)}
    return Report(page, summary(result), terminal, {"cells.csv": cells_table(result)}, texts=texts)


def counts(result: StabilityResult) -> dict[str, int]:
    """Return the number of cells by verdict."""
    return {kind: len(result.of_kind(kind)) for kind in result.kinds}


def caught_by(result: StabilityResult) -> dict[str, int]:
    """Return the number of cells that each check rejected, falling."""
    caught = result.of_kind(CAUGHT).values()
    return dict(Counter(name for row in caught for name in row["failed"].split(", ")).most_common())


def refused_by(result: StabilityResult) -> dict[str, int]:
    """Return the number of refused cells by reason, falling.

    A reason is the key, with the allowed values unless they contain numbers.
    """
    names: Counter[str] = Counter()
    for row in result.of_kind(REFUSED).values():
        key, _, rest = row["reason"].partition(": given ")
        allowed = rest.partition("; ")[2]
        names[key if any(map(str.isdigit, allowed[:60])) else f"{key}: {allowed}"] += 1
    return dict(names.most_common())


def listed_kinds(result: StabilityResult) -> tuple[str, ...]:
    """Return the verdicts whose cells are listed.

    Random cells are valid individually, so that their refusals are listed.
    """
    return (WRONG, GOOD, cell_verdicts.UNJUDGED, *(() if result.axes else (REFUSED,)))


def headline(result: StabilityResult) -> Headline:
    """Return the headline with numbers of cells."""
    number, case = counts(result), result.case
    parts = [f"{n} {WORDS[kind]}" for kind, n in number.items() if n and kind != WRONG]
    answer = f"{len(result.rows)} cells: {', '.join(parts)}, {number[WRONG] or 'none'} wrong and undetected."
    limit, judge = RANDOM_LIMIT, "a refined model of the same plate"
    if "tolerance" in result.settings:
        limit, judge = f"{result.settings['tolerance']:g}", "the rigid motion or a refined model"
    certainty = f"Correct: within {limit} of {judge}."
    return Headline(f"Stability: {case.subject}", answer, case.set_up, certainty)


def summary(result: StabilityResult) -> Record:
    """Return the numbers of the study."""
    return {
        **study_summary("stability" if result.axes else "stability, random", result.case),
        "passed": not counts(result)[WRONG],
        **result.settings,
        "cells": len(result.rows),
        "counts": counts(result),
        "axes": Table(AXES, result.axes).records(),
        "caught_by": caught_by(result),
        "wrong": _records(result, WRONG),
        "listed": _records(result, *listed_kinds(result)),
        "cost": {
            "seconds": result.seconds,
            "processor_seconds": processor_seconds(result),
            "costliest": costliest(result).records(),
        },
    }


def processor_seconds(result: StabilityResult) -> float:
    """Return the processor time of all cells [s]."""
    return math.fsum(row["processor_seconds"] for row in result.rows.values())


def costliest(result: StabilityResult) -> Table:
    """Return the table of cells with most processor time."""
    total = processor_seconds(result)
    rows = [
        {"cell": key, **row, "share": row["processor_seconds"] / total if total else 0.0}
        for key, row in result.rows.items()
    ]
    rows = heapq.nlargest(COSTLIEST, rows, key=itemgetter("processor_seconds"))
    share = math.fsum(row["share"] for row in rows)
    note = (
        f"Processor time of all {len(result.rows)} cells: {total:.3g} s; these {len(rows)} take {share:.0%}."
    )
    return Table(COST, rows, "Costliest cells", (note,))


def cells_table(result: StabilityResult) -> Table:
    """Return the table of all cells, with empty missing entries."""
    places = dict.fromkeys((name for row in result.rows.values() for name in row if name not in UNKNOWN), "")
    rows = []
    for row in result.rows.values():
        impact = result.case.scene.contact is not None
        advice_text = advised(row["failed"].split(", "), impact) if row["kind"] == CAUGHT else ""
        rows.append({**places, **UNKNOWN, **row, ADVISED: advice_text})
    return Table(tuple(Column(key, key) for key in rows[0]), rows)


def advised(failed: Iterable[str], impact: bool = False) -> str:
    """Return the advice of failed checks.

    `impact` selects those of a whole impact.
    """
    kinds = {kind.name: kind for kind in (impact_checks.CHECKS.values() if impact else CHECKS.values())}
    return advice(kinds[name].advice for name in failed if name in kinds)


def _scene_file(result: StabilityResult, key: str) -> str:
    """Return the scene of a cell as TOML."""
    row, settings = result.rows[key], ", ".join(f"{name} {value}" for name, value in result.settings.items())
    off = f"difference {row['distance']:.1e}, limit {row['allowed']:.1e}, estimated error {row['error']:.1e}"
    why = row["failed"] or row["reason"] or "no check failed"
    title = f"Cell {key} from {result.case.scene.name}, {settings}: {row['kind']}; {off}; {why}"
    return write.scene_file(vary.changed_tables(result.base.tables, result.cells[key])[0], title)


def _records(result: StabilityResult, *kinds: str) -> list[Record]:
    """Return the cells with these verdicts for a summary."""
    return [
        {"cell": key, "why": row["failed"] or row["reason"]} | {name: row[name] for name in UNKNOWN}
        for key, row in result.of_kind(*kinds).items()
    ]


def _listed(result: StabilityResult, heads: tuple[Column, ...], *kinds: str) -> Table:
    """Return the table of cells with these verdicts."""
    return Table(heads, _records(result, *kinds), "Cells", ("Distance: difference from the refined model.",))


def maps(result: StabilityResult) -> tuple[Chart, ...]:
    """Return the maps of all pairs of axes."""
    charts = [draw_meanings(result.kinds, "Colours of all maps")] if result.axes else []
    for across, up in combinations(result.axes, 2):
        points = [[{across.name: x, up.name: y} for x in across.values] for y in up.values]
        kinds = [[result.rows[cell_key(point)]["kind"] for point in row] for row in points]
        axes = MapAxis(across.meaning, across.values), MapAxis(up.meaning, up.values)
        name = f"map-{across.name}-{up.name}".replace(" ", "-")
        charts.append(draw_map(name, *axes, kinds, f"{up.name} over {across.name}".capitalize()))
    return tuple(charts)
