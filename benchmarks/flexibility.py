"""Levels of the study of flexibility at further first frequencies.

    tailslap study flexibility SCENE --out FOLDER
    .venv/bin/python benchmarks/flexibility.py SCENE FOLDER [COUNT [SEED]]

For each level: COUNT random first frequencies (40) from the printed one to twice that, the largest difference there,
and the highest frequency at which the level is exceeded, over all runs beyond half the printed one. Exit status 1 if a
difference is above its level at or beyond the printed frequency.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import command_line
import numpy as np

from postprocess.units import rounded_up
from tailslap.campaign.levels import CROSSED, NOT_REACHED, Reach
from tailslap.case import case_of
from tailslap.case.corner.corner_case import CornerCase
from tailslap.case.impact.case import ImpactCase
from tailslap.scene.read import read_scene
from tailslap.studies.flexibility import corner_flexibility, impact_flexibility, plate_runs

COUNT = 40
"""Runs beyond each printed frequency."""
BELOW = 0.5
"""The lowest frequency at which runs are made, over the printed one: to see how far it is on the safe side."""


def stated(summary: dict[str, Any]) -> Iterator[tuple[str, str, Reach]]:
    """Start, quantity and level of each statement."""
    if "levels_v_gy" not in summary:
        yield from (("", name, Reach(**level)) for name, rows in summary["levels"].items() for level in rows)
        return
    for start, rows in summary["levels_v_gy"].items():
        yield from ((start, "v_gy", Reach(**level)) for level in rows)
    for name, rows in summary["levels"].items():
        yield from ((corner_flexibility.STARTS[0], name, Reach(**level)) for level in rows)


def differences(scene: str, plate: tuple[str, float]) -> dict[str, float]:
    """Differences of a plate by quantity.

    plate: start and first frequency [Hz].
    """
    case, (start, frequency) = case_of(*read_scene(scene)), plate
    if isinstance(case, CornerCase):
        sweep = corner_flexibility.define(case)
        changed = corner_flexibility.run_changes(sweep, frequency, sweep.meshes[-1], start)
        of_start = corner_flexibility.scan_changes(changed)
        run = plate_runs.one_run(case.source, of_start, corner_flexibility.fe_record)
        return corner_flexibility.scan_row(run, case.tail_slap)
    assert isinstance(case, ImpactCase)
    mesh = impact_flexibility.mesh_changes(case.plan())
    changes = {**mesh, "plate.first_frequency": frequency, "verify.companion": False}
    record = plate_runs.one_run(case.source, changes, impact_flexibility.strike_record)
    return impact_flexibility.strike_differences(record)


def main(scene: str, folder: str, count: int = COUNT, seed: int = 1) -> int:
    """Print each level, and return the exit status."""
    random = np.random.default_rng(seed)
    summary = json.loads((Path(folder) / "summary.json").read_text())
    determined = [level for level in stated(summary) if level[2].kind in (CROSSED, NOT_REACHED)]
    plates: set[tuple[str, float]] = set()
    for start, _, reach in determined:
        printed = rounded_up(reach.frequency)
        drawn = [*random.uniform(printed, 2.0 * printed, count - 1), printed]
        plates |= {(start, float(frequency)) for frequency in drawn}
    runs = command_line.on_all_cores(partial(differences, scene), plates, chunk=8)
    rows = dict(zip(plates, runs, strict=True))
    wrong, print_line = 0, "{:22} {:22} {:>6} {:>10} {:>5} {:>9} {:>10} {:>6}".format
    print(print_line("start", "quantity", "level", "printed", "runs", "largest", "exceeded", "ok"))
    for start, name, reach in determined:
        printed = rounded_up(reach.frequency)
        sizes = {
            f: abs(row[name])
            for (plate_start, f), row in rows.items()
            if plate_start == start and f >= BELOW * printed
        }
        beyond = [size for f, size in sizes.items() if f >= printed and np.isfinite(size)]
        exceeded = max((f for f, size in sizes.items() if size > reach.level), default=np.nan)
        ok = max(beyond) <= reach.level
        wrong += not ok
        numbers = f"{printed:.3g} Hz", len(beyond), f"{100 * max(beyond):.3g} %", f"{exceeded:.4g} Hz"
        print(print_line(start, name, f"{100 * reach.level:g} %", *numbers, "yes" if ok else "NO"))
    print(f"{len(determined)} levels, {len(rows)} runs: {wrong} levels exceeded beyond the printed frequency")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(**vars(command_line.options(__doc__, "scene", "folder", ("count", COUNT), ("seed", 1)))))
