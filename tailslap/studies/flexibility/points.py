"""A point of the sweep, from the record of its runs: differences from the rigid body, and how well they are known."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from postprocess.comparison.comparison import KEYS, largest_relative, relative_difference
from postprocess.comparison.grid_convergence import SAFETY_FACTOR, grid_convergence
from tailslap.studies.flexibility.measure import KEPT, Record
from tailslap.studies.flexibility.sweep import STARTS

MAX_ORDER = 2.0
"""Order of convergence of linear elements and central differences."""

MEASURED = (*KEYS, "reaction", "stored")


@dataclass(frozen=True)
class Thickness:
    """The point once more by its thickness [m], at the scene's modulus: largest difference of the five quantities."""

    thickness: float
    apart: float


@dataclass(frozen=True)
class Start:
    """A start of this point: v_GY's relative difference at the strike, its largest until then (in size) and the
    numerical error of that, NaN where it is not known.

    departure: relative differences of `KEPT` at t = 0. damping: rate [1/s] of that of the elastic velocities.
    why: the checks that failed, or why there was no run.
    """

    difference: float
    largest: float
    error: float
    departure: dict[str, float]
    damping: float
    passed: bool
    why: str

    @property
    def kept(self) -> float:
        """The share of v_GY's difference at the strike that is there at t = 0."""
        return self.departure["v_gy"] / self.difference

    @property
    def row(self) -> dict[str, Any]:
        """Its numbers, flat."""
        return {
            "v_gy": self.difference,
            "v_gy_largest": self.largest,
            "v_gy_error": self.error,
            **{f"{quantity}_at_start": self.departure[quantity] for quantity in KEPT},
            "damping_rate": self.damping,
            "passed": self.passed,
            "why": self.why,
        }


@dataclass(frozen=True)
class Point:
    """A plate of this first frequency [Hz]; E [Pa] and all numbers are of the first start's finest mesh.

    difference: of the five quantities from the rigid ones; reaction, stored: see `measure`. errors: numerical error of
    each of the seven, in their units, NaN where it is not known. modal: the modal model's differences. why: the checks
    that failed, or why there was no run. half_patch: the difference of v_GY with half the patch, NaN where that was not
    run. starts: by name.
    """

    frequency: float
    youngs_modulus: float
    difference: dict[str, float]
    reaction: float
    stored: float
    errors: dict[str, float]
    passed: bool
    why: str
    damping: float
    deflection_ratio: float
    modal: dict[str, float]
    modal_estimate: float
    modal_apart: float
    modal_why: str
    thickness: Thickness | None
    half_patch: float
    steps: int
    starts: dict[str, Start]

    @property
    def seven(self) -> dict[str, float]:
        """The five relative differences, reaction and stored energy."""
        return self.difference | {"reaction": self.reaction, "stored": self.stored}

    def size(self, name: str) -> float:
        """The difference from the rigid value, without its sign."""
        return abs(self.seven[name])

    @property
    def checks(self) -> str:
        """Whether it passed, which checks failed, or why there was no run."""
        if self.passed:
            return "passed"
        return f"failed: {self.why}" if self.steps else f"none: {self.why}"

    @property
    def half_change(self) -> float:
        """What half the patch changes v_GY's difference by, as a share of it; NaN where that was not run."""
        return self.half_patch / self.difference["v_gy"] - 1.0

    @property
    def good(self) -> dict[str, Start | None]:
        """The starts by name, None for one without a run that passed its checks."""
        return {name: start if start.passed else None for name, start in self.starts.items()}

    @property
    def row(self) -> dict[str, Any]:
        """All numbers, flat, as `points.csv` and the summary hold them."""
        thickness = self.thickness
        return {
            "first_frequency": self.frequency,
            "youngs_modulus": self.youngs_modulus,
            "passed": self.passed,
            "why": self.why,
            **{f"difference_{name}": self.difference[name] for name in KEYS},
            "reaction_deviation": self.reaction,
            "stored_share": self.stored,
            **{f"error_{name}": self.errors[name] for name in MEASURED},
            **{f"modal_{name}": self.modal[name] for name in KEYS},
            "modal_estimate": self.modal_estimate,
            "modal_apart": self.modal_apart,
            "modal_why": self.modal_why,
            "damping_rate": self.damping,
            "deflection_ratio": self.deflection_ratio,
            "steps": self.steps,
            "half_patch_v_gy": self.half_patch,
            "thickness": thickness and thickness.thickness,
            "thickness_apart": thickness and thickness.apart,
            **{f"{name}:{key}": x for name, start in self.starts.items() for key, x in start.row.items()},
        }


def make_point(frequency: float, record: Record, rigid: dict[str, float]) -> Point:
    """The point that a record of `measure` describes; rigid: the five quantities."""
    meshes, modal = record["starts"][STARTS[0]], record["modal"]
    fine, modal_values = meshes[-1], modal.get("values", {})
    return Point(
        frequency=frequency,
        youngs_modulus=fine.get("youngs_modulus", math.nan),
        difference=_differences(fine, rigid),
        reaction=fine.get("reaction", math.nan),
        stored=fine.get("stored", math.nan),
        errors={name: mesh_error(meshes, name) for name in MEASURED},
        passed=_passed(fine),
        why=_why(fine),
        damping=fine.get("damping", 0.0),
        deflection_ratio=fine.get("deflection_ratio", math.nan),
        modal=_differences(modal, rigid),
        modal_estimate=modal.get("estimate", math.nan),
        modal_apart=largest_relative(modal_values, fine.get("values", {})),
        modal_why=_why(modal),
        thickness=_thickness(record),
        half_patch=_half_patch(record, rigid),
        steps=fine.get("steps", 0),
        starts={name: _start(runs, rigid) for name, runs in record["starts"].items()},
    )


def _start(runs: list[Record], rigid: dict[str, float]) -> Start:
    fine = runs[-1]
    return Start(
        difference=_differences(fine, rigid)["v_gy"],
        largest=fine.get("largest", math.nan),
        error=mesh_error(runs, "largest") if len(runs) > 1 else fine.get("error", math.nan),
        departure=fine.get("departure", dict.fromkeys(KEPT, math.nan)),
        damping=fine.get("damping", 0.0),
        passed=_passed(fine),
        why=_why(fine),
    )


def _differences(run: Record, rigid: dict[str, float]) -> dict[str, float]:
    values = run.get("values", {})
    return relative_difference(values, rigid) if values else dict.fromkeys(KEYS, math.nan)


def _passed(run: Record) -> bool:
    return "refused" not in run and not run["failed"]


def _why(run: Record) -> str:
    return str(run.get("refused", ", ".join(run.get("failed", []))))


def mesh_error(meshes: list[Record], name: str) -> float:
    """Numerical error of the finest mesh: its grid convergence index, and what damping and ringing add on every mesh.

    Of the five quantities it is relative, as their differences are; the others are shares already.
    """
    values = [_value(mesh, name) for mesh in meshes]
    if not all(map(math.isfinite, values)) or 0.0 in values:
        return math.nan
    coarse, medium, fine = values
    index = convergence_index(fine, medium, coarse)
    return float(index * (1.0 if name in KEYS else abs(fine)) + meshes[-1]["unseen"])


def convergence_index(fine: float, medium: float, coarse: float) -> float:
    """Grid convergence index of the fine mesh; an observed order above that of the elements is luck, and not used."""
    found = grid_convergence((fine, medium, coarse), (2.0, 2.0))
    if found.behaviour != "converging" or found.order <= MAX_ORDER:
        return found.gci_fine
    return SAFETY_FACTOR * abs((fine - medium) / fine) / (2.0**MAX_ORDER - 1.0)


def _value(mesh: Record, name: str) -> float:
    values = mesh.get("values", {}) if name in KEYS else mesh
    return float(values.get(name, math.nan))


def _thickness(record: Record) -> Thickness | None:
    found = record.get("thickness", {})
    if "thickness" not in found:
        return None
    return Thickness(
        found["thickness"], largest_relative(found["values"], record["starts"][STARTS[0]][1]["values"])
    )


def _half_patch(record: Record, rigid: dict[str, float]) -> float:
    found = record.get("half_patch", {})
    good = found.get("values") and not found["failed"]
    return _differences(found, rigid)["v_gy"] if good else math.nan
