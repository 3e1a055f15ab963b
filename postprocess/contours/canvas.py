"""Off-screen VTK drawing in one fixed style: flat colours, text placed in pixels, the camera of a `View`."""

import ctypes
import importlib.util
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.contours.colour_scale import ColourScale
from postprocess.contours.view import View
from postprocess.contours.viridis import viridis

INK = "#1b1f24"
FONTS = {False: "DejaVuSans.ttf", True: "DejaVuSans-Bold.ttf"}
SAMPLES = 4
"""Of a pixel, against jagged lines."""

ROUND = 32
"""Corners of a disc."""

Floats = NDArray[np.float64]


class Canvas:
    """A window off the screen that looks straight down on the X-Y plane; what is added stays until it is removed."""

    def __init__(self, view: View) -> None:
        from vtkmodules import vtkRenderingFreeType, vtkRenderingOpenGL2  # noqa: F401  (they draw text, and the rest)
        from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

        self.renderer, self.window = vtkRenderer(), vtkRenderWindow()
        self.is_open = True
        self.renderer.SetBackground(1.0, 1.0, 1.0)
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(SAMPLES)
        self.window.SetSize(*view.size)
        self.window.AddRenderer(self.renderer)
        _look_down(self.renderer.GetActiveCamera(), view)

    def add(self, actor: Any) -> Any:
        """Add an actor; returns it."""
        self.renderer.AddActor(actor)
        return actor

    def remove(self, *actors: Any) -> None:
        """Take actors away again."""
        for actor in actors:
            self.renderer.RemoveActor(actor)

    def write(self, path: Path) -> None:
        """Write what is seen to a PNG file."""
        from vtkmodules.vtkIOImage import vtkPNGWriter
        from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

        self.window.Render()
        image, writer = vtkWindowToImageFilter(), vtkPNGWriter()
        image.SetInput(self.window)
        image.ReadFrontBufferOff()
        image.ShouldRerenderOff()
        writer.SetInputConnection(image.GetOutputPort())
        writer.SetFileName(str(path))
        writer.Write()

    def close(self) -> None:
        """Give the window back."""
        self.window.Finalize()
        self.is_open = False


@contextmanager
def canvas(view: View) -> Iterator[Canvas]:
    """A canvas that is closed when the block ends, however it ends."""
    choose_window()
    opened = Canvas(view)
    try:
        yield opened
    finally:
        opened.close()


def choose_window() -> None:
    """Without a display, has VTK open an EGL window at once; raises where there is no EGL library."""
    if sys.platform != "linux" or os.environ.get("DISPLAY"):
        return
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        raise RuntimeError(
            "pictures need a display or the library libEGL.so.1 (Debian and Ubuntu: package libegl1)"
        ) from None
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


def add_surface(
    plotter: Canvas, points: Floats, cells: Any, height: float, colour: str, edge: str = ""
) -> Any:
    """Cells (e, k), polygons of k corners, on points (n, 2) [m], at the given Z [m]: the higher one hides the lower.

    edge: colour of its mesh lines; without one it has none.
    """
    actor = _actor(_poly_data(points, height, polygons=cells))
    actor.GetProperty().SetColor(*_rgb(colour))
    if edge:
        _show_edges(actor, edge)
    return plotter.add(actor)


def add_field(plotter: Canvas, points: Floats, cells: Any, values: Floats, scale: ColourScale) -> Any:
    """The same at Z = 0 in colours of nodal values (n,), with black mesh lines. ValueError for another number."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    if values.shape != (len(points),):
        raise ValueError(f"{values.size} values for {len(points)} points")
    plate = _poly_data(points, 0.0, polygons=cells)
    plate.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True))
    actor = _actor(plate)
    mapper = actor.GetMapper()
    mapper.SetLookupTable(_colours(scale))
    mapper.SetUseLookupTableScalarRange(True)
    mapper.SetInterpolateScalarsBeforeMapping(True)
    _show_edges(actor, "#000000", 0.35)
    return plotter.add(actor)


def add_scale(plotter: Canvas, field: Any, scale: ColourScale) -> Any:
    """The scalar bar of a field, above the picture's middle."""
    from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor

    bar = vtkScalarBarActor()
    bar.SetLookupTable(field.GetMapper().GetLookupTable())
    bar.SetMaximumNumberOfColors(scale.bands)
    bar.SetNumberOfLabels(scale.labels)
    bar.SetLabelFormat(scale.format)
    bar.SetOrientationToHorizontal()
    bar.SetPosition(0.12, 0.77)
    bar.SetWidth(0.76)
    bar.SetHeight(0.09)
    bar.UnconstrainedFontSizeOn()
    style_text(bar.GetLabelTextProperty(), 21)
    return plotter.add(bar)


def add_line(plotter: Canvas, points: Floats, colour: str = INK) -> Any:
    """A polyline through points (k, 2) [m], two pixels wide."""
    actor = _actor(_poly_data(points, 0.01, lines=np.arange(len(points))[None, :]))
    actor.GetProperty().SetColor(*_rgb(colour))
    actor.GetProperty().SetLineWidth(2.0)
    return plotter.add(actor)


def add_disc(plotter: Canvas, centre: tuple[float, float], radius: float, colour: str, height: float) -> Any:
    """A filled disc; centre, radius and Z in m."""
    angles = np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
    points = centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return add_surface(plotter, points, np.arange(ROUND)[None, :], height, colour)


def add_text(
    plotter: Canvas,
    text: str,
    pixel: tuple[float, float],
    size: int,
    justify: str = "left",
    bold: bool = False,
) -> Any:
    """The text actor, its baseline starting (left), ending (right) or centred (center) at a pixel."""
    from vtkmodules.vtkRenderingCore import vtkTextActor

    actor = vtkTextActor()
    actor.SetInput(text)
    actor.SetPosition(*pixel)
    prop = actor.GetTextProperty()
    {"left": prop.SetJustificationToLeft, "right": prop.SetJustificationToRight}.get(
        justify, prop.SetJustificationToCentered
    )()
    style_text(prop, size, bold)
    return plotter.add(actor)


def style_text(prop: Any, size: int, bold: bool = False) -> None:
    """Sets ink, size in pixels and a font that has Greek letters and arrows: VTK's own has neither."""
    from vtkmodules.vtkCommonCore import VTK_FONT_FILE

    prop.SetFontFamily(VTK_FONT_FILE)
    prop.SetFontFile(str(_font_folder() / FONTS[bold]))
    prop.SetFontSize(size)
    prop.SetColor(*_rgb(INK))
    prop.ItalicOff()
    prop.BoldOff()


@cache
def _font_folder() -> Path:
    """Where Matplotlib's fonts are; it is not loaded for that."""
    found = importlib.util.find_spec("matplotlib")
    if found is None or found.origin is None:
        raise RuntimeError("pictures are written in the fonts of Matplotlib, which is not installed")
    return Path(found.origin).parent / "mpl-data" / "fonts" / "ttf"


def _rgb(colour: str) -> tuple[float, ...]:
    return tuple(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))


def _colours(scale: ColourScale) -> Any:
    """The table of the bands' colours."""
    from vtkmodules.vtkCommonCore import vtkLookupTable

    table = vtkLookupTable()
    table.SetNumberOfTableValues(scale.bands)
    table.SetTableRange(scale.low, scale.high)
    for band, colour in enumerate(viridis(scale.bands)):
        table.SetTableValue(band, (*colour.tolist(), 1.0))
    return table


def _poly_data(points: Floats, height: float, polygons: Any = None, lines: Any = None) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    places, data = vtkPoints(), vtkPolyData()
    places.SetData(numpy_to_vtk(np.column_stack([points, np.full(len(points), height)]), deep=True))
    data.SetPoints(places)
    if polygons is not None:
        data.SetPolys(_cells(polygons))
    if lines is not None:
        data.SetLines(_cells(lines))
    return data


def _cells(corners: Any) -> Any:
    """Cells of the same number of corners, shape (cells, corners)."""
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    corners, cells = np.asarray(corners, dtype=np.int64), vtkCellArray()
    offsets = np.arange(0, corners.size + 1, corners.shape[1], dtype=np.int64)
    flat = np.ascontiguousarray(corners.ravel())
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(flat, deep=True))
    return cells


def _actor(data: Any) -> Any:
    """An actor that no light changes."""
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputData(data)
    actor.SetMapper(mapper)
    actor.GetProperty().SetLighting(False)
    return actor


def _show_edges(actor: Any, colour: str, opacity: float = 1.0) -> None:
    prop = actor.GetProperty()
    prop.EdgeVisibilityOn()
    prop.SetEdgeColor(*_rgb(colour))
    prop.SetEdgeOpacity(opacity)
    prop.SetLineWidth(1.0)


def _look_down(camera: Any, view: View) -> None:
    camera.SetFocalPoint(*view.center, 0.0)
    camera.SetPosition(*view.center, 10.0)
    camera.SetViewUp(0.0, 1.0, 0.0)
    camera.ParallelProjectionOn()
    camera.SetParallelScale(view.half_height)
    camera.SetClippingRange(1.0, 20.0)
