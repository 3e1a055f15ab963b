"""Define command-line options and their types.

They are numbers in ASCII digits within bounds, names of folders and non-empty texts.
"""

import math
import os
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stdout
from functools import partial
from pathlib import Path
from typing import Any, get_args

import click

from tailslap import progress
from tailslap.arguments import UnitSystem, picture_pixels
from tailslap.scene import read, schema

option = partial(click.option, show_default=True)

WHOLE = re.compile(r"[+-]?[0-9]{1,18}")
REAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
MAX_RUNS = 1_000_000
"""Largest number of runs of a sweep."""


class Whole(click.IntRange):
    """Whole number in ASCII digits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return the number, or fail with the allowed values."""
        is_odd = isinstance(value, float) and not value.is_integer()
        if is_odd or (isinstance(value, str) and not WHOLE.fullmatch(value.strip())):
            self.fail(f"{value!r} is not a whole number.", param, ctx)
        return int(super().convert(value, param, ctx))


class Real(click.FloatRange):
    """Finite number in ASCII digits."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number, or fail with the allowed values."""
        is_odd = isinstance(value, float) and not math.isfinite(value)
        if is_odd or (isinstance(value, str) and not REAL.fullmatch(value.strip())):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return float(super().convert(value, param, ctx))


class Folder(click.Path):
    """Path of a result folder."""

    what = "folder"

    def __init__(self) -> None:
        super().__init__(readable=False, dir_okay=self.what == "folder", path_type=Path)

    def convert(
        self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None
    ) -> Any:
        """Return the path, or fail for an empty one."""
        if isinstance(value, str) and not value.strip():
            self.fail(f"the path is empty; allowed is the path of a {self.what}.", param, ctx)
        return super().convert(value, param, ctx)


class File(Folder):
    """Path of a file that is written."""

    what = "file"


class Text(click.ParamType):
    """Non-empty text."""

    name = "text"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the text without surrounding blanks, or fail for an empty one."""
        if not (text := str(value).strip()):
            self.fail("the text is empty.", param, ctx)
        return text


class PictureSize(click.ParamType):
    """Width and height of pictures."""

    name = "widthxheight"

    def convert(
        self, value: str | Sequence[int] | None, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int] | None:
        """Return the pair. Raises InputError for other values."""
        return picture_pixels(value)


def _quiet(context: click.Context, parameter: click.Parameter, is_set: bool) -> None:
    """Discard standard output and progress."""
    if is_set:
        nowhere = context.with_resource(open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        context.with_resource(redirect_stdout(nowhere))
        context.with_resource(progress.shown_as("none"))


def _progress(context: click.Context, parameter: click.Parameter, is_set: bool) -> None:
    """Log progress as lines until the command ends."""
    if is_set:
        context.with_resource(progress.shown_as("lines"))


def complete_scene(context: click.Context, parameter: click.Parameter, typed: str) -> list[str]:
    """Return names of scenes for completion."""
    names = [*read.shipped_scenes(), *(str(path) for path in Path().glob("*.toml"))]
    return [name for name in names if name.startswith(typed)]


def complete_key(context: click.Context, parameter: click.Parameter, typed: str) -> list[str]:
    """Return keys of a scene with the equals sign, for completion."""
    keys = (re.sub(rf"^({'|'.join(schema.LISTED)})\.", r"\1.0.", key) for key in schema.MEANINGS)
    return [f"{key}=" for key in keys if key.startswith(typed)]


def report(numbers: Mapping[str, object], text: str, as_json: bool) -> int:
    """Print the numbers as JSON, or the text.

    Returns the exit status of success.
    """
    from postprocess.report import data_files

    click.echo(data_files.summary_text(numbers) if as_json else text)
    return 0


SCENE = click.Argument(["name"], metavar="SCENE", shell_complete=complete_scene)
SET = click.Option(
    ["--set", "changes"],
    multiple=True,
    metavar="KEY=VALUE",
    help="Set a key of the scene, e.g. plate.thickness=20mm; KEY= removes it.",
    shell_complete=complete_key,
)
ALLOW_LARGE = click.Option(
    ["--allow-large"],
    is_flag=True,
    help="Run even if the estimate exceeds this machine's memory, threads or time.",
)
NO_BAND = click.Option(["--no-band"], is_flag=True, help="Omit the band of the force over varied inputs.")
WORKERS = click.Option(
    ["--workers"], type=Whole(1, 256), help="Number of worker processes  [default: number of cores]"
)
JSON = click.Option(["--json", "as_json"], is_flag=True, help="Print the results as JSON, in SI.")
_flag = partial(click.Option, is_flag=True, expose_value=False, is_eager=True)
QUIET = _flag(["--quiet", "-q"], callback=_quiet, help="Print only errors.")
LINES = "Log progress at intervals if standard error is not a terminal."
PROGRESS = _flag(["--progress"], callback=_progress, help=LINES)
SYSTEMS = click.Choice(get_args(UnitSystem))
UNITS = click.Option(
    ["--units"], type=SYSTEMS, default="si", help="Units of displayed results; files are in SI."
)
PRINTED = (UNITS, JSON, QUIET)
"""Options of the printed output."""
WATCHED = (*PRINTED, PROGRESS)
"""Options of a command that shows progress."""
PICTURE_SIZE = click.Option(
    ["--picture-size"],
    type=PictureSize(),
    metavar="WIDTHxHEIGHT",
    help="Pixels of the pictures; letters and lines are in proportion  [default: 1600x700, of animations less]",
)
FORCE = click.Option(["--force"], is_flag=True, help="Replace the result of another command or scene.")
FORCE_READ = click.Option(
    ["--force"],
    is_flag=True,
    help="Replace the result of another command or scene; read the intact files of a damaged one.",
)


def place_option(ending: str = "") -> click.Option:
    """Return the option of a result folder with its default."""
    default = f"results/NAME+CHANGES{ending}"
    return click.Option(["--out"], type=Folder(), help=f"Result folder  [default: {default}]")


def with_options(*options: click.Parameter) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Return a decorator that adds options to a command."""

    def decorated(function: Callable[..., int]) -> Callable[..., int]:
        present = getattr(function, "__click_params__", [])
        function.__click_params__ = [*present, *reversed(options)]  # type: ignore[attr-defined]
        return function

    return decorated
