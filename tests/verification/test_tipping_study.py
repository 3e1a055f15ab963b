"""Verification: the study of tipping: its map, line and samples are those of the solver, and its refusals."""

from dataclasses import replace

import numpy as np
import pytest

from solver import tipping
from tailslap.case.impact import rigid
from tailslap.case.impact.case import ImpactCase
from tailslap.errors import InputError
from tailslap.scene.read import read_scene
from tailslap.studies import find_study
from tailslap.studies.tipping import tipping_report, tipping_study

SCENE = "impact-tipping-tl4-sut"
FIXED = ("vehicle.mass", "vehicle.centre_of_mass", "contact.friction", "impact.speed", "impact.angle")


def case(*changes):
    return ImpactCase(*read_scene(SCENE, changes))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    place = tmp_path_factory.mktemp("study") / "out"
    return tipping_study.compute(case(), place, 128, ("contact.restitution=0.1:0.4",), FIXED, 1)


def test_the_map_and_the_line_are_the_solver_s(found):
    force, interval = found.case.answer.history["force_normal"][1:], found.case.answer.interval
    for i, j in ((0, 0), (10, 20), (49, 49), (15, 30)):
        vehicle = replace(found.answer.vehicle, centre_height=found.centres[j])
        assert found.rolls[i, j] == tipping.largest_rolls(vehicle, found.walls[i], force, interval)
    tips = found.rolls == tipping.TIPPED
    assert (tips == (found.walls[:, None] < found.line)).mean() > 0.99
    assert (np.diff(found.line) > 0.0).all()
    own = np.interp(1.35, found.centres, found.line)
    assert own == pytest.approx(found.answer.lowest_wall, abs=2e-3)


def test_samples_are_impacts_of_their_own(found):
    """Lowest walls of samples beside the same scenes, each solved for itself."""
    for number in (0, 5, 11):
        changes = [
            f"{key}={float(values[number])!r}" for key, values in found.samples.items() if key in found.inputs
        ]
        own = rigid.tipping_of(varied := case(*map(str.strip, changes)), varied.answer)
        assert found.samples["lowest_safe_wall"][number] == pytest.approx(own.lowest_wall, abs=0.012)


def test_lowest_walls_of_the_samples_lie_within_2_mm_of_those_of_small_steps():
    """95 in 100 of them, with low restitution as with high; beside steps of 0.1 ms and smaller ones of the roll."""
    own, draw = case(), np.random.default_rng(5)
    for low, high in ((0.0, tipping_study.ABRUPT), (tipping_study.ABRUPT, 0.4)):
        ranges = {
            "contact.restitution": (low, high), "contact.stiffness": (1e6, 3e6),
            "tipping.centre_height": (1.25, 1.45), "impact.angle": (0.24, 0.29),
        }  # fmt: skip
        inputs = {key: draw.uniform(*ends, 100) for key, ends in ranges.items()}
        found = own.impacts(
            {key: values for key, values in inputs.items() if "tipping" not in key},
            after_second=rigid.AFTER_TIPPING, interval=tipping_study.STEP, step=1e-4,
        )  # fmt: skip
        vehicle = rigid.tipping_of(own, own.answer).vehicle
        exact = [
            float(tipping.lowest_walls(replace(vehicle, centre_height=centre), force, tipping_study.STEP))
            for centre, force in zip(inputs["tipping.centre_height"], found.mean_force.T, strict=True)
        ]
        off = np.abs(np.array(tipping_study.measure(own.source, inputs)["lowest"]) - exact)
        assert np.percentile(off, 95) < 2e-3


def test_the_band_holds_the_line_and_the_centre_s_height_counts_most(found):
    low, middle, high = found.band
    assert (low < middle).all()
    assert (middle < high).all()
    first = max(found.sources, key=lambda row: row["total"])
    assert first["key"] == "tipping.centre_height"
    assert found.holds(0.0) == 0.0
    assert found.holds(2.0) == 1.0
    assert found.holds(0.69) < found.holds(0.81) < 1.0


def test_the_report(found):
    made = tipping_report.report(found)
    text = str(made.page)
    for words in ("Lowest wall without rollover", "shift of the cargo", "No rollover"):
        assert words in text
    assert np.size(made.histories["map.csv"]["largest_roll"]) == 2500
    held = [row["holds"] for row in made.summary["walls"]]
    assert held == sorted(held)
    assert made.summary["tipping"]["lowest_safe_wall"] == found.answer.lowest_wall


def test_refused_indices_are_said_and_not_shown(found):
    made = tipping_report.report(replace(found, sources=[], refusal="Sobol indices are not determined."))
    assert "main source of variance" not in made.page.headline.certainty
    assert "Sobol indices are not determined." in made.terminal
    assert made.summary["indices_refused"] == "Sobol indices are not determined."
    assert not any("total" in row for row in made.summary["inputs"])
    assert "Sobol indices are not determined." in str(made.page)
    assert tipping_report.report(found).summary["indices_refused"] is None


@pytest.mark.parametrize(("changes", "key"), [
    (("tipping=",), "tipping"), (("contact.side_stiffness=1 MN/m^2",), "contact.side_stiffness"),
])  # fmt: skip
def test_refusals(changes, key, tmp_path):
    with pytest.raises(InputError) as caught:
        tipping_study.compute(case(*changes), tmp_path / "out", 128, (), (), 1)
    assert caught.value.key == key


def test_it_is_a_study():
    assert find_study("tipping").name == "tipping"
