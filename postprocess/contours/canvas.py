"""Off-screen VTK drawing in one fixed style: flat colours, text placed in pixels, the camera of a `View`."""

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from postprocess.contours.view import View

INK = "#1b1f24"
FONTS = {False: "DejaVuSans.ttf", True: "DejaVuSans-Bold.ttf"}


@contextmanager
def canvas(view: View) -> Iterator[Any]:
    """A plotter that looks straight down on the X-Y plane; closed when the block ends, however it ends."""
    choose_window()
    import pyvista

    theme = pyvista.themes.DocumentTheme()
    plotter = pyvista.Plotter(off_screen=True, window_size=list(view.size), theme=theme, lighting="none")
    try:
        plotter.enable_anti_aliasing("msaa")
        _look_down(plotter.camera, view)
        yield plotter
    finally:
        plotter.close()


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


def surface(points: NDArray[np.float64], quads: NDArray[np.integer[Any]], height: float) -> Any:
    """Mesh of quads (e, 4) on points (n, 2) [m], at the given Z [m]: the higher one hides the lower."""
    import pyvista

    return pyvista.PolyData.from_regular_faces(_lifted(points, height), quads)


def add_line(plotter: Any, points: NDArray[np.float64], colour: str = INK) -> None:
    """A polyline through points (k, 2) [m], two pixels wide."""
    import pyvista

    line = pyvista.lines_from_points(_lifted(points, 0.01))
    plotter.add_mesh(line, color=colour, line_width=2, lighting=False)


def add_disc(plotter: Any, centre: tuple[float, float], radius: float, colour: str, height: float) -> None:
    """A filled disc; centre, radius and Z in m."""
    import pyvista

    disc = pyvista.Disc(center=(*centre, height), inner=0.0, outer=radius, c_res=32)
    plotter.add_mesh(disc, color=colour, lighting=False)


def add_text(
    plotter: Any, text: str, pixel: tuple[float, float], size: int, justify: str = "left", bold: bool = False
) -> Any:
    """The text actor, its baseline starting (left), ending (right) or centred (center) at a pixel."""
    import pyvista

    actor = pyvista.Text(text, position=pixel)
    actor.prop.justification_horizontal = justify
    style_text(actor.prop, size, bold)
    plotter.add_actor(actor, reset_camera=False)
    return actor


def style_text(prop: Any, size: int, bold: bool = False) -> None:
    """Sets ink, size in pixels and a font that has Greek letters and arrows: VTK's own has neither."""
    import matplotlib
    from vtkmodules.vtkCommonCore import VTK_FONT_FILE

    prop.SetFontFamily(VTK_FONT_FILE)
    prop.SetFontFile(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / FONTS[bold]))
    prop.SetFontSize(size)
    prop.SetColor(*(int(INK[i : i + 2], 16) / 255 for i in (1, 3, 5)))
    prop.ItalicOff()
    prop.BoldOff()


def _look_down(camera: Any, view: View) -> None:
    camera.focal_point = (*view.center, 0.0)
    camera.position = (*view.center, 10.0)
    camera.up = (0.0, 1.0, 0.0)
    camera.parallel_projection = True
    camera.parallel_scale = view.half_height
    camera.clipping_range = (1.0, 20.0)


def _lifted(points: NDArray[np.float64], height: float) -> NDArray[np.float64]:
    return np.column_stack([points, np.full(len(points), height)])
