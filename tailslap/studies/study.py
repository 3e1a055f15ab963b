"""A study: its name, what it computes, what it reports; all else is done here for every study."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tailslap.case import case_of, kind_of
from tailslap.case.case import CORNER, Case
from tailslap.case.cost import demand_run
from tailslap.errors import InputError, Missing, Verbatim, one_of
from tailslap.scene.read import read_scene
from tailslap.scene.vary import changes_of, shown
from tailslap.storage.folder import default_place
from tailslap.storage.manifest import Origin

if TYPE_CHECKING:
    from postprocess.report.command_report import Report


def later(name: str) -> Callable[..., Any]:
    """The function of this name, "module:function", whose module is imported when it is called."""
    module, _, function = name.partition(":")

    def called(*arguments: Any, **options: Any) -> Any:
        return getattr(importlib.import_module(module), function)(*arguments, **options)

    return called


@dataclass(frozen=True)
class Study:
    """A study.

    Parameters
    ----------
    name, summary : str
        Its name on the command line, and what `--help` says.
    compute : callable
        Takes the case, the result folder's place and the study's own options by name; returns what was found.
    report : callable
        Takes what was found and returns its `Report`; both may be named, by `later`.
    options : tuple of click.Option
        Options of its own.
    needs_plate : bool
        True if the scene must have the table [plate].
    folder : callable, optional
        Takes the options and returns the ending of the default result folder's name; without it, the study's name.
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


def checked_options(study: Study, given: Mapping[str, Any]) -> dict[str, Any]:
    """The study's own options as `compute` takes them, by their types and bounds, defaults among them.

    given: by the names on the command line with "_" for "-"; an option that can be given several times takes a list or
    a mapping. Raises InputError.
    """
    known = option_names(study)
    context, found = click.Context(click.Command(study.name)), {}
    for name, value in given.items():
        if name not in known:
            allowed = one_of(name, known, "allowed are") if known else "this study has no options of its own"
            raise InputError(f"study {study.name}", name, allowed)
        option = known[name]
        if isinstance(value, Mapping):
            value = shown(value)
        if value is not None:
            found[str(option.name)] = [value] if option.multiple and isinstance(value, str) else value
    for option in study.options:
        found.setdefault(str(option.name), option.to_info_dict()["default"])
        try:
            found[str(option.name)] = option.handle_parse_result(context, found, [])[0]
        except click.UsageError as error:
            value = found.get(str(option.name))
            raise InputError(f"study {study.name}", value, error.format_message()) from None
    return found


def option_names(study: Study) -> dict[str, click.Option]:
    """The study's own options by their names in Python: `--range` is `range`."""
    return {option.opts[0].lstrip("-").replace("-", "_"): option for option in study.options}


def prepared(
    study: Study,
    name: str,
    changes: tuple[str, ...],
    out: Path | None,
    allow_large: bool,
    options: Mapping[str, Any],
) -> tuple[Case, Path, Origin]:
    """The case, the place of the result folder, beside which a journal is kept, and its origin. Raises InputError."""
    scene, source = read_scene(name, changes)
    if (kind := kind_of(scene).name) not in study.analyses:
        given, allowed = (Missing, "with") if kind == CORNER else (Verbatim("a table"), "without")
        wanted = f"`tailslap study {study.name}` is of {' or '.join(study.analyses)}; this scene is {kind}"
        raise InputError("contact", given, f"{wanted}; allowed is a scene {allowed} this table")
    case = case_of(scene, source)
    if study.needs_plate:
        demand_run(scene, case.duration, allow_large)
    ending = study.folder(options) if study.folder else study.name
    place = out or default_place(scene.name, changes_of(source), f"-{ending}")
    return case, place, Origin(f"study {study.name}", scene.name)
