"""Description of a study."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tailslap.case import kind_of
from tailslap.case.case import CORNER, WHOLE_IMPACT, Case
from tailslap.case.resources import demand_run
from tailslap.errors import InputError, Missing, Verbatim, one_of
from tailslap.scene.vary import shown
from tailslap.storage.folder import default_place
from tailslap.storage.manifest import Origin

if TYPE_CHECKING:
    from postprocess.report.command_report import Report
    from tailslap.campaign.records import Record


def later(name: str) -> Callable[..., Any]:
    """Return a function that is imported when it is called.

    `name` is "module:function".
    """
    module, _, function = name.partition(":")

    def call(*arguments: Any, **options: Any) -> Any:
        return getattr(importlib.import_module(module), function)(*arguments, **options)

    return call


def range_options(example: str) -> tuple[click.Option, ...]:
    """Return the options of uncertain inputs."""
    varied = f"Range of a key, e.g. {example}."
    fixed = "Keep a key fixed that varies by default."
    return (
        click.Option(["--range", "ranges"], multiple=True, metavar="KEY=LOWER:UPPER", help=varied),
        click.Option(["--fix", "fixed"], multiple=True, metavar="KEY", help=fixed),
    )


@dataclass(frozen=True)
class Study:
    """A study.

    Parameters
    ----------
    name, summary : str
        Name on the command line, and text of `--help`.
    compute : callable
        Takes the case, the place of the result folder and the options of the study by name, and returns a result.
    report : callable
        Takes the result and returns its `Report`. Both functions may be named, by `later`.
    options : tuple of click.Option
        Options of the study.
    needs_plate : bool
        True if the scene must have the table [plate].
    folder : callable, optional
        Takes the options and returns the ending of the default result folder, by default the name of the study.
    analyses : tuple of str
        Names of the kinds of case that the study supports.
    """

    name: str
    summary: str
    compute: Callable[..., Any]
    report: Callable[[Any], Report]
    options: tuple[click.Option, ...] = ()
    needs_plate: bool = True
    folder: Callable[[Mapping[str, Any]], str] | None = None
    analyses: tuple[str, ...] = (CORNER, WHOLE_IMPACT)


def checked_options(study: Study, options: Mapping[str, Any]) -> Record:
    """Return the options of a study with defaults.

    They are checked by type and bounds. Names are those of the command line with "_" for "-". An option that can be
    given several times takes a list or a mapping. Raises InputError.
    """
    defined = {option.opts[0].lstrip("-").replace("-", "_"): option for option in study.options}
    context, values = click.Context(click.Command(study.name)), {}
    for name, value in options.items():
        if name not in defined:
            why = one_of(name, defined, "allowed are") if defined else "this study has no options of its own"
            raise InputError(f"study {study.name}", name, why)
        option = defined[name]
        if isinstance(value, Mapping):
            value = shown(value)
        if value is not None:
            values[str(option.name)] = [value] if option.multiple and isinstance(value, str) else value
    for option in study.options:
        values.setdefault(str(option.name), option.to_info_dict()["default"])
        try:
            values[str(option.name)] = option.handle_parse_result(context, values, [])[0]
        except click.UsageError as error:
            value = values.get(str(option.name))
            raise InputError(f"study {study.name}", value, error.format_message()) from None
    return values


def prepared(
    study: Study, case: Case, out: Path | None, allow_large: bool, options: Mapping[str, Any]
) -> tuple[Path, Origin]:
    """Return place of the result folder and origin.

    A journal is stored beside the folder. Raises InputError.
    """
    scene = case.scene
    if (kind := kind_of(scene).name) not in study.analyses:
        actual, allowed = (Missing, "with") if kind == CORNER else (Verbatim("a table"), "without")
        scope = f"`tailslap study {study.name}` is of {' or '.join(study.analyses)}; this scene is {kind}"
        raise InputError("contact", actual, f"{scope}; allowed is a scene {allowed} this table")
    if study.needs_plate:
        demand_run(scene, case.duration, allow_large)
    ending = study.folder(options) if study.folder else study.name
    place = out or default_place(scene.name, case.changes, f"-{ending}")
    return place, Origin(f"study {study.name}", scene.name, case.changes)
