"""Make cases from arguments of public functions."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tailslap.case import case_of, resources
from tailslap.case.case import Case
from tailslap.errors import Interrupted
from tailslap.scene import read
from tailslap.scene.vary import Source, named, parse_changes, shown, vary

Scene = read.Scene | Case
"""Name of a scene of the program, path of a TOML file, tables of a scene, or a case."""

Changes = Mapping[str, Any] | Sequence[str]
"""Values by dotted key: numbers in SI, texts with a unit, objects, None to remove the key; or texts KEY=VALUE."""


def case_of_scene(scene: Scene, changes: Changes | None, level: int = 4) -> Case:
    """Return the case of a changed scene.

    level: of the caller's line on the stack. Raises InputError.
    """
    if isinstance(scene, Case) and not changes:
        return scene
    source = scene.source if isinstance(scene, Case) else read.read_source(scene)
    typed = not isinstance(changes, Mapping)
    values = parse_changes(changes or (), source.tables) if typed else named(read.plain(changes))
    varied, source = vary(source, values)
    warn_of_numbers(source, typed, level + 1)
    return case_of(varied, source)


def warn_of_numbers(source: Source, typed: bool, level: int = 4) -> None:
    """Warn of unusual numbers without a unit.

    typed: True if the changes are texts; level: of the caller's line on the stack.
    """
    for remark in read.remarks(source, typed):
        warnings.warn(remark, stacklevel=level)


def affordable_case(scene: Scene, changes: Changes | None, allow_large: bool, level: int = 5) -> Case:
    """Return the case of a scene with a plate for this machine.

    The plate fits its memory, threads and time. level: of the caller's line on the stack. Raises InputError.
    """
    case = case_of_scene(scene, changes, level)
    resources.demand_run(case.scene, case.duration, allow_large)
    return case


def change_texts(changes: Changes | None) -> tuple[str, ...]:
    """Return changes as texts, for worker processes."""
    return shown(named(changes)) if isinstance(changes, Mapping) else tuple(changes or ())


@contextmanager
def folder_or_temporary(folder: str | os.PathLike[str] | None) -> Iterator[Path]:
    """Yield the folder of a result, without one a temporary folder."""
    if folder is not None:
        yield Path(folder)
        return
    with TemporaryDirectory(prefix="tailslap-") as temporary:
        try:
            yield Path(temporary) / "result"
        except Interrupted:
            raise KeyboardInterrupt("interrupted; without a folder no rows are saved") from None
