"""Verify plates that are given by their first frequency."""

import dataclasses
import json
import math

import numpy as np
import pytest
import scipy.linalg

from tailslap import cli, errors
from tailslap.case.corner.corner_case import CornerCase
from tailslap.scene.read import read_scene
from tailslap.scene.validate import validate
from tailslap.scene.write import resolved_inputs

EIGHT = ("plate.youngs_modulus=", "plate.first_frequency=8 Hz")


def dense_frequencies(model):
    """All frequencies of the free plate [Hz], by LAPACK."""
    masses = np.tile(model.parameters.mass, 2)
    squares = scipy.linalg.eigvalsh(model.stiffness.toarray() / np.sqrt(np.outer(masses, masses)))
    return np.sqrt(np.abs(squares)) / (2.0 * math.pi)


@pytest.mark.parametrize("change", [
    (), ("plate.element=quad4-reduced",), ("plate.element=tri3", "plate.elements=[10, 3]"),
    ("plate.lumping=row-sum", "plate.distortion=0.2"),
    ("plate.thickness=2 mm", "plate.density=", "plate.poissons_ratio=0.45"),
])  # fmt: skip
def test_the_model_has_it(change):
    fe_plan = CornerCase(*read_scene("paper-table-3", (*EIGHT, *change))).plan()
    frequencies = dense_frequencies(fe_plan.model)
    assert frequencies[:3].max() < 1e-4
    assert frequencies[3] == pytest.approx(8.0, rel=1e-10)


@pytest.mark.parametrize(
    ("text", "hertz"), [("8 Hz", 8.0), ("0.02 kHz", 20.0), ("12.5", 12.5), ("3 1/s", 3.0)]
)
def test_units(text, hertz):
    scene = read_scene("paper-table-3", ("plate.youngs_modulus=", f"plate.first_frequency={text}"))[0]
    assert scene.needed_plate.first_frequency == pytest.approx(hertz, rel=1e-15)


@pytest.mark.parametrize("text", ["8 rad/s", "480 rpm", "8 deg/s", "0 Hz", "-8 Hz", "8 s", "8 GPa"])
def test_radians_are_no_cycles(text, refused):
    changes = ("plate.youngs_modulus=", f"plate.first_frequency={text}")
    assert refused(read_scene, "paper-table-3", changes) == "plate.first_frequency"


@pytest.mark.parametrize("text", ["0.7 Hz", "0.7 1/s", "0.7 m/s"])
def test_cycles_are_no_radians(text, refused):
    assert refused(read_scene, "paper-table-3", (f"start.omega={text}",)) == "start.omega"


def test_exactly_one_of_the_two():
    with pytest.raises(errors.InputError, match=r"plate\.youngs_modulus") as caught:
        read_scene("paper-table-3", ("plate.first_frequency=8 Hz",))
    assert caught.value.key == "plate.first_frequency"
    with pytest.raises(errors.InputError, match=r"plate\.first_frequency") as caught:
        read_scene("paper-table-3", ("plate.youngs_modulus=",))
    assert caught.value.key == "plate.youngs_modulus"


def test_nothing_to_take_out(refused):
    assert refused(read_scene, "paper-table-3", ("plate.first_frequency=",)) == "--set"


def test_same_run_as_with_the_modulus(outcome):
    by_frequency = outcome("paper-table-3", *EIGHT)
    modulus = by_frequency.fe_plan.plate.youngs_modulus
    assert 0.9e9 < modulus < 1.3e9
    by_modulus = outcome("paper-table-3", f"plate.youngs_modulus={modulus!r}")
    for name, column in by_modulus.fe_history.items():
        scale = np.abs(column).max()
        assert np.abs(by_frequency.fe_history[name] - column).max() <= 1e-12 * scale, name
    assert by_modulus.fe_plan.first_frequency == pytest.approx(8.0, rel=1e-10)


def test_reports_say_what_was_resolved(tmp_path, capsys):
    changes = [item for change in (*EIGHT, "plate.element=quad4") for item in ("--set", change)]
    out = tmp_path / "result"
    assert cli._status(["run", "paper-table-3", "--out", str(out), "--no-pictures", *changes]) == cli.DONE
    plate = json.loads((out / "summary.json").read_text())["plate"]
    assert plate["first_frequency"] == 8.0
    assert plate["youngs_modulus"] == pytest.approx(1.098424e9, rel=1e-6)  # regression
    page = (out / "report.html").read_text()
    assert "from plate.first_frequency" in page
    capsys.readouterr()
    assert cli._status(["check", "paper-table-3", *changes]) == cli.DONE
    said = " ".join(capsys.readouterr().out.split())  # folded to the terminal's width
    assert "first frequency of the free plate in its plane 8 Hz" in said


def test_inputs_of_a_scene_with_its_modulus_are_as_before():
    plan = CornerCase(*read_scene("paper-table-3"))
    rows = {row.key: row for row in resolved_inputs(plan.scene, plan.source, plan.scene.needed_plate)}
    assert rows["plate.youngs_modulus"].origin == "scene"
    assert "plate.first_frequency" not in rows


def test_too_stiff_names_the_key(refused):
    plan = CornerCase(*read_scene("paper-table-3", ("plate.youngs_modulus=", "plate.first_frequency=1e9")))
    assert refused(plan.plan) == "plate.first_frequency"


def test_rigid_method_needs_no_modulus_to_be_resolved():
    scene, source = read_scene("paper-table-3", EIGHT)
    assert dataclasses.is_dataclass(CornerCase(scene, source))
    assert validate(source.tables) == scene
