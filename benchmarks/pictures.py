"""Draw the pictures of docs/studies.md from results of `cost` and `stability`.

    .venv/bin/python benchmarks/pictures.py results/paper-table-3-cost results/paper-table-3-stability

A folder with points.csv makes docs/cost.svg, one with cells.csv docs/stability.svg; --out DIR writes elsewhere.
"""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import command_line
from command_line import ROOT

from postprocess.figures.plates import MapAxis, draw_map, draw_meanings
from postprocess.svg.chart import Chart
from tailslap.scene.read import read_scene
from tailslap.studies.cost.cost_report import RIGID, SOFT, charts
from tailslap.studies.stability.cell_verdicts import MAP_KINDS
from tailslap.studies.stability.stability_axes import axes_of

SHOWN = (
    *(("stiffness", name) for name in ("penalty", "friction", "speed", "angle", "slenderness", "damping")),
    *(("penalty", "speed"), ("friction", "damping")),
)
"""Pairs of axes that docs/studies.md shows."""
MEANINGS = {axis.name: axis.meaning for axis in axes_of(read_scene("paper-table-3")[0], 2)}
WORDS, TRUTHS = ("setting", "kind", "group", "label", "failed", "refused"), ("soft", "choice")
"""Columns of points.csv that are no numbers."""


def draw_cost(folder: Path, target: Path) -> None:
    """Draw error over run time for rigid and flexible plates."""
    certainty = json.loads((folder / "summary.json").read_text())["known"]
    rows = [
        {key: _value(key, text) for key, text in row.items()} for row in read_table(folder / "points.csv")
    ]
    rigid, soft = ([row for row in rows if row["soft"] == is_soft] for is_soft in (False, True))
    panels = (
        charts(RIGID, rigid, certainty["rigid"]),
        charts(SOFT, soft, certainty["flexible"], certainty["choices"]),
    )
    target.write_text(side_by_side([*panels[0], *panels[1]], 1), encoding="utf-8")


def side_by_side(charts: list[Chart], across: int = 3) -> str:
    """Return charts in rows, as one SVG."""
    heights = [float(re.findall(r'height="(\d+)"', chart.svg)[0]) for chart in charts]
    tall, wide = max(heights) + 16.0, max(chart.width for chart in charts) + 20.0
    placed = [
        chart.svg.replace("<svg ", f'<svg x="{number % across * wide}" y="{number // across * tall}" ', 1)
        for number, chart in enumerate(charts)
    ]
    size = f"{across * wide:.0f} {-(-len(charts) // across) * tall:.0f}"
    style = 'font-family="system-ui, DejaVu Sans, sans-serif"'
    paper = '<rect width="100%" height="100%" fill="#fff"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size}" {style}>{paper}{"".join(placed)}</svg>\n'


def draw_stability(folder: Path, target: Path) -> None:
    """Draw the maps of a folder, below the meaning of colours."""
    maps = read_maps(folder / "cells.csv")
    charts = [draw_map("-".join(pair), *maps[pair], "") for pair in SHOWN if pair in maps]
    target.write_text(side_by_side([*charts, draw_meanings(MAP_KINDS, "")]), encoding="utf-8")


def read_maps(path: Path) -> dict[tuple[str, str], tuple[MapAxis, MapAxis, list[list[str]]]]:
    """Return the maps of the study `stability` by their axes."""
    cells: dict[tuple[str, str], dict[tuple[float, float], str]] = {}
    for row in read_table(path):
        place = (float(row["first_value"]), float(row["second_value"]))
        cells.setdefault((row["first"], row["second"]), {})[place] = row["kind"]
    maps = {}
    for pair, kinds in cells.items():
        across, up = (sorted({place[number] for place in kinds}) for number in (0, 1))
        axes = (
            MapAxis(MEANINGS.get(name, name), values) for name, values in zip(pair, (across, up), strict=True)
        )
        maps[pair] = (*axes, [[kinds[x, y] for x in across] for y in up])
    return maps  # type: ignore[return-value]


def read_table(path: Path) -> list[dict[str, str]]:
    """Return the rows of a table of a result folder."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _value(key: str, text: str) -> Any:
    if key in TRUTHS:
        return text == "True"
    return text if key in WORDS else float(text or "nan")


PICTURES = (("points.csv", "cost.svg", draw_cost), ("cells.csv", "stability.svg", draw_stability))


def main() -> None:
    """Draw the pictures of the folders."""
    options = command_line.options(__doc__, ("folders", []), out=str(ROOT / "docs"))
    for folder in map(Path, options.folders):
        for table, name, draw in PICTURES:
            if (folder / table).is_file():
                draw(folder, Path(options.out) / name)
                print(Path(options.out) / name)


if __name__ == "__main__":
    main()
