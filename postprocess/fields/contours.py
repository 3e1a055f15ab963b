"""Contour pictures of fields on the plate above the wall.

PNG files of one or many instants, and GIF. The view includes the plate at all its instants, and the adjacent part of
the wall. A field has one scale of colours for all instants, so that visible changes are real.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from postprocess.fields.series import COMPONENTS, ELEMENTS, UNITS, FieldSeries
from postprocess.fields.sheet import (
    SIZE,
    ContourField,
    Floats,
    Mesh,
    Sheet,
    Size,
    colour_scale,
    draw_field,
    image_of,
)
from postprocess.figures.histories import power_of_ten
from postprocess.units import SI, Units

if TYPE_CHECKING:
    from PIL import Image

FRAME_MS, GIF_SIZE, COLOURS = 120, (960, 420), 64


@dataclass(frozen=True)
class Situation:
    """Geometry and texts of pictures of one instant.

    plate: deformed nodes [m] and elements; wall: the same, None for the line Y = 0; corner, centroid: points P and G
    [m] to be marked; time: of the strike [s].
    """

    plate: Mesh
    wall: Mesh | None = None
    corner: Sequence[float] | None = None
    centroid: Sequence[float] | None = None
    scene: str = ""
    time: float | None = None


def draw_contours(
    situation: Situation, fields: Sequence[ContourField], out_dir: Path, units: Units = SI, size: Size = SIZE
) -> list[Path]:
    """Draw fields as `contour_NAME.png` and return the paths.

    units: of the texts; size: [pixels].
    """
    length, length_unit = units.of("m")
    (points, cells), wall, paths = situation.plate, situation.wall, []
    points = length * points
    sheet = Sheet(points, None if wall is None else length * wall[0], length_unit, size)
    moment = [] if situation.time is None else [f"tail-slap at t = {situation.time:.4g} s"]
    for field in fields:
        factor, unit = shown_unit(field, units)
        field, marks = replace(field, unit=unit, values=factor * field.values), dict[tuple[float, ...], str]()
        if situation.corner is not None:
            marks[tuple(length * np.asarray(situation.corner))] = "P"
        if situation.centroid is not None:
            centre = length * np.asarray(situation.centroid)
            places = points if field.where == "nodal" else points[cells].mean(axis=1)
            at_centre = value_at(places, field.values, centre)
            value = at_centre if field.of_centre is None else factor * field.of_centre
            marks[tuple(centre)] = f"G: {value:#.5g} {unit}"
        texts = ",  ".join([situation.scene, *moment])
        figure = draw_field(sheet, (points, cells), field, colour_scale(field.values), texts, marks)
        paths.append(out_dir / f"contour_{field.name}.png")
        save(image_of(figure), paths[-1])
    return paths


def field_title(name: str) -> str:
    """Return the title of a field of `SCALARS`, followed by its component."""
    words = name.replace("_", " ").replace("stress von mises", "von Mises stress")
    return words[0].upper() + (f"{words[1:-1]}{words[-1].upper()}" if name in COMPONENTS else words[1:])


def shown_unit(field: ContourField, units: Units) -> tuple[float, str]:
    """Return the factor and unit for a field.

    Stresses have the prefix that suits the largest.
    """
    factor, unit = units.of(field.unit)
    power = power_of_ten(field.values)
    if unit != "Pa" or not 3 <= power <= 9:
        return factor, unit
    return 10.0**-power, {3: "kPa", 6: "MPa", 9: "GPa"}[power]


def draw_instants(
    folder: Path,
    series: FieldSeries,
    name: str,
    magnify: float = 1.0,
    instants: Sequence[int] | None = None,
    units: Units = SI,
    size: Size = SIZE,
    follow: Callable[[], object] = lambda: None,
) -> list[Path]:
    """Draw instants as NAME_0000.png and so on, and return the paths.

    name: of `SCALARS`; magnify: factor of the elastic deformation; instants: numbers, by default all; units: of the
    texts; size: of a picture [pixels]; follow: called after each picture.
    """
    chosen = range(len(series.t)) if instants is None else [k % len(series.t) for k in instants]
    paths = [folder / f"{name}_{k:04d}.png" for k in chosen]
    for path, frame in zip(paths, frames(series, name, magnify, chosen, units, size), strict=True):
        save(frame, path)
        follow()
    return paths


def animate(
    path: Path,
    series: FieldSeries,
    name: str,
    magnify: float = 1.0,
    units: Units = SI,
    size: Size = GIF_SIZE,
    follow: Callable[[], object] = lambda: None,
) -> Path:
    """Write all instants as a repeating GIF.

    follow: called after each instant.
    """
    pictures = []
    for frame in frames(series, name, magnify, range(len(series.t)), units, size):
        pictures.append(frame.quantize(COLOURS))
        follow()
    first, *further = pictures
    first.save(path, save_all=True, append_images=further, duration=FRAME_MS, loop=0)
    return path


def frames(
    series: FieldSeries, name: str, magnify: float, instants: Sequence[int], units: Units, size: Size = SIZE
) -> Iterator[Image.Image]:
    """Yield the chosen instants of a field as images of Pillow.

    name: of `SCALARS`; instants: numbers.
    """
    where: Literal["nodal", "element"] = "element" if name in ELEMENTS else "nodal"
    whole = ContourField(name, field_title(name), UNITS[name], series.scalar(name), where)
    (factor, unit), (length, length_unit) = shown_unit(whole, units), units.of("m")
    values, places = factor * whole.values, length * series.places(magnify)
    scale = colour_scale(values)
    deformed = f",  elastic deformation × {magnify:g}" if magnify != 1.0 else ""
    sheet = Sheet(places.reshape(-1, 2), None, length_unit, size)
    for k in instants:
        field, note = replace(whole, unit=unit, values=values[k]), f"t = {series.t[k]:.4f} s{deformed}"
        yield image_of(draw_field(sheet, (places[k], series.corners), field, scale, note))
        gc.collect(0)  # a figure is in cycles of references with its image


def save(image: Image.Image, path: Path) -> None:
    """Write a PNG of a few colours, which halves its size.

    The colours of bands are exact.
    """
    image.quantize(COLOURS).save(path, optimize=True)


def value_at(points: Floats, values: Floats, place: ArrayLike) -> float:
    """Return a nodal field at a point.

    The mean of the nearest nodes, weighted by the inverse of their distance.
    """
    far = np.hypot(*(points - np.asarray(place, float)).T)
    near = np.argsort(far)[:4]
    weights = 1.0 / np.maximum(far[near], 1e-6 * (far.max() or 1.0))
    return float(np.average(values[near], weights=weights))
