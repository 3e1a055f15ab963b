"""Fixtures of all tests, as scenes run once and small models."""

import functools
import gc
import os
import re
import signal
import subprocess
import sys
import tempfile
from html.parser import HTMLParser
from typing import Any

import pytest

# As the command line does, before NumPy is loaded: the tests' processes have the cores for themselves.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from shared_cases import case

from fem.laws.friction import Drag, Signed
from fem.model.plate_model import PlateModel, build_model
from fem.plate.kinds import ELEMENT_KINDS
from fem.plate.properties import CornerProperties, PlateProperties, StepProperties
from machine_code.system import folder
from meshes import distorted, plate_mesh
from tailslap.case.impact.space import answer as in_space
from tailslap.errors import InputError
from tailslap.validation import calibration

STEEL = {"thickness": 0.053, "density": 7800.0, "youngs_modulus": 200e9, "poissons_ratio": 0.3}
LAWS = {"drag": Drag(0.47), "none": None, "signed": Signed(0.47)}
FIRST = (
    *("test_result_folder.py", "test_style.py", "test_site.py", "test_site_build.py"),
    *("test_other_solvers.py", "test_eighty_columns.py", "test_impact_run.py", "test_impact_mesh.py"),
    "test_train_run.py",
)
"""Files that are begun first: one that forks its process while it is small, and those that take longest."""

COLLECTION = (100_000, 20, 50)
"""Thresholds of Python's garbage collector, which otherwise takes a tenth of the time of compilation."""


def pytest_configure(config: pytest.Config) -> None:
    """Let commands write compiled sources, and receive SIGINT from background shells.

    To compile the sources takes 0.3 s of the 1.1 s of `tailslap rigid`. Files are distributed in the order of `FIRST`,
    not by their number of tests.
    """
    config.option.loadscopereorder = False
    gc.set_threshold(*COLLECTION)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark a test by its folder."""
    for item in items:
        item.add_marker(item.path.parent.name)
    order = {name: place for place, name in enumerate(FIRST)}
    items.sort(key=lambda item: order.get(item.path.name, len(FIRST)))


@functools.cache
def _outcome(name: str, changes: tuple[str, ...]) -> Any:
    return case(name, *changes).run()


@pytest.fixture(scope="session", autouse=True)
def temporary_folder(tmp_path_factory):
    """Let killed processes leave their files where pytest removes them."""
    place, before = tmp_path_factory.mktemp("t"), tempfile.tempdir
    os.environ["TMPDIR"] = tempfile.tempdir = str(place)
    yield
    del os.environ["TMPDIR"]
    tempfile.tempdir = before


@pytest.fixture(scope="session", autouse=True)
def kept_results():
    """Keep motions in space and bands of forces of a scene.

    Many commands and pages state them.
    """
    bands, compute = dict[Any, Any](), calibration.calibrated_band

    def kept(case):
        key = case.scene, repr(case.source)
        if key not in bands:
            bands[key] = compute(case)
        return bands[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(in_space, "solve", functools.lru_cache(maxsize=32)(in_space.solve))
        patch.setattr(calibration, "calibrated_band", kept)
        yield


@pytest.fixture(scope="session")
def proc():
    """Skip tests that read /proc where it is not mounted."""
    if not os.path.isdir("/proc/self/fd"):
        pytest.skip("/proc is not mounted")


@pytest.fixture
def keeping(tmp_path, monkeypatch):
    """Compiled code is kept in a folder of the test's own."""
    monkeypatch.setattr(folder, "cache_folder", lambda: tmp_path / "code")


@pytest.fixture(scope="session")
def outcome():
    """Run a scene with changes, each combination once a session."""
    return lambda name, *changes: _outcome(name, changes)


@pytest.fixture(scope="session")
def refused():
    """Key of the wrong input that a call ends with."""

    def key(function: Any, *arguments: Any) -> str:
        with pytest.raises(InputError) as caught:
            function(*arguments)
        return caught.value.key

    return key


@pytest.fixture(scope="session")
def python():
    """Run code in another process of Python, with its options.

    settings: of `subprocess.run`.
    """

    def run(code, *options, **settings):
        command = [sys.executable, *options, "-c", code]
        return subprocess.run(command, capture_output=True, text=True, **settings)

    return run


@pytest.fixture(scope="session")
def besides_compiling():
    """Remove messages of compilation, which depend on earlier tests."""
    return lambda said: re.sub(r"tailslap: (compil|waiting).*\n", "", said)


@pytest.fixture(scope="session")
def plate_model():
    """Model of the paper's steel plate, with changes."""

    def build(
        elements: tuple[int, int] = (20, 6), reaction: str = "none", mesh: Any = None,
        plate: dict[str, Any] | None = None, corner: dict[str, Any] | None = None, **step: float,
    ) -> PlateModel:  # fmt: skip
        properties = PlateProperties(**{**STEEL, **(plate or {})})
        cells = ELEMENT_KINDS[properties.element].cells
        mesh = mesh or plate_mesh(10.0, 2.438, elements, cells)
        held = CornerProperties(LAWS[reaction], **(corner or {}))
        return build_model(mesh, properties, held, StepProperties(**step))

    return build


@pytest.fixture
def distorted_mesh():
    """Displace inner nodes of the plate by a fifth of an element."""
    return distorted(plate_mesh(10.0, 2.438, (8, 4)), 0.2, (8, 4))


class Shown(HTMLParser):
    """Words of a page in one system of units.

    Header, set-up, inputs and charts in the other system are omitted.
    """

    def __init__(self, html, system):
        super().__init__()
        self.hidden = {
            "title",
            "header",
            "style",
            "script",
            "pre",
            "template",
            "us" if system == "si" else "si",
        }
        self.open: list[bool] = []
        self.words = ""
        self.feed(
            re.sub(r"<svg[^>]*Set-up from above.*?</figcaption>", "</figcaption>", html, flags=re.DOTALL)
        )

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img", "input", "br"):
            self.open.append(bool({tag, dict(attrs).get("class")} & self.hidden))

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        self.open.pop()

    def handle_data(self, data):
        self.words += "" if any(self.open) else data.replace("\N{NO-BREAK SPACE}", " ")


@pytest.fixture(scope="session")
def words_of():
    """Return a function from a folder to the words of its page.

    Words are those of one system of units.
    """
    return lambda place, system: Shown((place / "report.html").read_text(encoding="utf-8"), system).words
