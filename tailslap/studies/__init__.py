"""Prepared studies, `tailslap study NAME SCENE`.

A study is a package in this folder with a `Study` named STUDY (`study.py`), or one that another program has registered.
Modules of several studies are in this folder.
"""

import importlib
import pkgutil

from tailslap.case.corner.corner_case import CornerCase
from tailslap.errors import InputError, one_of
from tailslap.studies.study import Study

_registered: dict[str, Study] = {}
"""Studies from outside this folder."""


def register(study: Study) -> None:
    """Add a study from outside this folder.

    Raises ValueError if the name is in use.
    """
    if study.name in study_names():
        raise ValueError(f"the study {study.name!r} exists")
    _registered[study.name] = study


def study_names() -> list[str]:
    """Return the sorted names of the studies."""
    return sorted([*(module.name for module in pkgutil.iter_modules(__path__) if module.ispkg), *_registered])


def with_elements(case: CornerCase) -> CornerCase:
    """Return the case with decided elements."""
    from tailslap.case.corner.decisions import decide_mesh

    plate = case.scene.needed_plate
    if plate.elements is not None:
        return case
    decided = decide_mesh(case, plate)[0].plate
    changes = {"plate.elements": decided.elements, "plate.element": decided.element}
    return case.varied(changes)


def find_study(name: str) -> Study:
    """Import and return the study of this name.

    Raises InputError with the names of all studies for another name.
    """
    if name not in study_names():
        raise InputError("NAME", name, one_of(name, study_names(), "allowed is one of the studies:"))
    study: Study = _registered.get(name) or importlib.import_module(f"{__name__}.{name}").STUDY
    return study
