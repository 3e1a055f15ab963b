"""Export results and scenes for other programs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from itertools import count
from pathlib import Path
from typing import Any

from postprocess.fields import FORMATS, PICTURES, TABLES
from postprocess.units import SYSTEMS
from tailslap.arguments import UnitSystem, checked_arguments, picture_pixels
from tailslap.errors import InputError, Verbatim, one_of
from tailslap.exports import PROGRAMS
from tailslap.progress import counted
from tailslap.result.load import load
from tailslap.result.result import FE, RIGID, Result
from tailslap.storage.folder import default_place, result_folder
from tailslap.storage.manifest import Origin

FIRST = {"vtkhdf": "fields.vtkhdf", "xdmf": "fields.xdmf", "vtu": "fields.pvd", "msh": "fields.msh"}
"""File to open, by format."""


@checked_arguments
def export(
    result: Result | str | os.PathLike[str],
    to: str,
    folder: str | os.PathLike[str] | None = None,
    *,
    changes: Sequence[str] = (),
    field: str | None = None,
    magnify: float = 1.0,
    units: UnitSystem = "si",
    picture_size: str | tuple[int, int] | None = None,
    force: bool = False,
) -> Path:
    """Export a result or a scene for other programs.

    Of a result these are fields and histories, of a scene the input file of another solver.

    Parameters
    ----------
    result : Result or path
        Result of a run, or its folder; of a deck the name of a scene of the program, or the path of a TOML file.
    to : str
        Format. "vtkhdf", "xdmf", "vtu", "msh": mesh and fields over time, for a run with `[output] fields = N`; "csv",
        "parquet": histories, and fields if any; "png", "gif": pictures of all instants. Of a scene: "calculix",
        "abaqus", input files that run as they are.
    folder : path, optional
        New or empty folder, or an earlier export. Default: folder of the result, or results/NAME+CHANGES of a scene,
        with "-FORMAT" appended.
    changes : sequence of str
        Changes of a scene, as texts KEY=VALUE.
    field : str, optional
        Field of the pictures, e.g. "stress_von_mises" or "velocity_y". Default: all.
    magnify : float
        Magnification of the elastic deformation in pictures [-].
    units : {"si", "us"}
        Units of the pictures, "si" or "us"; other files are in SI.
    picture_size : tuple of int or str, optional
        Width and height of pictures [pixels], (3200, 1400) or "3200x1400"; letters and lines are in proportion.
    force : bool
        Replace the result of another command or scene; read the intact files of a damaged result.

    Returns
    -------
    Path
        File to open, or the folder if there are several.

    Raises
    ------
    InputError
        For an unknown format, unit or size, a result without fields, a scene that the other program cannot have, or a
        folder with other files.

    Examples
    --------
    >>> import tailslap
    >>> result = tailslap.run("paper-table-3", {"output.fields": 20})
    >>> tailslap.export(result, "vtkhdf", "results/paraview")  # doctest: +SKIP
    PosixPath('results/paraview/fields.vtkhdf')
    """
    from postprocess.fields import contours, formats, series

    if to in PROGRAMS:
        return _export_deck(result, to, folder, tuple(changes), force)
    if to not in FORMATS:
        raise InputError("--to", to, one_of(to, (*FORMATS, *PROGRAMS)))
    if changes:
        raise InputError("--set", changes[0], f"{to} is of a result, not of a scene; remove --set")
    loaded = result if isinstance(result, Result) else load(result, force=force)
    base = Path(str(result)).resolve()
    if isinstance(result, Result):
        base = default_place(loaded.scene, loaded.changes)
    place = base.with_name(f"{base.name}-{to}") if folder is None else Path(folder)
    fields = None if to in TABLES else loaded.fields
    if field is not None and field not in series.SCALARS:
        raise InputError("--field", field, one_of(field, series.SCALARS))
    if units != "si" and to not in PICTURES:
        raise InputError("--units", units, f"{to} files are always in SI; remove --units")
    size = picture_pixels(picture_size)
    if size and to not in PICTURES:
        allowed = f"{to} files have no pictures; remove one of the two options"
        raise InputError("--picture-size", Verbatim(picture_size), allowed)
    inputs = loaded.inputs if isinstance(result, Result) else (Path(result),)
    with result_folder(
        place, inputs, force, Origin(f"export {to}", loaded.scene, tuple(loaded.changes))
    ) as unfinished:
        if fields is None:
            _write_tables(loaded, to, unfinished)
        elif to in PICTURES:
            names = list(series.SCALARS) if field is None else [field]
            options: dict[str, Any] = {
                "magnify": magnify,
                "units": SYSTEMS[units],
                **({"size": size} if size else {}),
            }
            numbers = count(1)
            with counted("Drawing pictures", len(names) * len(fields.t), 0) as show:
                options["follow"] = lambda: show(next(numbers))
                for name in names:
                    if to == "gif":
                        contours.animate(unfinished / f"{name}.gif", fields, name, **options)
                    else:
                        contours.draw_instants(unfinished, fields, name, **options)
        else:
            getattr(formats, f"write_{to}")(unfinished / FIRST[to], fields)
    return place / FIRST.get(to, "")


def _export_deck(scene: object, to: str, folder: object, changes: tuple[str, ...], force: bool) -> Path:
    """Write the deck of a scene.

    Returns its folder. Raises InputError.
    """
    from tailslap.case import case_of
    from tailslap.exports.deck import make_deck, write_deck
    from tailslap.scene.read import read_scene

    deck = make_deck(case_of(*read_scene(str(scene), changes)), to)
    origin = Origin(f"export {to}", deck.case.scene.name, deck.case.changes)
    place = default_place(*origin[1:], f"-{to}") if folder is None else Path(str(folder))
    with result_folder(place, (), force, origin) as unfinished:
        write_deck(deck, unfinished)
    return place


def _write_tables(result: Result, to: str, folder: Path) -> None:
    """Write histories, and fields if any, as tables."""
    from postprocess.fields import formats

    write, names = getattr(formats, f"write_{to}"), {FE: "history", RIGID: "rigid"}
    if not result.histories:
        raise InputError("RESULT", Verbatim(result.command), "it has no history; allowed are runs and sweeps")
    for label, columns in result.histories.items():
        write(folder / f"{names.get(label, label)}.{to}", (columns, columns.units))
    if result.make_fields is not None:
        for name, table in formats.field_tables(result.fields).items():
            write(folder / f"{name}.{to}", table)
