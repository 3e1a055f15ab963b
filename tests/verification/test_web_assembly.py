"""Verify kernels compiled to WebAssembly against those of this machine."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
import wasmtime
from web_module import Module

from machine_code import web_assembly
from machine_code.compiled import compiled
from solver.impact import trajectories
from tailslap.browser import space_model
from tailslap.case.of_arguments import case_of_scene


class Pair(NamedTuple):
    first: np.ndarray
    number: int


@compiled
def both(x):
    """Return two numbers, which WebAssembly returns on its stack."""
    return math.hypot(x, 1.0), int(x)


@compiled
def mixture(pair, table, flag, scale):
    """Use each type of number, filled memory and functions of mathematics."""
    table[:] = 0.0
    total, last = 0.0, 0
    for k in range(pair.number):
        distance, last = both(pair.first[k])
        if flag:
            total += scale * distance + math.atan2(pair.first[k], 2.0) + math.tanh(total) + math.sin(total)
        table[k, 1] = total
    return total, last, flag, int(math.inf)


def test_each_type_of_argument_and_result():
    arguments = Pair(np.arange(5.0), 4), np.ones((5, 3)), True, 0.25
    module = Module({"mixture": (mixture, arguments)})
    native = mixture(*arguments)
    numbers = module.call("mixture", 4)
    integers = numbers.view(np.int64)
    assert numbers[0] == pytest.approx(native[0], rel=1e-14)
    assert (*integers[1:3], integers[3]) == (3, 1, 2**63 - 1) == (native[1], native[2], native[3])
    np.testing.assert_allclose(module["mixture.table"], arguments[1], rtol=1e-14)


def test_kernels_of_a_module_share_arrays_and_have_a_digest():
    values, table = Pair(np.arange(4.0), 4), np.zeros((4, 3))
    calls = {"one": (mixture, (values, table, True, 1.0)), "two": (mixture, (values, table, False, 1.0))}
    module = Module(calls)
    module.call("one")
    assert module["one.table"].any()
    module.call("two")
    assert not module["one.table"].any()
    digest = web_assembly.digest_of(calls)
    assert digest.encode() in web_assembly.module(calls)
    assert digest != web_assembly.digest_of({"one": calls["one"]})
    assert {item.name for item in module.module.exports} == {"one", "two"}
    wasmtime.Module.validate(wasmtime.Engine(), web_assembly.module(calls))


def test_a_planar_impact(monkeypatch):
    """Rows are those of this machine.

    The tolerance is 1e-9 of the largest value of each column.
    """
    runs, compile_once = [], trajectories.compile_once

    def also(compile_all, kernel, *arguments, on_compile):
        rows = arguments[6].rows
        rows[:] = 0.0
        runs.append((Module({"solve": (kernel, arguments)}), rows))
        compile_once(compile_all, kernel, *arguments, on_compile=on_compile)

    monkeypatch.setattr(trajectories, "compile_once", also)
    case: Any = case_of_scene("impact-mash-tl4-sut", {"time.end": 0.1})
    motion = case.motion
    module, rows = runs[0]
    module.call("solve")
    scale = np.abs(rows[0, : len(motion.rows)]).max(axis=0)
    np.testing.assert_array_equal(rows[0, : len(motion.rows)], motion.rows)
    assert len(motion.rows) > 1000
    assert (np.abs(module["solve.outcome.rows"] - rows).max(axis=(0, 1)) <= 1e-9 * scale).all()


@pytest.mark.parametrize("scene", ["impact-tipping-tl4-sut", "impact-97-kip-tractor-van"])
def test_a_motion_in_space(scene):
    """Rows and walls are those of this machine, within 1e-9."""
    case: Any = case_of_scene(scene, None)
    calls: Any = space_model.model_of(case).calls
    module, (_, _, room, curves), walls = Module(calls), calls["space"][1], calls["space_wall"][1][4]
    _, _, count = calls["space"][0](*calls["space"][1])
    assert module.call("space", 3).view(np.int64).tolist() == [0, 0, count]
    rows = curves.rows[0, :count]
    scale = np.abs(rows).max(axis=0)
    assert (np.abs(module["space.curves.rows"][0, :count] - rows).max(axis=0) <= 1e-9 * scale).all()
    np.testing.assert_allclose(module["space.room.answers"], room.answers, rtol=1e-9)
    calls["space_wall"][0](*calls["space_wall"][1])
    module.call("space_wall")
    np.testing.assert_allclose(module["space_wall.walls"][0], walls[0], rtol=1e-9)
    assert count > 700
    assert walls[0, 0] > 0.0
