"""Finds and reads scenes; `--set` is put in here."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path

from tailslap.errors import InputError
from tailslap.scene.schema import Scene
from tailslap.scene.vary import Source, parse_changes, vary


def shipped_scenes() -> dict[str, str]:
    """Scenes that come with the program: name and text."""
    folder = files("tailslap") / "scenes"
    found = sorted(
        (item for item in folder.iterdir() if item.name.endswith(".toml")), key=lambda item: item.name
    )
    return {item.name.removesuffix(".toml"): item.read_text(encoding="utf-8") for item in found}


def title(text: str) -> str:
    """A scene's first line, which is a comment that says what it is."""
    return text.splitlines()[0].lstrip("# ").rstrip()


def read_scene(name: str, changes: Iterable[str] = ()) -> tuple[Scene, Source]:
    """Read and validate a scene.

    Parameters
    ----------
    name : str
        Path of a .toml file, or the name of a scene that comes with the program.
    changes : iterable of str
        As given by --set, "plate.thickness=20 mm"; "plate.density=" takes the key out.

    Returns
    -------
    scene : Scene
        SI.
    source : Source
        Where it came from.

    Raises
    ------
    InputError
        For a file that cannot be read, or the first key that is wrong.
    """
    source = read_source(name)
    return vary(source, parse_changes(changes, source.given))


def read_source(name: str) -> Source:
    """What the scene says, not yet validated. Raises InputError."""
    return source_of_text(scene_text(name), name)


def source_of_text(text: str, name: str = "SCENE") -> Source:
    """The same for a scene's text; name: what errors call it."""
    try:
        return Source(text.rstrip("\n") + "\n", tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise InputError(name, "a file that is not TOML", f"the parser says: {error}") from None


def scene_text(name: str) -> str:
    """Text of a scene's file, or of a scene that comes with the program. Raises InputError."""
    shipped = shipped_scenes()
    path = Path(name)
    if name in shipped and not path.is_file():
        return shipped[name]
    if path.suffix != ".toml" and not path.exists():
        near = difflib.get_close_matches(name, shipped, 1)
        hint = f'; did you mean "{near[0]}"?' if near else ""
        raise InputError("SCENE", name, f"allowed is a .toml file or one of {', '.join(shipped)}{hint}")
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError("SCENE", name, "there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError("SCENE", name, f"the file cannot be read: {error}") from None
