"""Error against run time of whole impacts: what it is measured from, by hand and in a short study."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from tailslap.command_line import main
from tailslap.scene.schema import Plate
from tailslap.studies.cost.impacts import NAMES, QUAD9, _values, impact_settings
from tailslap.studies.cost.limits import Limit, limit_of
from tailslap.studies.cost.points import point_of
from tailslap.studies.cost.settings import FE, Setting

pytestmark = pytest.mark.verification


def record(value: float) -> dict[str, Any]:
    return {
        "values": dict.fromkeys(NAMES, value),
        "setup": [0.2, 0.1],
        "loop": [0.5, 0.3, 0.4],
        "steps": 9,
        "failed": [],
    }


def test_errors_are_from_the_limit_of_the_quadratic_elements() -> None:
    """Changes of 4 and 1 per thousand: order 2, limit 1 - 1/3000, known to 1.25/3000."""
    limit = limit_of([record(1.005), record(1.001), record(1.0)], NAMES)
    assert limit.values == {name: pytest.approx(1.0 - 1e-3 / 3.0, rel=1e-12) for name in NAMES}
    assert limit.known == pytest.approx(1.25e-3 / 3.0, rel=1e-9)
    point = point_of(Setting(FE, "quad4", "mesh"), record(1.02), limit)
    assert point.error == pytest.approx(1.02 / (1.0 - 1e-3 / 3.0) - 1.0)
    assert (point.setup_s, point.loop_s, point.median_s, point.steps) == (0.1, 0.3, 0.4, 9)


def test_no_error_is_below_what_the_limit_is_known_to_and_none_is_told_without_strikes() -> None:
    limit = Limit(dict.fromkeys(NAMES, 1.0), 1e-3)
    assert point_of(Setting(FE, "quad4", "mesh"), record(1.0 + 1e-5), limit).error == 1e-3
    nothing = point_of(Setting(FE, "quad4", "mesh"), record(math.nan), limit)
    assert math.isnan(nothing.error)
    assert not nothing.valid
    assert all(map(math.isnan, _values([]).values()))
    assert not point_of(Setting(FE, "quad4", "mesh"), {"refused": "no"}, limit).valid


def test_the_limit_s_meshes_are_halves_of_each_other() -> None:
    plate = Plate(thickness=0.05, youngs_modulus=2e11, poissons_ratio=0.3, elements=(20, 6))
    meshes = [s.changes["plate.elements"] for s in impact_settings(plate) if s.group == QUAD9]
    assert meshes == [(10, 3), (20, 6), (40, 12)]


@pytest.mark.long
def test_a_study_on_a_coarse_plate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every setting comes nearer to the plate's limit than the rigid vehicle, and finer meshes nearer still."""
    out = tmp_path / "cost"
    arguments = ["study", "cost", "impact-mash-tl4-sut", "--set", "plate.elements=[8, 4]", "--out", str(out)]
    with pytest.raises(SystemExit) as ended:
        main([*arguments, "--set", "plate.first_frequency=20 Hz", "--set", "plate.youngs_modulus="])
    assert ended.value.code == 0
    assert "cheapest setting" in capsys.readouterr().out
    found = json.loads((out / "summary.json").read_text())
    error = {point["setting"]: point["error"] for point in found["points"]}
    rigid = error.pop("rigid vehicle: event-driven")
    assert rigid > 0.02
    assert max(error.values()) < rigid
    assert error["quad9: 16 x 8"] <= error["quad9: 8 x 4"] <= error["quad9: 4 x 2"]
    assert error["quad4: 16 x 8"] < 0.4 * error["quad4: 8 x 4"]
    assert found["known"] < 0.02
