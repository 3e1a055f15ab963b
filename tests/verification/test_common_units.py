"""Verification: units of the program's own table are Pint's, and no other library is loaded for them."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tailslap.scene.common_units import COMMON, to_si
from tailslap.scene.unit_grammar import Factor
from tailslap.scene.units import _converted_by_pint, converted, registry

pytestmark = pytest.mark.verification


@pytest.mark.parametrize("name", COMMON)
def test_own_factors_are_pints(name: str) -> None:
    roots = registry().get_root_units(name)
    scale, dimension = COMMON[name]
    powers = [roots[1].dimensionality.get(f"[{what}]", 0) for what in ("length", "mass", "time")]
    angle = {"rad": 1, "deg": 1}.get(name, 0)
    assert [*powers, angle] == list(dimension)
    assert scale * 1e3**dimension.mass == pytest.approx(float(roots[0]), rel=1e-15)


@pytest.mark.parametrize(
    ("given", "unit"),
    [
        *(("ft", "m"), ("lb", "kg"), ("deg", "rad"), ("km/h", "m/s"), ("ft/s", "m/s"), ("lbf/ft^2", "Pa")),
        *(("lb/ft^3", "kg/m^3"), ("kN/mm", "N/m"), ("MPa", "N/m^2"), ("t m^2", "kg m^2"), ("kHz", "1/s")),
    ],
)
def test_products_are_pints(given: str, unit: str) -> None:
    assert converted(12.34, given, unit) == pytest.approx(_converted_by_pint(12.34, given, unit), rel=2e-15)


@pytest.mark.parametrize(
    ("given", "unit"), [("kg", "m"), ("Hz", "rad/s"), ("1/s", "rad/s"), ("deg", "m/m"), ("s", "1/s")]
)
def test_another_dimension_is_refused_as_pint_refuses_it(given: str, unit: str) -> None:
    for conversion in (converted, _converted_by_pint):
        with pytest.raises(ValueError, match="another dimension"):
            conversion(1.0, given, unit)


def test_other_units_are_left_to_pint() -> None:
    assert to_si([Factor("furlong", 1)]) is None
    assert converted(1.0, "furlong/fortnight", "m/s") == pytest.approx(1.663e-4, rel=1e-3)


@pytest.mark.parametrize("scene", ["mash-tl4-sut", "mash-tl1-car", "impact-mash-tl3-pickup"])
def test_shipped_scenes_load_no_library_of_units(scene: str) -> None:
    code = (
        "import sys; from tailslap.scene.files import read_scene\n"
        f"read_scene({scene!r}, ('vehicle.length=32.5 ft', 'impact.speed=90 km/h')); sys.exit('pint' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
