"""Types of the command line's options: numbers in ASCII digits within bounds, folders with a name, texts that are not
empty. Anything else is wrong input, which the message of the option names."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

WHOLE = re.compile(r"[+-]?[0-9]{1,18}")
REAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


class Whole(click.IntRange):
    """A whole number, in digits alone."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number; fails with what is allowed."""
        if isinstance(value, str) and not WHOLE.fullmatch(value.strip()):
            self.fail(f"{value!r} is not a whole number.", param, ctx)
        return super().convert(value, param, ctx)


class Real(click.FloatRange):
    """A finite number, in digits alone."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number; fails with what is allowed."""
        if isinstance(value, str) and not REAL.fullmatch(value.strip()):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return super().convert(value, param, ctx)


class Folder(click.Path):
    """Place of a result folder."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path; fails for an empty one."""
        if isinstance(value, str) and not value.strip():
            self.fail("it is empty; allowed is the path of a folder.", param, ctx)
        return super().convert(value, param, ctx)


class Text(click.ParamType):
    """A text that is not empty."""

    name = "text"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The text without the blanks around it; fails for an empty one."""
        if not value.strip():
            self.fail("it is empty.", param, ctx)
        return value.strip()
