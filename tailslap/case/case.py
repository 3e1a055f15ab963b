"""Case: a scene, and all that the program does with it, whichever of its two kinds it is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

from postprocess.comparison.quantities import Compared
from postprocess.report.units import SI, Units
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Changes, Source, vary

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

    from postprocess.report.report import Report


CORNER, WHOLE_IMPACT = "a constrained corner", "a whole impact"
"""Names of the two kinds, for messages."""


@dataclass(frozen=True)
class Case(ABC):
    """A scene with its calculation. Making one solves the rigid body, and raises InputError where that has no answer.

    Attributes
    ----------
    scene : Scene
        As read, SI.
    source : Source
        Where it came from.
    """

    scene: Scene
    source: Source

    name: ClassVar[str]
    """Its kind, for messages."""

    compared: ClassVar[Compared]
    """What pictures and pages of many runs show of FE and rigid vehicle."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """How long the motion lasts that a run integrates [s]."""

    def varied(self, changes: Changes) -> Self:
        """The case of the scene with these changes, noted in its source. Raises InputError."""
        return type(self)(*vary(self.source, changes))

    @abstractmethod
    def rigid_numbers(self) -> dict[str, Any]:
        """What `tailslap rigid` says, as numbers, SI."""

    @abstractmethod
    def rigid_text(self, units: str = "si") -> list[str]:
        """The same as a person reads it, in SI or, with units "us", in ft, mph and kip."""

    @abstractmethod
    def rigid_history(self) -> dict[str, np.ndarray]:
        """Columns of the rigid motion by name, SI."""

    @abstractmethod
    def plan(self, more_damping: float = 1.0) -> Any:
        """What a run integrates: the model, and what was decided of it. Raises InputError for keys that make none."""

    def check_text(self, allow_large: bool = False) -> list[str]:
        """What `tailslap check` says; of a large mesh an estimate. Raises InputError."""
        from tailslap.case.cost import demand_affordable, estimate_text, is_large

        if not allow_large:
            demand_affordable(self.scene, self.duration)
        return estimate_text(self.scene, self.duration) if is_large(self.scene) else self._check_text()

    @abstractmethod
    def _check_text(self) -> list[str]:
        """The same, with the model made."""

    @abstractmethod
    def run(self, tolerance: float | None = None) -> Any:
        """Run the plate and check it; with a tolerance, on ever finer meshes until the error meets it. Writes nothing.

        Raises InputError for keys that make no model.
        """

    @abstractmethod
    def summary(self, outcome: Any, pictures: bool) -> dict[str, Any]:
        """The numbers of a run, SI: what `summary.json` holds; pictures: whether they were asked for."""

    @abstractmethod
    def histories(self, outcome: Any) -> dict[str, dict[str, np.ndarray]]:
        """The histories of FE and rigid vehicle: columns by the names of their files."""

    @abstractmethod
    def report(self, outcome: Any, folder: Path, pictures: bool, units: Units = SI) -> Report:
        """The report of a run; its fields and pictures, in these units, go into the folder."""

    @staticmethod
    @abstractmethod
    def columns(scene: Scene) -> dict[str, type]:
        """Columns that the table of a sweep has whatever its rows, checks beside, and the type of their values.

        Raises InputError for a scene that cannot be swept.
        """

    @abstractmethod
    def row(self, outcome: Any | None) -> dict[str, Any]:
        """A run as columns of that table, SI; without an outcome, of a scene without [plate], the rigid vehicle alone.

        Raises InputError for a scene whose kind needs a plate.
        """
