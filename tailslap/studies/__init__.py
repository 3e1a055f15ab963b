"""Prepared studies: `tailslap study NAME SCENE`.

A study is a package in this folder with a `Study` called STUDY, or one that another program has registered: what it
computes, what it reports (`study.py`). What the studies share stands beside them.
"""

import importlib
import pkgutil

from tailslap.case.corner.case import CornerCase
from tailslap.errors import InputError, one_of
from tailslap.studies.study import Study

_registered: dict[str, Study] = {}

# Former studies, and what to use in their place.
GONE = {
    "features": "use `tailslap check SCENE`, or benchmarks/features.py",
    "strike": "use `tailslap study uncertainty` or `tailslap study flexibility`",
}


def register(study: Study) -> None:
    """Add a study from outside this folder. Raises ValueError for a name that is taken."""
    if study.name in study_names():
        raise ValueError(f"the study {study.name!r} exists")
    _registered[study.name] = study


def study_names() -> list[str]:
    """Names of the studies, sorted; none is imported."""
    return sorted([*(module.name for module in pkgutil.iter_modules(__path__) if module.ispkg), *_registered])


def with_elements(plan: CornerCase) -> CornerCase:
    """The plan with the elements that the program chooses where the scene leaves them out."""
    from tailslap.case.corner.decisions import decide_mesh

    plate = plan.scene.needed_plate
    if plate.elements is not None:
        return plan
    chosen = decide_mesh(plan, plate)[0].plate
    changes = {"plate.elements": chosen.elements, "plate.element": chosen.element}
    return plan.varied(changes)


def find_study(name: str) -> Study:
    """The study of this name, imported now. Raises InputError, listing the studies, for a name that is none."""
    if name in GONE:
        raise InputError("NAME", name, f"this study was removed; {GONE[name]}")
    if name not in study_names():
        raise InputError("NAME", name, one_of(name, study_names(), "allowed is one of the studies:"))
    found: Study = _registered.get(name) or importlib.import_module(f"{__name__}.{name}").STUDY
    return found
