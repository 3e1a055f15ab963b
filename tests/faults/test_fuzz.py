"""Verify that random scenes and command lines end with one message.

The exit status is 0, 1 or 2, in bounded time. Scenes are made by their structure: shipped ones with keys at the ends of
the allowed range, just beyond, or of another kind. `random_command_lines.py` is the long job of the same inputs;
wrong ones end at once with the key, the given and the allowed values, status 2, no files.
"""

import contextlib
import io
import json
import math
import os
import resource
import signal
import time
from pathlib import Path

import click
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from processes import completed

from tailslap.cli import _status, commands
from tailslap.errors import InputError, escaped
from tailslap.options import Folder, Real, Text, Whole
from tailslap.scene import read, schema, units
from tailslap.scene.read import read_scene, source_of_text
from tailslap.scene.units import converted, unit_factors

MAX_S = 10.0
"""Seconds of processor time that reading an input may take: a guard, whatever else the machine does."""

SCENES = ("mash-tl4-sut", "paper-table-3", "mash-tl1-car", "impact-mash-tl4-sut")
ODD = (
    "", "nan", "-inf", "true", "[]", "{}", '""', "'x'", "1979-05-27", "0x10", "1_000", "-0.0", "1e400", "9" * 400,
    "7 m", "7 m m", "7 m**9", "7 1/s", "5 %", "3 degC", "2 dB", "7 m/0", "7 kg m^2 s^-2", "a\\nb", "\\x1b[2J",
    "\u0661", "\uff11 m", "1,2", "1:2:3", "log:1:2:3", "[[[[]]]]", "[1, 1]", "[400, 1]", "drag", "exact", "=", "#",
)  # fmt: skip


def numbers(model, prefix=""):
    """Dotted keys of a scene, with the marks of numbers."""
    for name, field in model.model_fields.items():
        kinds = (field.annotation, *getattr(field.annotation, "__args__", ()))
        marks = [*field.metadata, *(mark for kind in kinds for mark in getattr(kind, "__metadata__", ()))]
        inner = [kind for kind in kinds if hasattr(kind, "model_fields")]
        yield prefix + name, next((mark for mark in marks if isinstance(mark, units.Quantity)), None)
        for kind in inner:
            yield from numbers(kind, f"{prefix}{name}.")


KEYS = dict(numbers(schema.Scene))


def around(bound):
    beside = [math.nextafter(bound, end) for end in (math.inf, -math.inf)]
    return [bound, *beside, 1.5 * bound, 0.5 * bound]


def ends(mark):
    """Values at the allowed ends, beside them, and between."""
    low, high = mark.least, min(mark.most, mark.below)
    between = st.floats(math.log(low), math.log(high)).map(math.exp) if low > 0.0 else st.floats(low, high)
    numbers = st.one_of(between, st.sampled_from([*around(low), *around(high), 0.0, -1.0]))
    return numbers.map(lambda value: f"{value!r}" if math.isfinite(value) else "1e999")


def values(key):
    odd = st.one_of(st.sampled_from(ODD), st.text(max_size=20), st.floats().map(repr), st.integers().map(str))
    mark = KEYS.get(key)
    return odd if mark is None else st.one_of(ends(mark), ends(mark), ends(mark), odd)


@st.composite
def changes(draw):
    """A few --set options."""
    keys = draw(st.lists(st.one_of(st.sampled_from(sorted(KEYS)), st.text(max_size=8)), max_size=4))
    return [part for key in keys for part in ("--set", f"{key}={draw(values(key))}")]


@st.composite
def command_lines(draw):
    """`rigid` with changes, a study, an invalid sweep, or any words."""
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
    """Ends a command that exceeds its time, uncaught by the program."""


@contextlib.contextmanager
def limited(seconds):
    """Raise TooLong after a processor time [s]."""

    def end(*_):
        raise TooLong

    before = signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def outcome(arguments):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = _status(arguments)
    return status, out.getvalue(), err.getvalue()


def demand_good_end(arguments):
    try:
        with limited(MAX_S):
            status, out, err = outcome(arguments)
    except TooLong:
        raise AssertionError(f"over {MAX_S} s of processor time: {arguments}") from None
    assert status in (0, 1, 2), (arguments, err)
    assert [words for words in ("internal error", "Traceback") if words in err] == []
    said = [line for line in err.splitlines() if not line.startswith("tailslap: remark: ")]
    assert (status == 2) == bool(said), (arguments, err)
    assert len(err) < 2000
    assert [letter for letter in err if not (letter.isprintable() or letter == "\n")] == []
    if status != 2 and "--json" in arguments and arguments[0] == "rigid" and "--help" not in arguments:
        json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} in JSON of {arguments}"))
    assert not {"nan", "inf"} & set(out.split()), (arguments, out)


@pytest.fixture(autouse=True, scope="module")
def compiled_before():
    """Compile the loops before the time of reading is measured."""
    outcome(["rigid", "impact-mash-tl4-sut"])


fuzz = settings(deadline=None, derandomize=True, suppress_health_check=list(HealthCheck), database=None)


@settings(fuzz, max_examples=100)
@given(command_lines())
def test_command_lines(arguments):
    demand_good_end(arguments)


FOUND = (
    "vehicle.yaw_inertia=1", "impact.speed=1e-06",
    "time.end=0.049787068367863944", "time.end=0.05", "time.end=100.0",
    "contact.initial_force=393923533635.0", "impact.angle=1.5707963267948963",
    "impact.angle=45deg impact.speed=50 contact.friction=0 contact.restitution=0.9 contact.stiffness=1e10"
    " vehicle.length=4 vehicle.width=2 vehicle.mass=1500",
)  # fmt: skip
"""Changes of the truck with linear crush that the long job has found, and what was found beside them."""
LINEAR = str(Path(__file__).parents[2] / "examples" / "linear-truck.toml")


@pytest.mark.parametrize("changed", FOUND)
def test_impacts_that_once_ended_badly(changed):
    words = (part for word in changed.split() for part in ("--set", word))
    demand_good_end(["rigid", LINEAR, *words])


@pytest.mark.long
@settings(fuzz, max_examples=2000)
@given(command_lines())
def test_many_command_lines(arguments):
    demand_good_end(arguments)


@pytest.mark.long
@pytest.mark.parametrize("scene", SCENES)
def test_all_numbers_at_either_end(scene):
    """Each number at its bounds has a finite result, or is refused."""
    for key, mark in KEYS.items():
        for value in (mark.least, mark.most) if mark else ():
            demand_good_end(["rigid", scene, "--json", "--set", f"{key}={value!r}"])


def test_the_keys_are_those_of_the_scenes():
    some = {"vehicle.length", "plate.thickness", "corner.friction", "contact.stiffness", "time.end"}
    assert some <= KEYS.keys()
    assert set(SCENES) <= read.shipped_scenes().keys()


RIGID, SWEEP = ("rigid", "mash-tl4-sut"), ("sweep", "mash-tl4-sut", "--vary")
SPREAD = ("study", "uncertainty", "mash-tl4-sut")
RUN, CHECK = ("run", "paper-table-3"), ("check", "paper-table-3", "--set")
LOCKED = (*RUN, "--set", "plate.elements=[1, 1]")
UNAFFORDABLE = ("time.threads=256", "time.safety_factor=1e-6", "plate.density=1e-8")
DEEP = "[" * 900 + "]" * 900
DIGITS = "9" * 5000
BEYOND = (
    *("strike.duration=1e-320", "vehicle.length=1e308", "impact.speed=1e9", "impact.speed=1e-300"),
    *("plate.thickness=1e-300", "plate.thickness=1e300", "plate.density=1e300", "corner.penalty_scale=1e300"),
    *(f"vehicle.length={text}" for text in (DEEP, DIGITS, "\uff11\uff10 m", "1\r0")),
    *("plate.thickness=1\nfoo=2", "plate.thickness=1 # inch"),
)
"""Changes that are refused by the name of their key."""
SECONDS = 5.0
"""Processor time [s] within which an input is refused: a guard; it usually takes a tenth of that."""


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        *(
            ((*RIGID, "--set", f"vehicle.length={unit}"), "the unit does not fit")
            for unit in ("7 m**(9**9**9)", "7 m*9**9**9", "7 m**99", "7 m^2.5", "7 m m^-", "7 m//s", "7 m 2")
        ),
        ((*RIGID, "--set", "vehicle.length=7 " + "m " * 100_000), "a length from"),
        *(((*RIGID, "--set", change), change.partition("=")[0]) for change in BEYOND),
        ((*RIGID, "--set", ".".join("a" * 5000) + "=1"), "KEY=VALUE"),
        ((*RIGID, "--set", "a" * 100_000 + "=1"), "KEY=VALUE"),
        *(((*CHECK, change), change.partition("=")[0]) for change in UNAFFORDABLE),
        ((*CHECK, "plate.elements=[1500,1500]"), "--allow-large"),
        (("check", "mash-tl4-sut", "--set", "impact.speed=1e-5"), "impact.speed"),
        *(((name, "mash-tl4-sut", "--tolerance", "nan"), "--tolerance") for name in ("modal", "run")),
        *((("modal", "mash-tl4-sut", "--modes", count), "--modes") for count in ("0", "\uff14")),
        (("run", "mash-tl4-sut", "--out", ""), "--out"), ((*SWEEP, "name=a,b"), "--vary"),
        ((*SWEEP, "corner.friction=0.1,0.2", "--cluster", ""), "--cluster"),
        ((*SWEEP, "corner.friction=0.1:0.2:\uff13"), "corner.friction"),
        ((*SPREAD, "--fix", "impact.speed", "--range", "impact.speed=1:2"), "--fix"),
        ((*SPREAD, "--range", "impact.speed=1:2", "--range", "impact.speed=1:3"), "--range"),
        *((("rigid", name), "not a regular file") for name in ("/dev/zero", "/dev/urandom", "/", "fifo.toml")),
        *(((*RUN, "--out", out), "--out") for out in ("/proc/x/x", "file", "file/x", "foreign")),
        (("run", "nowhere.toml"), "SCENE"), (("run",), "SCENE"), (("walk",), "walk"), ((*RUN, "--fast"), "--fast"),
        ((*RUN, "--set", "wall.length=5 m"), "wall.length"),
        ((*RUN, "--set", "plate.youngs_modulus=1e300"), "plate.youngs_modulus"),
        ((*LOCKED, "--set", "plate.element=quad4"), "plate.elements"), (("rigid", "large.toml"), "too large"),
        (("rigid", "deep.toml"), "deep.toml"), (("rigid", "dotted.toml"), "long line"),
        (("rigid", "digits.toml"), "digits.toml"), (("rigid", "return.toml"), "not TOML"),
        *((words, "argument: given") for words in (
            ("rigid", "bad\udcff.toml"), (*RIGID, "--set", "name=\udcff"), (*RUN, "--out", "bad\udcff"),
            ("export", "bad\udcff", "--to", "csv"), ("compare", "bad\udcff.csv", "fifo.toml"))),
        (("rigid", "x" * 5000), "SCENE"), (("rigid", "x" * 300 + ".toml"), "SCENE"),
        (("rigid", "mash-tl4-sut", "--\x1b[31m"), "\\x1b[31m"),
        ((*RIGID, "--set", "\x1b]0;mine\x07=1"), "\\x1b]0;mine\\x07"),
        ((*RIGID, "--set", "vehicle.length=\x1b[2J"), "\\x1b[2J"),
    ],
)  # fmt: skip
def test_it_is_refused_at_once(tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    write_files(tmp_path)
    before, began = sorted(tmp_path.rglob("*")), time.process_time()
    assert _status(list(arguments)) == 2
    out, err = capsys.readouterr()
    assert (out, time.process_time() - began < SECONDS) == ("", True)
    assert said in err
    assert len(err) < 1000
    assert [letter for letter in err if not (letter.isprintable() or letter == "\n")] == []
    assert [words for words in ("internal error", "Traceback") if words in err] == []
    assert sorted(tmp_path.rglob("*")) == before


def write_files(folder):
    (folder / "file").write_text("mine")
    (folder / "foreign").mkdir()
    (folder / "foreign" / "thesis.tex").write_text("mine")
    os.mkfifo(folder / "fifo.toml")
    (folder / "large.toml").write_text("# large\n" * 100_000)
    (folder / "deep.toml").write_text(f"a = {DEEP}")
    (folder / "dotted.toml").write_text(".".join("a" * 100_000) + " = 1")
    (folder / "digits.toml").write_text(f"a = {DIGITS}")
    (folder / "return.toml").write_bytes(b'name = "a"\r[vehicle]\r')


def test_a_number_that_lacks_its_unit_is_remarked_upon(capsys):
    assert _status([*RIGID, "--set", "impact.speed=45"]) == 0
    remark = "impact.speed = 45 without a unit is 45 m/s, 100.7 mph; the scene has this key in mph"
    assert remark in capsys.readouterr().err
    assert _status([*RIGID, "--set", "impact.speed=162 km/h"]) == 0
    assert capsys.readouterr().err == ""


def test_angles_are_told_in_degrees_too(capsys):
    assert _status([*RIGID, "--set", "impact.angle=80 deg"]) == 2
    assert "rad (80 deg)" in capsys.readouterr().err


def test_units_are_products_of_names():
    assert unit_factors("kg m^2/s**2") == (("kg", 1), ("m", 2), ("s", -2))
    assert unit_factors("1 / s") == (("s", -1),)
    assert unit_factors("N*m^-9") == (("N", 1), ("m", -9))
    assert converted(7.8, "g / cm**3", "kg/m^3") == pytest.approx(7800.0, rel=1e-15)
    for text in ("", "1", "(m)", "m^10", "m***2", "m*", "*m", "m^0", "2 m", "m\u00b2", "m" * 81):
        with pytest.raises(ValueError, match=r"a unit|product|too long"):
            unit_factors(text)


def test_numbers_without_a_digit_on_one_side():
    assert read_scene("mash-tl4-sut", ("impact.friction=.47",))[0].corner_friction == 0.47
    assert read_scene("mash-tl4-sut", ("vehicle.length=10.",))[0].vehicle.length == 10.0


def test_every_number_of_a_scene_has_bounds_on_both_sides():
    marks = [mark for mark in KEYS.values() if mark]
    assert len(marks) > 25
    lower = [mark.least for mark in marks]
    upper = [min(mark.most, mark.below) for mark in marks]
    assert {key for key, mark in KEYS.items() if mark and mark.least < -1.0} == {
        "trailer.kingpin",  # of a drawbar
        "sensor.behind_centre",
    }
    assert max(upper) <= 1e18
    assert all(low == 0.0 or abs(low) >= 1e-15 for low in lower)


def parameters(command):
    """Options and arguments of a command and those below it."""
    options = list(command.params)
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            options += parameters(command.get_command(context, name))
    return options


def test_every_option_has_a_type_that_refuses_what_is_odd():
    kinds = [parameter.type for parameter in parameters(commands)]
    assert len(kinds) > 40
    plain = (click.types.IntParamType, click.types.FloatParamType, click.Path)
    restricted = Whole | Real | Folder
    assert [kind for kind in kinds if isinstance(kind, plain) and not isinstance(kind, restricted)] == []
    assert any(isinstance(kind, Text) for kind in kinds)


def test_a_deep_table_is_refused():
    with pytest.raises(InputError, match="8 levels"):
        source_of_text("a." * 20 + "b = 1")


def test_what_a_terminal_would_obey_is_escaped():
    assert escaped("a\x1b[2J\u202e\x00b\u00fc\n") == "a\\x1b[2J\\u202e\\x00b\u00fc\n"


def test_streams_that_nobody_reads(tmp_path):
    read, write = os.pipe()
    os.close(read)
    for arguments in (("--help",), ("scenes",)):
        process = completed(*arguments, stdout=write)
        assert (process.returncode, process.stderr) == (0, "")
    os.close(write)
    process = completed("scenes", preexec_fn=lambda: os.close(1))
    assert (process.returncode, process.stderr) == (0, "")
    with open("/dev/full", "w") as full:
        process = completed("scenes", stdout=full)
    assert (process.returncode, process.stderr) == (3, "tailslap: No space left on device\n")


def test_too_little_memory_is_told_with_the_estimate():
    """Within a limit of the process's own, as in a small container."""
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (2_000_000_000, 2_000_000_000))  # noqa: E731
    arguments = ("check", "paper-table-3", "--set", "plate.elements=[600, 600]")
    process = completed(*arguments, preexec_fn=limit)
    assert process.returncode == 2
    assert "GB of memory" in process.stderr


def test_a_large_mesh_is_estimated_and_not_made(capsys):
    began = time.process_time()
    assert _status(["check", "paper-table-3", "--set", "plate.elements=[2000, 2000]", "--allow-large"]) == 0
    assert "about 4000000 nodes" in capsys.readouterr().out
    assert time.process_time() - began < SECONDS
