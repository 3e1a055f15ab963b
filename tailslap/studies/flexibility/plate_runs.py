"""Runs of plates and result of the study."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from tailslap.campaign import engine, levels
from tailslap.campaign.levels import Reach
from tailslap.campaign.records import Record
from tailslap.case import case_of
from tailslap.errors import InputError
from tailslap.scene.vary import Changes, Source, vary
from tailslap.studies.flexibility.flexibility_scan import Scan

T = TypeVar("T")

PATCH = 0.1
"""Length of the supported or crushed side over that of the vehicle, where the scene has none.

A point has no finite compliance, and meshes would not converge.
"""
Results = Callable[[engine.Group], Record]
"""Function from a group of parts to their results."""


@dataclass(frozen=True)
class Flexibility:
    """Result of the study.

    Attributes
    ----------
    rows : list of dict
        Plates from stiff to soft, as in `points.csv`.
    levels : dict of tuple of Reach
        Of a whole impact by `NAMES`; of a corner, the largest difference of v_GY by start.
    own_frequency : float
        First frequency of the scene's own plate [Hz].
    setup : dict
        Support of the corner and meshes, or length of the crushed side.
    other_levels : dict
        Of a corner with inertia relief, levels of the other quantities at the tail-slap.
    plates : list of dict
        Of a whole impact, both strikes from 2 Hz to rigid, see `measure_plate`, softest first.
    scan : list of dict
        Signed differences near the levels, as in `scan.csv`.
    step : float
        Resolution of the scan [Hz].
    """

    case: Any
    rows: list[Record]
    levels: Mapping[str, tuple[Reach, ...]]
    own_frequency: float
    setup: Record
    seconds: float
    other_levels: Mapping[str, tuple[Reach, ...]]
    plates: Sequence[Record] = ()
    scan: Sequence[Record] = ()
    step: float = math.nan

    @property
    def band(self) -> tuple[Reach, ...]:
        """Return the levels that hold for all series."""
        return tuple(levels.jointly(series) for series in zip(*self.levels.values(), strict=True))


def listed_scan(scan: Scan, names: Iterable[str], **head: str) -> list[Record]:
    """Return the rows of a scan for `scan.csv`.

    The columns are the same for every start.
    """
    return [
        {**head, "first_frequency": frequency, **{f"difference_{name}": row[name] for name in names}}
        for frequency, row in scan.differences.items()
    ]


def one_run(base: Source, changes: Changes | None, measure: Callable[[Any], T]) -> T | Record:
    """Return the measured result of the changed case.

    If there is none, it is a record with the reason, `refused`.
    """
    if changes is None:
        return {"refused": "omitted: the estimated time exceeds the limit"}
    return or_refused(lambda: measure(case_of(*vary(base, changes))))


def or_refused(compute: Callable[[], T]) -> T | Record:
    """Return the result, or a record with the reason for the absence."""
    try:
        return compute()
    except InputError as error:
        return {"refused": str(error)}
    except Exception as error:  # a failed plate does not end the study
        return {"refused": f"broke: {type(error).__name__}: {error}"}


def run_passed(run: Record) -> bool:
    """Return True if the run passed its checks."""
    return "refused" not in run and not run["failed"]


def failure_text(run: Record) -> str:
    """Return the failed checks, or the reason without a result."""
    return str(run.get("refused", ", ".join(run.get("failed", []))))
