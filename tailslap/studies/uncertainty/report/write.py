"""Writes the study's result folder: page, summary, combinations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import tailslap
from postprocess.figures.uncertainty_plots import Histogram, Sensitivity, draw_histogram, draw_sensitivity
from postprocess.files.histories import write_history
from postprocess.files.summary import write_summary
from postprocess.pages.report import Result
from postprocess.pages.uncertainty_page import UncertaintyContent, VariedInput, write_uncertainty_page
from tailslap.studies.uncertainty.report.words import headline, order, range_words, statements, value_words
from tailslap.studies.uncertainty.sampling import SEED
from tailslap.studies.uncertainty.spread import PERCENTILES, Spread


def write_spread(spread: Spread, folder: Path) -> None:
    """Fill the folder: `report.html`, `samples.csv`, `summary.json`."""
    write_uncertainty_page(folder / "report.html", _content(spread))
    write_history(folder / "samples.csv", _columns(spread))
    write_summary(folder / "summary.json", summary(spread))


def summary(spread: Spread) -> dict[str, Any]:
    """The numbers of the study, SI."""
    samples, found, plan = spread.samples, spread.distribution, spread.plan
    percentiles = {f"percentile_{p}": x for p, x in zip(PERCENTILES, found.percentiles, strict=True)}
    return {
        "study": "uncertainty",
        "scene": plan.scene.name,
        "version": tailslap.__version__,
        "seed": SEED,
        "rows": samples.force_a.size,
        "combinations": samples.combinations,
        "refused": samples.refused,
        "rows_left_out": samples.rows_left_out,
        "first_refusal": spread.first_refusal or None,
        "peak_force": {
            "mean": found.mean,
            "standard_deviation": found.standard_deviation,
            **percentiles,
            "of_the_scene": float(plan.force.peak_force),
            "histogram": {"edges": found.edges, "counts": found.counts},
        },
        "inputs": [_input_numbers(spread, i) for i in range(len(samples.ranges))],
        "held": spread.held,
        "cost": {"seconds": spread.seconds},
    }


def _input_numbers(spread: Spread, i: int) -> dict[str, Any]:
    item, indices = spread.samples.ranges[i], spread.indices
    return {
        "key": item.key,
        "lower": item.lower,
        "upper": item.upper,
        "unit": item.unit,
        "origin": item.origin,
        "of_the_scene": item.given,
        "first_order": indices.first[i],
        "first_order_interval": indices.first_interval[:, i],
        "total": indices.total[i],
        "total_interval": indices.total_interval[:, i],
    }


def _columns(spread: Spread) -> dict[str, np.ndarray]:
    """The combinations of the distribution, inputs and force; NaN where the theory refuses one."""
    samples = spread.samples
    values = np.hstack([samples.a, samples.b])
    columns = {item.key: column for item, column in zip(samples.ranges, values, strict=True)}
    return columns | {"peak_force": np.concatenate([samples.force_a, samples.force_b])}


def _content(spread: Spread) -> UncertaintyContent:
    plan = spread.plan
    return UncertaintyContent(
        scene=plan.scene.name,
        version=tailslap.__version__,
        headline=headline(spread),
        distribution=_results(spread),
        inputs=tuple(_varied(spread, i) for i in order(spread)),
        statements=statements(spread),
        curves=(draw_histogram(_histogram(spread)), draw_sensitivity(_sensitivity(spread))),
        scene_text=plan.source.text,
    )


def _results(spread: Spread) -> tuple[Result, ...]:
    found = spread.distribution
    rows = [("mean", found.mean), ("standard deviation", found.standard_deviation)]
    rows += [(f"{p} % lie below", x) for p, x in zip(PERCENTILES, found.percentiles, strict=True)]
    rows.append(("of the scene's own values", float(spread.plan.force.peak_force)))
    return tuple(Result(name, force / 1e3, "kN") for name, force in rows)


def _varied(spread: Spread, i: int) -> VariedInput:
    item, indices = spread.samples.ranges[i], spread.indices
    (low, high), (total_low, total_high) = indices.first_interval[:, i], indices.total_interval[:, i]
    return VariedInput(
        item.key,
        range_words(item),
        value_words(item),
        item.origin,
        float(indices.first[i]),
        (float(low), float(high)),
        float(indices.total[i]),
        (float(total_low), float(total_high)),
    )


def _histogram(spread: Spread) -> Histogram:
    found = spread.distribution
    percentiles = tuple(zip(PERCENTILES, found.percentiles, strict=True))
    return Histogram(found.edges, found.counts, percentiles, float(spread.plan.force.peak_force))


def _sensitivity(spread: Spread) -> Sensitivity:
    sorted_, indices = order(spread), spread.indices
    names = [spread.samples.ranges[i].key for i in sorted_]
    first, total = indices.first[sorted_], indices.total[sorted_]
    return Sensitivity(
        names, first, total, indices.first_interval[:, sorted_], indices.total_interval[:, sorted_]
    )
