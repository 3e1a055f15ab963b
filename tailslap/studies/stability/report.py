"""What the study of stability reports."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from itertools import combinations
from typing import Any

from postprocess.figures.plates import MapAxis, draw_map, draw_meanings
from postprocess.report.numbers import known
from postprocess.report.page import Section
from postprocess.report.report import Report
from postprocess.report.table import Column, Table, text_table
from postprocess.svg.chart import Chart
from tailslap.report.common import study_page, study_summary
from tailslap.scene.write import scene_file
from tailslap.studies.stability.against_reference import GOOD, WRONG_FROM
from tailslap.studies.stability.axes import Axis
from tailslap.studies.stability.campaign import Campaign
from tailslap.studies.stability.verdict import CAUGHT, RIGHT, WRONG
from tailslap.verification.checks import advice

MAP = "Stability on stiff and extreme cases: where the program is right, and where it says that it is not"
RANDOM = "Stability on scenes drawn at random: every quantity and every choice of the scene at once"
FILES = "cells.csv, every cell with its verdict; summary.json; cell-NUMBER.toml, cells to run again"
ADVISED = "what could be changed"
RANDOM_LIMIT = f"{WRONG_FROM[0]:g} and {100 * WRONG_FROM[1]:g} % of what the plate's flexibility changes"
AXES = (
    Column("name", "Axis"),
    Column("meaning", "What it is"),
    Column("values", "Range", form=lambda values: f"{values[0]:.3g} to {values[-1]:.3g}"),
)


SMALL = known(".1e")
LISTED = (
    Column("cell", "Cell"),
    Column("kind", "Verdict"),
    Column("why", "Failed checks, or why"),
    Column("distance", "Distance", form=SMALL),
    Column("allowed", "Allowed", form=SMALL),
    Column("error", "Own estimate", form=SMALL),
    Column("reference", "Flexibility", form=SMALL),
)


def stability_report(found: Campaign) -> Report:
    """Page, summary, table of cells, and random cells that matter as scene files."""
    said, name = headline(found), found.plan.scene.name
    page = study_page(
        found.plan,
        MAP if found.axes else RANDOM,
        said,
        (
            Section("Verdicts", tables=(_verdicts(found), Table(AXES, found.axes, "Axes"))),
            Section("A picture per pair of axes", figures=_maps(found), layout="narrow"),
            Section("Why", tables=(*_causes(found), _listed(found, LISTED, *found.listed))),
        ),
        FILES,
        not found.counts[WRONG],
    )
    title = f"{name}: {len(found.cells)} cells in {found.seconds:.0f} s"
    shown = (_verdicts(found, title), _listed(found, LISTED[:5], WRONG, GOOD))
    tables, texts = {"cells.csv": cells_table(found)}, scene_files(found)
    return Report(page, summary(found), (*shown, said), tables, texts=texts)


def headline(found: Campaign) -> str:
    """The result in two sentences."""
    counts, wrong = found.counts, found.counts[WRONG]
    limit = f"{found.settings['tolerance']:g}" if found.axes else RANDOM_LIMIT
    others = [f"{counts[kind]} {kind}" for kind in counts if kind not in (RIGHT, WRONG) and counts[kind]]
    ends = ", ".join([f"{counts[RIGHT]} are right to {limit}", *others])
    return f"Of {len(found.cells)} cells {ends}. {f'{wrong} are' if wrong else 'None is'} wrong without being caught."


def summary(found: Campaign) -> dict[str, Any]:
    """The numbers of the study."""
    return {
        **study_summary("stability" if found.axes else "stability, random", found.plan),
        "passed": not found.counts[WRONG],
        **found.settings,
        "cells": len(found.cells),
        "counts": found.counts,
        "axes": Table(AXES, found.axes).records(),
        "caught_by": found.caught_by,
        "wrong": _records(found, WRONG),
        "listed": _records(found, *found.listed),
        "cost": {"seconds": found.seconds},
    }


def cells_table(found: Campaign) -> Table:
    """Every cell with its verdict; an entry that a cell lacks is empty."""
    names = dict.fromkeys((name for cell in found.cells.values() for name in cell.entries), "")
    rows = [names | cell.entries | _verdict(found, key) for key, cell in found.cells.items()]
    return Table(tuple(Column(key, key) for key in rows[0]), rows)


def _verdict(found: Campaign, key: str) -> dict[str, Any]:
    its = found.verdicts[key]
    return {**asdict(its), ADVISED: advice(its.failed.split(", ")) if its.kind == CAUGHT else ""}


def scene_files(found: Campaign) -> dict[str, str]:
    """The cells that matter as scene files, to run again."""
    numbers = {key: number for number, key in enumerate(found.cells)}
    return {f"cell-{numbers[key]:04d}.toml": _scene_file(found, key) for key in found.of_kind(WRONG, GOOD)}


def _scene_file(found: Campaign, key: str) -> str:
    its, settings = (
        found.verdicts[key],
        ", ".join(f"{name} {value}" for name, value in found.settings.items()),
    )
    off = f"{its.distance:.1e} off, {its.allowed:.1e} allowed, own estimate {its.error:.1e}"
    title = f"Cell {key} from {found.plan.scene.name}, {settings}: {its.kind}; {off}; {its.why or 'no check failed'}"
    return scene_file(found.cells[key].tables, title)


def _records(found: Campaign, *kinds: str) -> list[dict[str, Any]]:
    return [{"cell": key, "why": its.why, **asdict(its)} for key, its in found.of_kind(*kinds).items()]


def _listed(found: Campaign, columns: tuple[Column, ...], *kinds: str) -> Table:
    return Table(columns, _records(found, *kinds), "Cells", ("Distance: from the refined model.",))


def _verdicts(found: Campaign, title: str = "") -> Table:
    columns = (Column("kind", "Verdict"), Column("meaning", "Meaning"), Column("cells", "Cells", form="d"))
    rows = [{"kind": k, "meaning": found.kinds[k], "cells": count} for k, count in found.counts.items()]
    return Table(columns, rows, title)


def _causes(found: Campaign) -> tuple[Table, Table]:
    alone = Counter(verdict.failed for verdict in found.of_kind(CAUGHT).values())
    caught = [(name, advice([name]), str(n), str(alone[name])) for name, n in found.caught_by.items()]
    refused = [(name, str(n)) for name, n in found.refused_by.items()]
    checks = text_table(
        "Check", ADVISED.capitalize(), "Cells", "Alone", rows=caught, texts=2, title="Caught by"
    )
    return checks, text_table("Key", "Cells", rows=refused, title="Refused by")


def _maps(found: Campaign) -> tuple[Chart, ...]:
    maps = tuple(_map(found, *pair) for pair in combinations(found.axes, 2))
    return maps and (draw_meanings(found.kinds, "What the colours mean, in every picture"), *maps)


def _map(found: Campaign, across: Axis, up: Axis) -> Chart:
    columns, rows = (MapAxis(axis.meaning, axis.values) for axis in (across, up))
    name = f"map-{across.name}-{up.name}".replace(" ", "-")
    caption = f"{up.name} over {across.name}".capitalize()
    return draw_map(name, columns, rows, found.map_of(across, up), caption)
