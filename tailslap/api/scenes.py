"""What the functions take for a scene, and its plan."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from tailslap.api.laws import named
from tailslap.case import case_of
from tailslap.case.case import Case
from tailslap.case.cost import demand_run
from tailslap.errors import InputError
from tailslap.scene.read import read_source, remarks
from tailslap.scene.vary import Source, vary

Scene = str | os.PathLike[str] | Mapping[str, Any]
"""Name of a scene that comes with the program, path of a TOML file, or the tables themselves."""

Changes = Mapping[str, Any]
"""Values by dotted key: numbers in SI, texts with their unit, objects; None takes the key out."""


def planned(scene: Scene, changes: Changes | None) -> Case:
    """The case of a scene with these changes. Raises InputError."""
    varied, source = vary(_source(scene), named({k: _plain(v) for k, v in (changes or {}).items()}))
    for remark in remarks(source):
        warnings.warn(remark, stacklevel=3)
    return case_of(varied, source)


def planned_plate(scene: Scene, changes: Changes | None, allow_large: bool) -> Case:
    """The same for a scene with a plate that this machine can carry. Raises InputError."""
    case = planned(scene, changes)
    demand_run(case.scene, case.duration, allow_large)
    return case


def _source(scene: Scene) -> Source:
    if isinstance(scene, Mapping):
        return Source(given={key: _plain(value) for key, value in scene.items()})
    if isinstance(scene, str | os.PathLike):
        return read_source(os.fspath(scene))
    allowed = "allowed is a name, the path of a TOML file, or a dict of tables"
    raise InputError("scene", type(scene).__name__, allowed)


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays as Python's own, within tables too."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    return value
