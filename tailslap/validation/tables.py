"""Read published values, and vehicles with ranges of their inputs."""

import tomllib
from importlib import resources
from typing import Any

from tailslap.scene.units import to_si

SETS = ("first", "second")
"""Names of the sets of ranges."""


def parameters(name: str = SETS[-1]) -> dict[str, Any]:
    """Return vehicles and ranges of a set, and the published values."""
    here = resources.files(__package__)
    files = (here.joinpath(f"{file}.toml").read_text("utf-8") for file in (name, "published"))
    return {key: value for text in files for key, value in tomllib.loads(text).items()}


def metres_or_newtons(text: str) -> float:
    """Return a quantity with its unit [SI]."""
    number, unit = text.split(" ", 1)
    return float(number) * to_si(unit)[0]
