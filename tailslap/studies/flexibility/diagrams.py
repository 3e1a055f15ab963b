"""The figures of the study, out of its points."""

from __future__ import annotations

from collections.abc import Sequence

from postprocess.comparison.comparison import KEYS, QUANTITIES
from postprocess.figures.flexibility_plots import DOTS, RINGS, SweepAxis, SweepLine, draw_sweep
from postprocess.svg.chart import Chart
from tailslap.studies.flexibility.campaign import LEVELS, FlexibilityResults
from tailslap.studies.flexibility.sweep import STARTS

START_NAMES = dict(zip(STARTS, ("inertia relief", "Stage 1's momenta", "unstressed"), strict=True))
SYMBOLS = {name: quantity.symbol for name, quantity in QUANTITIES.items()}
SYMBOLS |= {"reaction": "reaction", "stored": "stored energy", "v_p": "v_P"}
CAPTIONS = {
    "starts": "v_GY from three starts: largest difference from the rigid body",
    "difference": "Time of the strike, velocities of the centre of mass, angular velocity and slide",
    "reaction": "Normal reaction of the wall",
    "stored": "Largest elastic energy of the plate over its kinetic energy at the start",
    "modal": "v_GY by both methods, and how far the methods are apart",
}
LABELS = {"reaction": "largest deviation over the rigid reaction", "stored": "elastic over kinetic energy"}
MARKED = {"starts": LEVELS, "difference": LEVELS, "modal": LEVELS[:2]}
"""Levels that are marked."""


def figures(found: FlexibilityResults) -> tuple[Chart, ...]:
    """v_GY from three starts; the five quantities, reaction, stored energy with inertia relief; the modal model."""
    shown = {"difference": KEYS, "reaction": ("reaction",), "stored": ("stored",)}
    sizes = (_draw(found, name, [_size(found, each) for each in shown[name]]) for name in shown)
    return (_starts(found), *sizes, _draw(found, "modal", _modal(found)))


def _starts(found: FlexibilityResults) -> Chart:
    """The largest difference of v_GY from each start; a plate failed where none of its starts passed."""
    lines = []
    for name, label in START_NAMES.items():
        each = [point.starts[name] for point in found.points]
        largest, errors = [start.largest for start in each], [start.error for start in each]
        lines.append(SweepLine(label, largest, errors, passed=[start.passed for start in each]))
    return _draw(found, "starts", lines, [any(point.good.values()) for point in found.points])


def _size(found: FlexibilityResults, name: str, label: str = "") -> SweepLine:
    """The size of a quantity, with inertia relief."""
    sizes, errors = [p.size(name) for p in found.points], [p.errors[name] for p in found.points]
    return SweepLine(label or SYMBOLS[name], sizes, errors)


def _modal(found: FlexibilityResults) -> list[SweepLine]:
    return [
        _size(found, "v_gy", "v_GY, FE"),
        SweepLine("v_GY, modal", [abs(p.modal["v_gy"]) for p in found.points], form=RINGS),
        SweepLine("apart, largest of five", [p.modal_apart for p in found.points], form=DOTS),
        SweepLine("modal estimate", [p.modal_estimate for p in found.points], form=DOTS),
    ]


def _draw(found: FlexibilityResults, name: str, lines: list[SweepLine], passed: Sequence[bool] = ()) -> Chart:
    """passed: of the points, where not those of the first start."""
    frequencies = [point.frequency for point in found.points]
    passed = passed or [point.passed for point in found.points]
    axis = SweepAxis(frequencies, passed, found.sweep.own_frequency)
    label = LABELS.get(name, "size of the relative difference")
    return draw_sweep(f"flexibility-{name}", axis, lines, label, CAPTIONS[name], MARKED.get(name, ()))
