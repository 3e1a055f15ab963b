"""Find and read scenes, with remarks on numbers without a unit."""

import codecs
import math
import os
import re
import stat
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from machine_code.system.operating_system import NO_WAIT
from tailslap import errors
from tailslap.arguments import checked_arguments
from tailslap.scene import schema, units, write
from tailslap.scene.validate import value_in
from tailslap.scene.vary import Source, parse_changes, vary

Scene = str | os.PathLike[str] | Mapping[str, Any]
"""Name of a scene of the program, path of a TOML file, or tables of a scene."""

UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
"""Byte order marks of UTF-16."""

MAX_NAME, MAX_BYTES, MAX_LINE, MAX_DEPTH = 4096, 262_144, 10_000, 8
"""Limits of a scene: length of its path, size of its file, length of a line, depth of tables and lists."""

DECIMAL_COMMA = re.compile(r"=\s*[-+]?[0-9]+,[0-9]")
"""Beginning of a number with a decimal comma."""

SPEED, ANGLE = (1.0, 40.0, "km/h"), (math.radians(1.0), math.radians(60.0), "deg")
USUAL = {
    "vehicle.length": (1.5, 40.0, "ft"),
    "vehicle.width": (0.5, 6.0, "ft"),
    "vehicle.mass": (200.0, 2e5, "lb"),
    "impact.speed": SPEED,
    "impact.angle": ANGLE,
    "start.angle": ANGLE,
    "start.corner_speed": SPEED,
    "strike.duration": (1e-3, 2.0, "ms"),
    "plate.thickness": (1e-4, 1.0, "mm"),
}
"""Usual range of a key [SI], and another common unit."""


def read_text(path: Path, most: int, undecodable: str = "strict") -> str:
    """Read a regular file as text.

    The file has at most `most` bytes, in UTF-8 or, after a byte order mark, UTF-16; lines end with line feeds. Devices
    and pipes are not opened. undecodable: treatment of bytes that cannot be decoded, as in `bytes.decode`.

    Raises OSError or ValueError with the reason.
    """
    if not stat.S_ISREG(path.stat().st_mode):
        raise ValueError("it is not a regular file")
    with open(os.open(path, os.O_RDONLY | NO_WAIT), "rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise ValueError(f"it is too large; the limit is {most} bytes")
    try:
        text = content.decode("utf-16" if content.startswith(UTF_16) else "utf-8-sig", undecodable)
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise ValueError("it is neither text in UTF-8 nor in UTF-16 with a byte order mark")
    return text.replace("\r\n", "\n")


def shipped_scenes() -> dict[str, Path]:
    """Return the files of shipped scenes by name."""
    return {path.stem: path for path in sorted(Path(__file__).with_name("shipped").glob("*.toml"))}


@checked_arguments
def scenes() -> dict[str, str]:
    """List the scenes of the program.

    Returns
    -------
    dict of str
        Titles by name: the first line of each file, a comment.

    Examples
    --------
    >>> import tailslap
    >>> tailslap.scenes()["mash-tl1-car"]
    'MASH TL-1, test 1-10: the 1100C small car at 31 mph and 25 deg'
    """
    texts = {name: path.read_text(encoding="utf-8") for name, path in shipped_scenes().items()}
    return {name: text.splitlines()[0].lstrip("# ").rstrip() for name, text in texts.items()}


def read_scene(name: str, changes: Iterable[str] = ()) -> tuple[schema.Scene, Source]:
    """Read and validate a scene.

    Parameters
    ----------
    name : str
        Path of a .toml file, or the name of a scene of the program.
    changes : iterable of str
        Texts as of --set: "plate.thickness=20 mm"; "plate.density=" removes the key.

    Returns
    -------
    scene : Scene
        Validated scene, in SI.
    source : Source
        Its text and tables.

    Raises
    ------
    InputError
        For a file that cannot be read, an invalid key, or missing keys.
    """
    source = read_source(name)
    return vary(source, parse_changes(changes, source.tables))


def read_source(scene: Scene) -> Source:
    """Read a scene's tables, without validation.

    A scene without the key `name` takes that of the file, tables "scene". Raises InputError.
    """
    if isinstance(scene, Mapping):
        return Source(tables={"name": "scene"} | plain(scene))
    name = os.fspath(scene)
    source = source_of_text(scene_text(name), name)
    return replace(source, tables={"name": Path(name).stem} | source.tables)


def plain(value: Any) -> Any:
    """Convert values of NumPy in tables to those of Python."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: plain(inner) for key, inner in value.items()}
    return value


def source_of_text(text: str, name: str = "SCENE") -> Source:
    """Parse the text of a scene, without validation.

    name: the scene in error messages. Raises InputError.
    """
    if len(max(text.split("\n"), key=len)) > MAX_LINE:
        why = f"the limit is {MAX_LINE} characters"
        raise errors.InputError(name, errors.Verbatim("a very long line"), why)
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError itself for an integer of thousands of digits
        hint = f"; {units.COMMA}" if DECIMAL_COMMA.search(text) else ""
        why = f"{errors.shortened(str(error))}{hint}"
        raise errors.InputError(name, errors.Verbatim("a file that is not TOML"), why) from None
    if _is_too_deep(tables):
        allowed = f"the limit is {MAX_DEPTH} levels"
        raise errors.InputError(name, errors.Verbatim("tables or lists nested too deep"), allowed)
    return Source(text.rstrip("\n") + "\n", tables)


def _is_too_deep(value: object) -> bool:
    """Return True if tables and lists are nested deeper than `MAX_DEPTH`."""
    level = [value]
    for _ in range(MAX_DEPTH + 1):
        level = [
            inner
            for outer in level
            if isinstance(outer, Mapping | list)
            for inner in (outer.values() if isinstance(outer, Mapping) else outer)
        ]
    return bool(level)


def scene_text(name: str) -> str:
    """Return the text of a scene file or of a shipped scene.

    Raises InputError.
    """
    shipped = shipped_scenes()
    path = Path(name)
    if len(name) > MAX_NAME:
        raise errors.InputError("SCENE", name, f"the limit is {MAX_NAME} characters")
    if name in shipped and (path.is_dir() or not errors.is_there(path)):
        return shipped[name].read_text(encoding="utf-8")
    if path.suffix != ".toml" and not errors.is_there(path):
        allowed = errors.one_of(name, shipped, "allowed is a .toml file or one of")
        raise errors.InputError("SCENE", name, allowed)
    try:
        return read_text(path, MAX_BYTES)
    except FileNotFoundError:
        raise errors.InputError("SCENE", name, "the file does not exist") from None
    except OSError as error:
        raise errors.place_error(name, "the file cannot be read", error, "SCENE") from None
    except ValueError as error:
        raise errors.InputError("SCENE", name, f"the file cannot be read: {error}") from None


def unit_remarks(source: Source) -> dict[str, str]:
    """Return remarks on changes to numbers without a unit, by key.

    They concern keys that have another unit than SI in the file.
    """
    return {
        key: f"{_in_two_units(source, key, unit)}; the scene has this key in {unit}"
        for key, unit in write.plain_numbers(source).items()
    }


def remarks(source: Source, typed: bool = True) -> Iterator[str]:
    """Yield remarks on unusual numbers without a unit.

    typed: also on changes, which are texts, by their units.
    """
    plain = unit_remarks(source) if typed else {}
    yield from plain.values()
    trailers = [f"trailer.{number}" for number in range(len(source.tables.get("trailer", ())))]
    for usual_key, (low, high, unit) in USUAL.items():
        table, name = usual_key.split(".")
        for key in (f"{place}.{name}" for place in [table, *(trailers if table == "vehicle" else ())]):
            value = value_in(source.tables, key)
            if isinstance(value, int | float) and key not in plain and not low <= value <= high:
                yield _in_two_units(source, key, unit)


def _in_two_units(source: Source, key: str, unit: str) -> str:
    """Return the number of a key in two units, as a remark.

    They are the SI unit and another one.
    """
    value, si = value_in(source.tables, key), write.unit_at(key)
    return (
        f"{key} = {value:g} without a unit is {value:g} {si}, {units.converted(value, si, unit):.4g} {unit}"
    )
