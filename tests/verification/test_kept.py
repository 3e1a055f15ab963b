"""Verify that common parts of a sweep's rows are computed once."""

import numpy as np
import pytest

from fem import cache
from fem.explicit.columns import COLUMNS, HistoryColumn
from fem.run.corner import Stepper, simulate
from fem.start.inertia_relief import RigidStart
from tailslap.campaign.sweep_table import CIRCUMSTANCES, compute_row
from tailslap.scene.read import read_scene

SMALL = ("plate.elements=[6, 2]",)
START = RigidStart(0.26, 0.707, 25.053)


def row(*changes, scene="paper-table-3"):
    _, source = read_scene(scene, SMALL)
    values = compute_row(0, source, dict(changes))
    assert values["status"] in ("passed", "failed"), values
    return values


def demand_equal(after_another, compute):
    """Require the row that is computed alone."""
    cache.clear()
    alone = compute()
    for name in alone.keys() - set(CIRCUMSTANCES):
        assert alone[name] == after_another[name], name


ALL = {"_mesh", "_assembled", "_unit_spectrum", "_unit_modes"}
SHARED = [
    ("plate.youngs_modulus", (1e11, 3e11), ALL | {"_solved_motion"}), ("corner.friction", (0.3, 0.4), ALL),
    ("start.omega", (0.6, 0.7), ALL), ("plate.elements", ([6, 2], [7, 2]), set()),
]  # fmt: skip


@pytest.mark.parametrize(("key", "values", "shared"), SHARED)
def test_rows_share_what_they_have_in_common_and_are_the_same_alone(key, values, shared):
    cache.clear()
    row((key, values[0]))
    computed = {name: part.cache_info().misses for name, part in cache.CACHES.items()}
    after_another = row((key, values[1]))
    assert {
        name for name in ALL | shared if cache.CACHES[name].cache_info().misses == computed[name]
    } == shared
    demand_equal(after_another, lambda: row((key, values[1])))


@pytest.mark.parametrize(("key", "values", "is_shared"), [
    ("plate.youngs_modulus", (1e11, 3e11), True), ("contact.friction", (0.3, 0.4), False),
    ("vehicle.mass", (9e3, 1e4), False), ("time.end", (0.3, 0.34), False),
])  # fmt: skip
def test_plates_of_one_vehicle_share_its_rigid_impact(key, values, is_shared):
    def impact_row(value):
        return row(*{"time.end": 0.35, key: value}.items(), scene="impact-mash-tl4-sut")

    cache.clear()
    impact_row(values[0])
    uses = cache.CACHES["_solved"].cache_info().hits
    after_another = impact_row(values[1])
    assert (cache.CACHES["_solved"].cache_info().hits > uses) == is_shared
    demand_equal(after_another, lambda: impact_row(values[1]))


def test_large_parts_and_many_parts_are_let_go():
    calls = []

    @cache.cached
    def double(n):
        calls.append(n)
        return 2 * n

    assert ([double(1), double(1), double.__wrapped__(1)], calls) == ([2, 2, 2], [1, 1])
    for n in range(2, cache.SIZE + 2):
        double(n)
    double(1)
    assert calls == [1, 1, *range(2, cache.SIZE + 2), 1]
    cache.CACHES.pop("double")


def test_rows_of_compiled_code_are_those_of_single_steps(plate_model):
    """Rows recorded together equal those of single steps in Python."""
    model = plate_model(reaction="drag", elements=(6, 2))
    plain = simulate(model, START, 0.384)
    COLUMNS.register(HistoryColumn("twice_theta", "rad", lambda measures, state, model: 2.0 * measures.theta))
    try:
        single = simulate(model, START, 0.384)
    finally:
        COLUMNS.pop("twice_theta")
    np.testing.assert_array_equal(single.history["twice_theta"][:-1], 2.0 * single.history["theta"][:-1])
    assert single.steps == plain.steps
    for name, column in plain.history.items():
        scale = max(1e-300, np.abs(column).max())
        np.testing.assert_allclose(single.history[name], column, rtol=0.0, atol=1e-9 * scale, err_msg=name)


def test_recording_ends_at_the_wall_with_the_state_before(plate_model):
    model = plate_model(elements=(6, 2))
    stepper = Stepper(model)
    state = stepper.start(START, "unstressed")
    stride = round(0.05 / model.parameters.time_step)
    recorded = stepper.record(state, stride, 100)
    assert len(recorded.rows) < 15
    assert recorded.rows[-1][0] <= 0.0 < recorded.rows[-2][0]
    assert stepper.measure(recorded.before).theta == pytest.approx(recorded.rows[-2][0], rel=1e-12)
    assert stepper.measure(recorded.state).theta == pytest.approx(recorded.rows[-1][0], rel=1e-12)
    assert stepper.measure(state).theta == pytest.approx(START.angle, rel=1e-12)
