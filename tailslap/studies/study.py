"""What a study is: a name, what it computes, what it reports; all else is the same for every study."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from tailslap.case import case_of, kind_of
from tailslap.case.case import CORNER
from tailslap.errors import InputError, Missing, Verbatim
from tailslap.options import ALLOW_LARGE, FORCE, JSON, PROGRESS, QUIET, SCENE, SET, UNITS, Folder

if TYPE_CHECKING:
    from postprocess.report.report import Report
    from tailslap.scene.schema import Scene


def later(name: str) -> Callable[..., Any]:
    """The function of this name, "module:function", whose module is imported when it is called."""
    module, _, function = name.partition(":")

    def called(*arguments: Any, **options: Any) -> Any:
        return getattr(importlib.import_module(module), function)(*arguments, **options)

    return called


@dataclass(frozen=True)
class Call:
    """A study as it was asked for: the scene's name and changes, its case, the result folder's place."""

    name: str
    changes: tuple[str, ...]
    plan: Any
    place: Path


@dataclass(frozen=True)
class Study:
    """A study.

    Parameters
    ----------
    name, summary : str
        Its name on the command line, and what `--help` says.
    compute : callable
        Takes the `Call` and the study's own options by name, and returns what was found.
    report : callable
        Takes what was found and returns its `Report`; both may be named, by `later`.
    options : tuple of click.Option
        Options of its own.
    needs_plate : bool
        Whether the scene must have the table [plate].
    folder : callable, optional
        Takes the options and returns how the name of the default result folder ends; without it, in the study's name.
    analyses : tuple of str
        Names of the analyses whose scenes it makes sense for.
    """

    name: str
    summary: str
    compute: Callable[..., Any]
    report: Callable[[Any], Report]
    options: tuple[click.Option, ...] = ()
    needs_plate: bool = True
    folder: Callable[[Mapping[str, Any]], str] | None = None
    analyses: tuple[str, ...] = (CORNER,)


class Shown(NamedTuple):
    """Whether another scene's result is replaced, and how results are said."""

    force: bool
    units: str
    as_json: bool


def study_command(study: Study) -> click.Command:
    """The study on the command line: SCENE, --set, --out, and its own options."""
    shared: list[click.Parameter] = [
        *(SCENE, SET),
        click.Option(
            ["--out"],
            type=Folder(),
            help=f"Result folder  [default: results/NAME-{study.name}]",
        ),
        *(ALLOW_LARGE, FORCE, UNITS, JSON, QUIET, PROGRESS),
    ]

    def run(name: str, changes: tuple[str, ...], out: Path | None, allow_large: bool, **options: Any) -> int:
        shown = Shown(*(options.pop(option) for option in ("force", "units", "as_json")))
        return _run(study, name, changes, out, allow_large, shown, options)

    return click.Command(study.name, params=[*shared, *study.options], callback=run, help=study.summary)


def _run(
    study: Study,
    name: str,
    changes: tuple[str, ...],
    out: Path | None,
    allow_large: bool,
    shown: Shown,
    options: dict[str, Any],
) -> int:
    """Compute, fill the result folder, say what was found; 1 if the study failed."""
    from tailslap.report.deliver import deliver

    place, found = compute_study(study, name, changes, out, allow_large, options, shown.force)
    return deliver(place, lambda folder: study.report(found), as_json=shown.as_json, units=shown.units)


def compute_study(
    study: Study,
    name: str,
    changes: tuple[str, ...],
    out: Path | None,
    allow_large: bool,
    options: dict[str, Any],
    force: bool = True,
) -> tuple[Path, Any]:
    """The place of the result folder, and what was found; the journal is kept beside that place. Raises InputError."""
    from tailslap.case.cost import demand_run
    from tailslap.files.folder import demand_own, demand_place
    from tailslap.scene.read import read_scene

    scene, source = read_scene(name, changes)
    _demand_kind(study, scene)
    plan = case_of(scene, source)
    if study.needs_plate:
        demand_run(plan.scene, plan.duration, allow_large)
    ending = study.folder(options) if study.folder else study.name
    place = out or Path("results") / f"{plan.scene.name}-{ending}"
    demand_place(place)
    demand_own(place, plan.scene.name, force)
    return place, study.compute(Call(name, changes, plan, place), **options)


def _demand_kind(study: Study, scene: Scene) -> None:
    """Raise InputError where the study makes no sense for the scene."""
    name = kind_of(scene).name
    if name in study.analyses:
        return
    given, allowed = (Missing, "with") if name == CORNER else (Verbatim("a table"), "without")
    wanted = f"`tailslap study {study.name}` is of {' or '.join(study.analyses)}; this scene is {name}"
    raise InputError("contact", given, f"{wanted}; allowed is a scene {allowed} this table")
