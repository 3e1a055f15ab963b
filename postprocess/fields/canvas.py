"""Off-screen pictures by PyVista with texts by Pillow.

Places are pixels from the lower left corner. There is no lighting, so that a pixel inside an element has exactly the
colour of its band. Letters and lines are in proportion to the size of a picture: a point is a pixel of one of `SIZE`.
"""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from postprocess.report.prose import printed_numbers
from postprocess.units import SUBSCRIPT

if TYPE_CHECKING:
    from PIL import Image, ImageFont

Size = tuple[int, int]
"""Width and height of a picture [pixels]."""

SIZE: Size = (1600, 700)
"""Usual size of a picture."""

TEXT = 26
"""Usual size of letters, 7 points in a print 16 cm wide [points]."""

LIGHT = {"paper": "#ffffff", "ink": "#1b1f24", "wall": "#e9ebee", "hatch": "#8d959e"}
DARK = {"paper": "#14181d", "ink": "#e6e9ed", "wall": "#232a32", "hatch": "#5b6672"}
"""Colours of pictures on white paper, and on dark screens."""

ALIGNED = {"left": 0.0, "middle": 0.5, "right": 1.0}
NO_WINDOW = "VTK finds neither libEGL.so.1 nor libOSMesa.so nor a display"


_LOADING = threading.Lock()


def load_pyvista() -> Any:
    """Import PyVista, or wait for another thread that does."""
    with _LOADING:
        import pyvista.plotting

        return pyvista


def load_beside() -> None:
    """Import PyVista beside a computation."""

    def load() -> None:
        with suppress(ImportError):  # raised again where a picture is drawn
            load_pyvista()

    threading.Thread(target=load).start()


class Canvas:
    """Picture that is drawn, and cleared for the next one.

    Raises ImportError on a machine that cannot draw.
    """

    def __init__(self, size: Size = SIZE, dot: float = 0.0) -> None:
        """Open an off-screen window.

        dot: pixels of a point, by default in proportion to the size.
        """
        self._pyvista = pyvista = load_pyvista()
        from vtkmodules.vtkCommonCore import vtkLogger

        os.environ.setdefault("ALLOW_PLOTTING", "true")  # PyVista would open another window to find out
        self.size, self.dot = size, dot or min(size[0] / SIZE[0], size[1] / SIZE[1])
        self._words: list[tuple[Any, ...]] = []
        options = {"off_screen": True, "lighting": "none", "theme": pyvista.themes.DocumentTheme()}
        verbosity = vtkLogger.GetCurrentVerbosityCutoff()
        # It warns of a missing display before it tries EGL and OSMesa.
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
        try:
            self._plotter = pyvista.Plotter(window_size=list(size), **options)
            self._plotter.render_window.Initialize()
        finally:
            vtkLogger.SetStderrVerbosity(verbosity)
        if not self._plotter.render_window.IsCurrent():  # drawing would end the process
            raise ImportError(NO_WINDOW)
        self._plotter.enable_anti_aliasing("msaa", multi_samples=4)
        camera, middle = self._plotter.camera, (0.5 * size[0], 0.5 * size[1])
        camera.focal_point, camera.position, camera.up = (*middle, 0.0), (*middle, 10.0), (0.0, 1.0, 0.0)
        camera.parallel_projection, camera.parallel_scale = True, middle[1]
        camera.clipping_range = (1.0, 20.0)
        self.clear()

    def close(self) -> None:
        """Close the window."""
        self._plotter.close()

    def clear(self, colours: Mapping[str, str] = LIGHT) -> None:
        """Begin a picture in the colours of a theme."""
        self._plotter.clear_actors()
        self._words.clear()
        self._colours = colours
        self._plotter.background_color = colours["paper"]

    def fill(self, points: ArrayLike, cells: ArrayLike, height: float = 0.0, **style: Any) -> None:
        """Draw elements at a height above others.

        points: shape (n, 2) [pixels]; cells: shape (e, corners); style: of PyVista.
        """
        places = np.insert(points, 2, height, axis=1)
        self._add(self._pyvista.PolyData.from_regular_faces(places, np.asarray(cells)), style)

    def lines(self, ends: ArrayLike, width: float, color: str, height: float = 0.0) -> None:
        """Draw lines between pairs of pixels.

        ends: shape (n, 2, 2); width [points].
        """
        if np.size(ends):
            places = np.insert(np.reshape(ends, (-1, 2)), 2, height, axis=1)
            style = {"color": color, "line_width": width * self.dot}
            self._add(self._pyvista.line_segments_from_points(places), style)

    def dots(self, pixel: ArrayLike, radius: float) -> None:
        """Draw a ring with a white middle.

        radius [points].
        """
        turns = np.exp(2j * np.pi * np.arange(32) / 32)
        circle = self.dot * radius * np.column_stack([turns.real, turns.imag])
        for height, part, color in ((3.0, 1.0, LIGHT["ink"]), (4.0, 0.63, LIGHT["paper"])):
            self.fill(np.asarray(pixel) + part * circle, np.arange(32)[None], height, color=color)

    def _add(self, mesh: Any, style: dict[str, Any]) -> None:
        """Add a mesh without lighting.

        Colours may be names of the theme.
        """
        style = {"line_width": self.dot, **style, "lighting": False, "show_scalar_bar": False}
        if "color" in style:
            style["color"] = self._colours.get(style["color"], style["color"])
        self._plotter.add_mesh(mesh, reset_camera=False, render=False, **style)

    def write(
        self,
        text: str,
        pixel: ArrayLike,
        shift: tuple[float, float] = (0.0, 0.0),
        size: float = TEXT,
        align: str = "left",
        is_bold: bool = False,
        ground: float = 0.0,
    ) -> None:
        """Write a text whose base line begins, or ends, beside a pixel.

        shift, size [points]; align: one of `ALIGNED`; ground: opacity of the paper behind it.
        """
        place = np.asarray(pixel) + self.dot * np.array(shift)
        self._words.append((text, place, size, align, is_bold, ground))

    def image(self) -> Image.Image:
        """Return the picture as an image of Pillow."""
        from PIL import Image, ImageDraw

        self._plotter.render()
        image = Image.fromarray(np.asarray(self._plotter.screenshot(return_img=True)))
        draw = ImageDraw.Draw(image, "RGBA")
        for words in self._words:
            self._set(draw, *words)
        return image

    def _set(
        self, draw: Any, text: str, pixel: Any, points: float, align: str, is_bold: bool, ground: float
    ) -> None:
        """Write a text into an image of Pillow."""
        size = points * self.dot
        pieces = [
            (piece, font(round(size * (0.72 if low else 1.0)), is_bold), low) for piece, low in typeset(text)
        ]
        wide = sum(typeface.getlength(piece) for piece, typeface, _ in pieces)
        x, y = pixel[0] - ALIGNED[align] * wide, self.size[1] - pixel[1]
        if ground:
            box = (x - 0.2 * size, y - size, x + wide + 0.2 * size, y + 0.3 * size)
            draw.rectangle(box, fill=f"{self._colours['paper']}{round(255 * ground):02x}")
        for piece, typeface, low in pieces:
            draw.text((x, y + 0.2 * size * low), piece, self._colours["ink"], typeface, anchor="ls")
            x += typeface.getlength(piece)


def typeset(text: str) -> list[tuple[str, bool]]:
    """Return the pieces of a text, and which of them are indices.

    Numbers are set as in print.
    """
    parts = SUBSCRIPT.split(printed_numbers(text))
    return [(part, number % 3 == 2) for number, part in enumerate(parts) if part]


@functools.cache
def font(size: int, is_bold: bool) -> ImageFont.FreeTypeFont:
    """Return DejaVu of this size, which has Greek letters and arrows."""
    import matplotlib as mpl
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if is_bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)
