"""Verification: scenes, changes and command lines made at random end with 0, 1 or 2, one message, in bounded time.

Scenes are made by their structure: shipped ones with keys at the ends of what is allowed, just beyond, or of another
kind.
`benchmarks/fuzz.py` is the long job of the same inputs.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import signal
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tailslap.cli import _status
from tailslap.scene import read, schema, units

MAX_S = 10.0
"""Seconds of processor time that reading an input may take: a guard, whatever else the machine does."""

SCENES = ("mash-tl4-sut", "paper-table-3", "mash-tl1-car", "impact-mash-tl4-sut")
ODD = (
    *(
        "",
        "nan",
        "-inf",
        "true",
        "[]",
        "{}",
        '""',
        "'x'",
        "1979-05-27",
        "0x10",
        "1_000",
        "-0.0",
        "1e400",
        "9" * 400,
    ),
    *(
        "7 m",
        "7 m m",
        "7 m**9",
        "7 1/s",
        "5 %",
        "3 degC",
        "2 dB",
        "7 m/0",
        "7 kg m^2 s^-2",
        "a\\nb",
        "\\x1b[2J",
    ),
    *(
        "\u0661",
        "\uff11 m",
        "1,2",
        "1:2:3",
        "log:1:2:3",
        "[[[[]]]]",
        "[1, 1]",
        "[400, 1]",
        "drag",
        "exact",
        "=",
        "#",
    ),
)


def numbers(model: Any, prefix: str = "") -> Iterator[tuple[str, units.Quantity | None]]:
    """Dotted keys of a scene, with the marks of those that are numbers."""
    for name, field in model.model_fields.items():
        kinds = (field.annotation, *getattr(field.annotation, "__args__", ()))
        marks = [*field.metadata, *(mark for kind in kinds for mark in getattr(kind, "__metadata__", ()))]
        inner = [kind for kind in kinds if hasattr(kind, "model_fields")]
        yield prefix + name, next((mark for mark in marks if isinstance(mark, units.Quantity)), None)
        for kind in inner:
            yield from numbers(kind, f"{prefix}{name}.")


KEYS = dict(numbers(schema.Scene))


def around(bound: float) -> list[float]:
    return [
        bound,
        math.nextafter(bound, math.inf),
        math.nextafter(bound, -math.inf),
        1.5 * bound,
        0.5 * bound,
    ]


def ends(mark: units.Quantity) -> st.SearchStrategy[str]:
    """Values at the ends of what is allowed, beside them, and anywhere between."""
    low, high = mark.least, min(mark.most, mark.below)
    between = st.floats(math.log(low), math.log(high)).map(math.exp) if low > 0.0 else st.floats(low, high)
    numbers = st.one_of(between, st.sampled_from([*around(low), *around(high), 0.0, -1.0]))
    return numbers.map(lambda value: f"{value!r}" if math.isfinite(value) else "1e999")


def values(key: str) -> st.SearchStrategy[str]:
    odd = st.one_of(st.sampled_from(ODD), st.text(max_size=20), st.floats().map(repr), st.integers().map(str))
    mark = KEYS.get(key)
    return odd if mark is None else st.one_of(ends(mark), ends(mark), ends(mark), odd)


@st.composite
def changes(draw: Any) -> list[str]:
    """A few --set options."""
    keys = draw(st.lists(st.one_of(st.sampled_from(sorted(KEYS)), st.text(max_size=8)), max_size=4))
    return [part for key in keys for part in ("--set", f"{key}={draw(values(key))}")]


@st.composite
def command_lines(draw: Any) -> list[str]:
    """`rigid` of a scene with changes, a spread over ranges, a sweep that is not begun, or just words."""
    scene = draw(st.sampled_from((*SCENES[:3], *SCENES)))
    kind = draw(st.sampled_from(("rigid", "rigid", "json", "vary", "range", "any")))
    if kind == "any":
        options = ("rigid", "scenes", "--json", "--out", "--help", "--set", scene)
        words = st.one_of(st.sampled_from(options), st.text(max_size=9))
        return list(draw(st.lists(words, max_size=4)))
    key = draw(st.sampled_from(sorted(KEYS)))
    span = ":".join(draw(st.lists(values(key), min_size=1, max_size=3)))
    if kind == "vary":  # what is no number of runs comes last, so that no sweep ever begins
        return ["sweep", scene, "--vary", f"{key}={span}", *draw(changes()), "--workers", "0"]
    if kind == "range":
        return ["study", "uncertainty", scene, "--range", f"{key}={span}", "--samples", "0", *draw(changes())]
    return ["rigid", scene, *draw(changes()), *(["--json"] if kind == "json" else [])]


class TooLong(BaseException):
    """What ends a command that would not end; the program catches no such thing."""


@contextlib.contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise TooLong after so much processor time."""

    def end(*_: object) -> None:
        raise TooLong

    before = signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def outcome(arguments: list[str]) -> tuple[int, str, str]:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = _status(arguments)
    return status, out.getvalue(), err.getvalue()


def demand_good_end(arguments: list[str]) -> None:
    try:
        with limited(MAX_S):
            status, out, err = outcome(arguments)
    except TooLong:
        raise AssertionError(f"over {MAX_S} s of processor time: {arguments}") from None
    assert status in (0, 1, 2), (arguments, err)
    assert "fault of the program" not in err
    assert "Traceback" not in err
    said = [line for line in err.splitlines() if not line.startswith("tailslap: remark: ")]
    assert (status == 2) == bool(said), (arguments, err)
    assert len(err) < 2000
    assert [letter for letter in err if not (letter.isprintable() or letter == "\n")] == []
    if status != 2 and "--json" in arguments and arguments[0] == "rigid" and "--help" not in arguments:
        json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} in JSON of {arguments}"))
    assert not {"nan", "inf"} & set(out.split()), (arguments, out)


fuzz = settings(deadline=None, derandomize=True, suppress_health_check=list(HealthCheck), database=None)


@settings(fuzz, max_examples=250)
@given(command_lines())
def test_command_lines(arguments):
    demand_good_end(arguments)


FOUND = (
    "contact.side_stiffness=5e14",
    "vehicle.yaw_inertia=1",
    "impact.speed=1e-06",
    "time.end=0.049787068367863944",
    "time.end=0.05",
    "time.end=100.0",
    "contact.initial_force=393923533635.0",
    "impact.angle=1.5707963267948963",
    "impact.angle=45deg impact.speed=50 contact.friction=0 contact.restitution=0.9 contact.stiffness=1e10"
    " vehicle.length=4 vehicle.width=2 vehicle.mass=1500",
)
"""Changes of impact-mash-tl4-sut that the long job has found, and what was found beside them."""


@pytest.mark.parametrize("changed", FOUND)
def test_impacts_that_once_ended_badly(changed):
    demand_good_end(
        ["rigid", "impact-mash-tl4-sut", *(part for word in changed.split() for part in ("--set", word))]
    )


@pytest.mark.long
@settings(fuzz, max_examples=2000)
@given(command_lines())
def test_many_command_lines(arguments):
    demand_good_end(arguments)


@pytest.mark.long
@pytest.mark.parametrize("scene", SCENES)
def test_all_numbers_at_either_end(scene):
    """Each number alone at its bounds: what passes validation ends finite."""
    for key, mark in KEYS.items():
        for value in (mark.least, mark.most) if mark else ():
            demand_good_end(["rigid", scene, "--json", "--set", f"{key}={value!r}"])


def test_the_keys_are_those_of_the_scenes():
    assert {
        "vehicle.length",
        "plate.thickness",
        "corner.friction",
        "contact.stiffness",
        "time.end",
    } <= KEYS.keys()
    assert set(SCENES) <= read.shipped_scenes().keys()
