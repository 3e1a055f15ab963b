"""Contact force along the vehicle's side over time, as an image."""

import struct
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from postprocess.contours.viridis import viridis
from postprocess.figures.impact.forces import START, WIDE
from postprocess.figures.impact.strikes import StrikeMark, shaded
from postprocess.figures.svg.chart import Axis, Chart, Plot, draw_chart
from postprocess.figures.svg.marks import Image, Swatch
from postprocess.figures.svg.scale import round_ticks

Floats = NDArray[np.float64]
Bytes = NDArray[np.uint8]

COLUMNS = 600
"""Columns of the image; each is the largest force of its time."""


def draw_side_force(
    t: Floats, distances: Floats, force: Floats, unit: str, strikes: Sequence[StrikeMark] = ()
) -> Chart:
    """Force at each distance from the front and instant; nothing where there is none.

    t [s], shape (n,), even; distances of the nodes [m], rising from 0, shape (k,); force, shape (n, k), in `unit`, for
    example "kN" of each node or "kN/m".
    """
    caption = "Contact force along the side that faces the wall, over time"
    edges = np.concatenate([distances[:1], 0.5 * (distances[1:] + distances[:-1]), distances[-1:]])
    starts = np.unique(np.linspace(0, t.size, min(COLUMNS, t.size), endpoint=False).astype(int))
    table = np.maximum.reduceat(force, starts, axis=0).T
    most = float(table.max()) or 1.0
    rows = np.searchsorted(edges, np.linspace(edges[0], edges[-1], 4 * distances.size + 1)[:-1], "right") - 1
    image = Image(_png(_coloured(table[rows] / most)), (t[0], t[-1]), (edges[0], edges[-1]))
    keys = [
        Swatch(f"{value:g} {unit}", "#" + _coloured(np.array([value / most])).tobytes()[:3].hex())
        for value in round_ticks(0.0, most, 5)[1:]
    ]
    y = Axis("distance from the front [m]", low=float(edges[-1]), high=float(edges[0]))
    plot = Plot((*keys, image, *shaded(strikes)), y, 200.0, has_grid=False)
    return draw_chart("side-force", caption, (plot,), START, "Force", WIDE)


def _coloured(shares: Floats) -> Bytes:
    """Red, green, blue and cover of each share of the largest force, shape (..., 4); clear where there is none. The
    largest is the darkest."""
    colours = np.rint(255.0 * np.pad(viridis(256)[::-1], ((0, 0), (0, 1)), constant_values=1.0))
    found = colours[np.rint(255.0 * np.clip(shares, 0.0, 1.0)).astype(int)]
    found[shares <= 0.0] = 0.0
    return found.astype(np.uint8)


def _png(pixels: Bytes) -> bytes:
    """PNG file of pixels, shape (rows, columns, 4)."""
    rows, columns = pixels.shape[:2]
    lines = np.zeros((rows, 1 + 4 * columns), np.uint8)
    lines[:, 1:] = pixels.reshape(rows, -1)
    parts = (
        (b"IHDR", struct.pack(">IIBBBBB", columns, rows, 8, 6, 0, 0, 0)),
        (b"IDAT", zlib.compress(lines.tobytes(), 9)),
        (b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    )
