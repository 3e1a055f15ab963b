"""Pages: one file that holds all it shows, with no script and nothing fetched from elsewhere."""

import base64
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from postprocess.report.numbers import number


def write_page(
    path: Path, template: str, values: dict[str, Any], filters: dict[str, Callable[..., Any]] | None = None
) -> Path:
    """Fill the template of this package with the values and write the page; a value that is missing is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("postprocess"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    common = {
        "number": number,
        "padded": padded,
        "signed": signed,
        "subscripted": subscripted,
        "data_uri": data_uri,
    }
    environment.filters.update(common | (filters or {}))
    path.write_text(environment.get_template(template).render(**values), encoding="utf-8")
    return path


def data_uri(path: Path) -> str:
    """The PNG file as a data URI."""
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")


def padded(value: float, digits: int = 8) -> str:
    """A number with exactly so many significant digits, so that two in a row compare digit by digit."""
    return f"{value:#.{digits}g}".rstrip(".") if math.isfinite(value) else number(value)


def signed(value: float) -> str:
    """A relative difference: sign, three digits, exponent."""
    return f"{value:+.2e}" if math.isfinite(value) else number(value)


def subscripted(symbol: str) -> tuple[str, str]:
    """A symbol and its subscript: "v_GX" is v with GX."""
    letter, _, subscript = symbol.partition("_")
    return letter, subscript
