"""Map of stiff and extreme cases, or random scenes.

The map varies two axes at a time and compares each cell with the rigid motion. A cell whose run would take too long is
omitted and counted. Random cells vary all quantities and choices of the scene together, and are compared with refined
models. Of a whole impact, they vary all quantities near those of the scene and are compared as on the map.
"""

import math
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from tailslap.campaign import engine
from tailslap.campaign.random_scenes import draw
from tailslap.campaign.records import Record
from tailslap.case import case_of
from tailslap.case.case import Case
from tailslap.case.impact.plan import chosen_plate
from tailslap.case.resources import expected_effort
from tailslap.errors import InputError
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, Source, changed_tables, vary
from tailslap.studies.stability import cell_verdicts
from tailslap.studies.stability.cell_verdicts import LONGEST_S, judge
from tailslap.studies.stability.stability_axes import StudyAxis, axes_of, map_cells

CELL_S, LOOPS = 0.2, 2.0
"""Processor time of a cell without its loop [s], and time of all its loops over the estimate for its run.

The second includes the loops of companions and starts. Measured on random cells of paper-table-3.
"""

SLENDER = 0.05
"""Width over length below which the program chooses quadratic elements, on the map of paper-table-3."""

PENALTY_STEPS = 0.5
"""Steps with a penalty over those without, divided by the root of its scale; measured at scales of 46 to 10 000."""


class StabilityResult(NamedTuple):
    """Result of the study.

    Attributes
    ----------
    axes : tuple of StudyAxis
        Axes of the map, none of random cells.
    settings : dict
        Points and tolerance of the map, or seed.
    kinds : dict of str
        Kinds of verdicts and their meanings.
    cells : dict of dict
        Changes of each cell in the base.
    rows : dict of dict
        Place or drawn values of each cell, and its verdict.
    """

    case: Case
    base: Source
    axes: tuple[StudyAxis, ...]
    settings: Mapping[str, float]
    kinds: Mapping[str, str]
    cells: Mapping[str, Changes]
    rows: Mapping[str, Record]
    seconds: float

    def of_kind(self, *kinds: str) -> dict[str, Record]:
        """Return the rows with these verdicts."""
        return {key: row for key, row in self.rows.items() if row["kind"] in kinds}


def compute(
    case: Case,
    place: Path,
    points: int | None,
    tolerance: float | None,
    count: int | None,
    seed: int,
    workers: int | None,
) -> StabilityResult:
    """Compute the map, or random cells.

    An interrupted campaign resumes from its journal. Raises InputError for an option without effect.
    """
    began, scene = time.perf_counter(), case.scene
    if count and points:
        raise InputError("--points", points, "random scenes have no map; remove --points or --random")
    if count and tolerance and not scene.contact:
        allowed = "random scenes are compared with refined models within their stated errors; remove it"
        raise InputError("--tolerance", tolerance, allowed)
    base, defaults = base_source(scene), (6, 1e-2) if scene.contact else (10, 1e-3)
    limit: Record = {"tolerance": tolerance or defaults[1]}
    kinds, verify = cell_verdicts.MAP_KINDS, partial[Record](cell_verdicts.against_rigid, **limit)
    if count and not scene.contact:
        kinds, verify, limit = cell_verdicts.RANDOM_KINDS, partial(cell_verdicts.against_reference), {}
    axes: tuple[StudyAxis, ...] = ()
    if count:
        settings: Record = {"seed": seed, **limit}  # without the number of cells, so that more can follow
        cells, places = random_cells(scene, base, seed, count)
    else:
        settings = {"points": points or defaults[0], **limit}
        axes = axes_of(scene, settings["points"])
        cells, places = map_cells(scene, axes)
    definition = {"study": "stability", "scene": base.tables, **settings}
    parts = {key: (base, changes, verify) for key, changes in cells.items()}
    expected = {} if count else expected_seconds(case, base, cells)
    group = judge, parts, f"{len(cells)} cells"
    verdicts = engine.run_study(place, definition, group, workers, expected)
    rows = {key: places[key] | row for key, row in verdicts.items()}
    return StabilityResult(case, base, axes, settings, kinds, cells, rows, time.perf_counter() - began)


def base_source(scene: Scene) -> Source:
    """Return the scene in SI without its wall.

    Cells slide along it by different lengths.
    """
    return vary(Source.of(scene), {"wall": None})[1]


def expected_seconds(case: Case, base: Source, cells: Mapping[str, Changes]) -> dict[str, float]:
    """Return the estimated processor time of each cell [s]."""
    return {key: CELL_S + _loop_seconds(case, base, changes) for key, changes in cells.items()}


def _loop_seconds(usual: Case, base: Source, changes: Changes) -> float:
    """Return the estimated time of a cell's loop [s].

    It is 0 where the cell is refused or omitted.
    """
    try:
        scene, source = vary(base, changes)
        plate = chosen_plate(scene, 0)[0] if scene.contact else scene.needed_plate
        duration = _impact_duration(usual, scene) if scene.contact else case_of(scene, source).duration
    except Exception:  # reported with the verdict of the cell
        return 0.0
    if "element" not in plate.model_fields_set:
        slender = not scene.contact and scene.vehicle.width < SLENDER * scene.vehicle.length
        plate = plate.model_copy(update={"element": "quad9" if slender else "quad4"})
    effort = expected_effort(scene.model_copy(update={"plate": plate}), duration)
    penalty = (scene.contact or scene.corner).penalty_scale or 0.0
    seconds = effort.seconds * max(1.0, PENALTY_STEPS * math.sqrt(penalty))
    return LOOPS * seconds if seconds <= LONGEST_S else 0.0


def _impact_duration(usual: Case, scene: Scene) -> float:
    """Estimate the duration of a whole impact [s]."""
    if not (usual.scene.impact and scene.impact):
        return 0.0
    return usual.duration * usual.scene.impact.speed / scene.impact.speed


def random_cells(
    scene: Scene, base: Source, seed: int, count: int
) -> tuple[dict[str, Changes], dict[str, Record]]:
    """Return changes and values of random cells."""
    cells = {f"{number:04d}": draw(scene, base, seed, number) for number in range(count)}
    tables = {key: changed_tables(base.tables, changes)[0] for key, changes in cells.items()}
    return cells, {key: {"number": int(key), **flat(table)} for key, table in tables.items()}


def flat(tables: Mapping[str, Any]) -> Record:
    """Return the values of a scene by dotted key."""
    inner = [(name, table) for name, table in tables.items() if isinstance(table, dict)]
    inner += [(f"trailer.{number}", table) for number, table in enumerate(tables.get("trailer", ()))]
    return dict(sorted((f"{name}.{key}", value) for name, table in inner for key, value in table.items()))
