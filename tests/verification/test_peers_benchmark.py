"""Verify measures of benchmarks/peers.py, and its table."""

import math
import os
import stat

import numpy as np
import process
import pytest
from comparison import entries, picture, processes, rigid_body, table
from comparison.processes import NotMeasuredError, Turn
from other_codes import jobs
from other_codes.plate import Plate, Reading
from plates import DISTORTION, make_model, row_by_row, same_plate

ELEMENTS = (6, 3)
PLATE = Plate(ELEMENTS, time_step=1e-5, angle=0.01)
NONE = (0.3831252875, 23.3113534750, -3.2868596947, 0.6573719389, 9.4126003049)
"""Of the paper's start without friction, in the order of QUANTITIES."""


LEFT = Turn(150.0, 0.5, 149.0, None, "1.1")
"""Of a code that would take longer than it was given."""


def reading(plate):
    return Reading(plate, plate.body(), plate.masses())


class SteadyTurn:
    """A code whose plate turns about its corner, which slides, both steadily."""

    version = "1"

    def __init__(self, plate, velocity_lag):
        self.plate, self.velocity_lag, self.made = plate, velocity_lag, 0

    def advance(self, steps):
        self.made += steps

    def state(self):
        return self._at(self.made)[0], self._at(self.made - self.velocity_lag)[1]

    def _at(self, steps):
        time = steps * self.plate.time_step
        turned = Plate(ELEMENTS, 1e-5, angle=self.plate.angle - self.plate.omega * time)
        return turned.nodes() + np.array([self.plate.speed * time, 0.0]), turned.velocities()


@pytest.mark.parametrize("variables", [processes._environment, lambda: process.environment(process.ROOT)])
def test_compiled_sources_are_those_of_this_user_alone(variables):
    status = os.lstat(variables()["PYTHONPYCACHEPREFIX"])
    assert (status.st_uid, stat.S_ISDIR(status.st_mode)) == (os.geteuid(), True)
    assert stat.S_IMODE(status.st_mode) == 0o700


def test_the_rigid_motion_is_the_exact_one():
    motion = rigid_body.of_rectangle(Plate((20, 6), 1e-5, angle=0.26))
    np.testing.assert_allclose(motion, NONE, rtol=1e-10)


def test_row_sums_overstate_the_inertia_by_the_square_of_the_element():
    def shift(elements):
        plate = Plate(elements, 1e-5, angle=0.26)
        return rigid_body.distance(rigid_body.of_row_sums(plate), rigid_body.of_rectangle(plate))

    assert shift((20, 6)) / shift((40, 12)) == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize("lag", [0.0, 0.5, 1.0])
def test_the_tail_slap_is_found_between_steps(lag):
    time = PLATE.angle / PLATE.omega
    values = jobs.event(PLATE, reading(PLATE), SteadyTurn(PLATE, lag), time, limit=60.0)["values"]
    v_g = PLATE.speed - PLATE.omega * PLATE.width / 2, -PLATE.omega * PLATE.length / 2
    np.testing.assert_allclose(values, [time, *v_g, PLATE.omega, PLATE.speed * time], rtol=1e-9)


def test_a_loop_that_takes_too_long_is_left_and_reckoned(monkeypatch):
    monkeypatch.setattr(jobs, "PROBE_S", 0.0)
    event = jobs.event(PLATE, reading(PLATE), SteadyTurn(PLATE, 0.0), expected=1e3, limit=0.0)
    assert event["values"] is None
    assert event["loop_s"] == pytest.approx(event["ran_s"] * 1e3 / PLATE.time_step / jobs.FIRST_STEPS)


@pytest.mark.parametrize("distortion", [0.0, DISTORTION])
def test_the_other_codes_have_our_mesh_and_masses(distortion, tmp_path):
    plate = same_plate(ELEMENTS, distortion, 1e-5, tmp_path)
    ours = make_model(ELEMENTS, distortion, bare=True)
    body = np.vstack([ours.discretisation.positions, ours.parameters.mass]).T
    theirs = np.column_stack([plate.body(), plate.masses()])
    for nodes in (body, theirs):
        nodes[:] = nodes[np.lexsort(nodes.T.round(9))]
    np.testing.assert_allclose(theirs, body, rtol=1e-9, atol=1e-12)
    shift = np.abs(row_by_row(ELEMENTS, DISTORTION) - Plate(ELEMENTS, 1e-5).body()).max(axis=0)
    assert (shift <= DISTORTION * np.array([10.0, 2.438]) / ELEMENTS).all()


def row(mesh, code, measure):
    entry = entries.Entry(code, mesh, mesh.exact, measure)
    entry.turn()
    return entry


def no_code():
    raise NotMeasuredError("not installed")


def rows():
    exact, lumped = (make(PLATE) for make in (rigid_body.of_rectangle, rigid_body.of_row_sums))
    mesh = entries.Mesh(PLATE, 0.0, exact, lumped)
    turns = [Turn(2.0, 0.5, 0.25, tuple(lumped * (1.0 + share)), "1.0") for share in (1e-3, 1e-3 + 1e-9)]
    makers = {entries.ALIKE: lambda: turns[0], "Akantu": lambda: turns[1]}
    makers |= {"Kratos": lambda: LEFT, "Warp loop": no_code}
    return [row(mesh, code, measure) for code, measure in makers.items()]


def test_the_error_is_parted_and_the_codes_are_held_against_each_other():
    ours, akantu, kratos, _ = rows()
    assert ours.by_flexibility == pytest.approx(1e-3)
    assert ours.by_masses == rigid_body.distance(ours.mesh.lumped, ours.mesh.exact) if ours.mesh else False
    assert entries.apart(ours, [ours, akantu, kratos]) == pytest.approx(1e-9, rel=1e-2)
    assert math.isnan(entries.apart(kratos, [ours, akantu, kratos]))
    assert ours.median("rest") == 1.25


def test_the_table_says_what_was_not_measured_and_what_is_reckoned():
    times = "whole time of tailslap run, as the others over that of: Akantu 1, Kratos about 0.013"
    apart = "tailslap run, as the others, Akantu: at most 1.0e-09 apart"
    text = table.markdown(rows(), "head")
    for words in ("not measured: not installed", "about 150", apart, times):
        assert words in text


def test_the_values_stand_below_the_exact_ones():
    lines = rows()
    first, *rest = table.values_rows(lines)
    assert first == ("exact", *(f"{value:.10g}" for value in lines[0].exact))
    assert [row[0] for row in rest] == [entries.ALIKE, "Akantu"]
    assert " | ".join(rest[1]) in table.markdown(lines, "head")


def test_the_picture_has_a_line_for_each_code_that_ended_and_a_dashed_one_for_reckoned_times():
    plate = Plate(ELEMENTS, 1e-5, angle=entries.ANGLE)
    mesh = entries.Mesh(plate, 0.0, np.array(NONE), np.array(NONE))
    turn = Turn(2.0, 0.5, 0.25, tuple(1.001 * np.array(NONE)), "1.0")
    makers = {"Akantu": lambda: turn, "Kratos": lambda: LEFT, "Warp loop": no_code}
    lines = [row(mesh, code, measure) for code, measure in makers.items()]
    drawn = picture.draw(lines).svg
    labels = 'data-label="Akantu"', 'data-label="Kratos"', "Warp"
    assert [label in drawn for label in labels] == [True, True, False]
    assert drawn.count('stroke-dasharray="4 3"') == 2
    reckoned = picture.points(lines, is_distorted=False)[1]
    assert reckoned._replace(error=0.0) == picture.Point("Kratos", PLATE.count, 150.0, 0.0, True)
    assert reckoned.error == pytest.approx(1e-3)
