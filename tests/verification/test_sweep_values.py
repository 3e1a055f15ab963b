"""Verification: what a sweep varies, against values known by hand, and the refusal of what makes no sense."""

import json
import math
from fractions import Fraction

import numpy as np
import pytest

from tailslap.campaign.definition import (
    Definition,
    TypedRange,
    latin_hypercube,
    make_definition,
    parse_varied,
    split_outside,
)
from tailslap.cli import _status
from tailslap.errors import InputError

SCENE = "paper-table-3"
MPH = 1609.344 / 3600.0


def grid(*varied: str, changes: tuple[str, ...] = ()) -> Definition:
    return make_definition(SCENE, changes, varied, None, 307)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("0:0.6:13", TypedRange("0", "0.6", 13, False)),
        ("log:1e8:1e13:40", TypedRange("1e8", "1e13", 40, True)),
        ("50 mph : 60 mph : 5", TypedRange("50 mph", "60 mph", 5, False)),
        ("10deg,15deg", ("10deg", "15deg")),
        ("quad4, tri3", ("quad4", "tri3")),
        ("[6, 2],[12,4]", ("[6, 2]", "[12,4]")),
        ('"a,b",c', ('"a,b"', "c")),
        ("0.3", ("0.3",)),
    ],
)
def test_values_as_typed(text, found):
    assert parse_varied(f"key={text}", False) == ("key", found)


def test_sampled_ranges_have_no_count():
    assert parse_varied("key=log:1:10", True)[1] == TypedRange("1", "10", None, True)
    assert split_outside("a:[b:c]:'d:e'", ":") == ["a", "[b:c]", "'d:e'"]


def test_even_values_are_exact():
    """Of 0 to 0.6 in 13 values each is a twentieth times its number, to a rounding or two; the ends are exact."""
    (item,) = grid("corner.friction=0:0.6:13").variations
    exact = [float(Fraction(i, 20)) for i in range(13)]
    assert item.values == pytest.approx(exact, rel=4e-16)
    assert (item.values[0], item.values[-1]) == (0.0, 0.6)
    assert item.settings == item.values


def test_equal_ratios_are_exact():
    (item,) = grid("plate.youngs_modulus=log:1e8:1e13:6").variations
    assert item.values == pytest.approx([1e8, 1e9, 1e10, 1e11, 1e12, 1e13], rel=1e-14)
    assert (item.values[0], item.values[-1]) == (1e8, 1e13)


def test_units_become_si():
    speed, angle = grid("impact.speed=50 mph:60 mph:3", "impact.angle=10deg,15deg").variations
    assert speed.values == pytest.approx([50 * MPH, 55 * MPH, 60 * MPH], rel=1e-14)
    assert angle.values == pytest.approx([math.radians(10), math.radians(15)], rel=1e-14)
    assert (speed.unit, angle.unit, angle.settings) == ("m/s", "rad", angle.values)


def test_words_lists_and_whole_numbers():
    element, counts, rows = grid(
        "plate.element=quad4,tri3", "plate.elements=[6,2],[12,4]", "time.rows=100:300:3"
    ).variations
    assert (element.values, element.numeric) == (("quad4", "tri3"), False)
    assert counts.values == ("6 x 2", "12 x 4")
    assert counts.settings == ((6, 2), (12, 4))
    assert rows.values == rows.settings == (100, 200, 300)


def test_a_grid_has_every_combination_once():
    definition = grid("corner.friction=0.1,0.2,0.3", "plate.element=quad4,tri3")
    combinations = [tuple(definition.inputs_of(run).values()) for run in range(definition.runs)]
    assert combinations == [(f, e) for f in (0.1, 0.2, 0.3) for e in ("quad4", "tri3")]
    assert definition.changes_of(3) == {"corner.friction": 0.2, "plate.element": "tri3"}
    fixed = grid("corner.friction=0.1,0.2", changes=("strike.duration=0.2",))
    assert fixed.changes_of(1) == {"corner.friction": 0.2}
    assert fixed.source.given["strike"] == {"duration": 0.2}


@pytest.mark.parametrize("runs", [2, 7, 64])
def test_each_stratum_has_one_sample(runs):
    shares = latin_hypercube(3, runs, 307)
    assert [sorted(column) for column in np.floor(shares * runs).astype(int).T] == [list(range(runs))] * 3
    assert not np.array_equal(shares, latin_hypercube(3, runs, 308))
    assert np.array_equal(shares, latin_hypercube(3, runs, 307))


def test_samples_fill_their_ranges_evenly():
    """One in each of 20 equal parts, of ratios where the range is in ratios; each word of two ten times."""
    varied = ("corner.friction=0.1:0.5", "plate.youngs_modulus=log:1e9:1e11", "plate.element=quad4,tri3")
    definition = make_definition(SCENE, (), varied, 20, 307)
    friction, modulus, element = definition.variations
    shares = (np.array(friction.values) - 0.1) / 0.4, np.log10(np.array(modulus.values) / 1e9) / 2.0
    assert [sorted((share * 20).astype(int)) for share in shares] == [list(range(20))] * 2
    assert sorted(element.values) == ["quad4"] * 10 + ["tri3"] * 10
    assert definition.runs == 20
    assert definition.inputs_of(4) == {item.key: item.values[4] for item in definition.variations}


def test_the_definition_on_disk_tells_sweeps_apart():
    one = grid("corner.friction=0:0.6:3").as_written()
    assert one == grid("corner.friction=0:0.6:3").as_written() == json.loads(json.dumps(one))
    assert one != grid("corner.friction=0:0.6:4").as_written()
    sampled = [
        make_definition(SCENE, (), ("corner.friction=0:0.6",), 5, seed).as_written() for seed in (1, 2)
    ]
    assert sampled[0]["digest"] != sampled[1]["digest"]


WRONG = [
    (["--vary", "corner.friction=0:0.6"], "corner.friction", "how many values"),
    (["--vary", "corner.friction=0:0.6:1"], "corner.friction", "from 2"),
    (["--vary", "corner.friction=0:0.6:2.5"], "corner.friction", "whole number"),
    (["--vary", "corner.friction=0.3:0.3:4"], "corner.friction", "must differ"),
    (["--vary", "corner.friction=log:0:0.6:4"], "corner.friction", "above 0"),
    (["--vary", "corner.friction=-0.1:0.6:4"], "corner.friction", "from 0 to"),
    (["--vary", "corner.friction=0.1,,0.2"], "corner.friction", "KEY=VALUES"),
    (["--vary", "corner.friction="], "--vary", "KEY=VALUES"),
    (["--vary", "corner.friction"], "--vary", "KEY=VALUES"),
    (["--vary", "corner..friction=1,2"], "--vary", "KEY=VALUES"),
    (["--vary", "a:b:c:d=1"], "a:b:c:d", "no such key"),
    (["--vary", "corner.friction=1:2:3:4"], "corner.friction", "KEY=VALUES"),
    (["--vary", "corner.colour=1,2"], "corner.colour", "no such key; allowed are reaction"),
    (["--vary", "corner.reaction=drag,push"], "corner.reaction", "allowed is 'drag', 'none' or 'signed'"),
    (["--vary", "corner.reaction=drag:none:2"], "corner.reaction", "a range is of numbers"),
    (["--vary", "impact.speed=50 kg:60 kg:3"], "impact.speed", "the unit does not fit"),
    (["--vary", "time.rows=100:200:4"], "time.rows", "not all of its values are whole"),
    (["--vary", "corner.friction=0:1:3", "--vary", "corner.friction=1,2"], "--vary", "varied twice"),
    (["--vary", "corner.friction=0:1:3", "--set", "corner.friction=1"], "--vary", "--set fixes it"),
    (
        ["--vary", "corner.friction=0:1:2000", "--vary", "plate.poissons_ratio=0:0.4:501"],
        "--vary",
        "at most 1000000",
    ),
    (["--vary", "corner.friction=0:0.6:3", "--sample", "10"], "corner.friction", "--sample says how many"),
    (["--vary", "time.rows=100:200", "--sample", "10"], "time.rows", "sampled from a list"),
    (
        ["--vary", "corner.friction=0:1:3", "--cluster", "tcp://x:1", "--workers", "2"],
        "--workers",
        "leave out",
    ),
    (["--vary", "corner.friction=0:1:3", "--out", "file"], "--out", "this is a file"),
    (["--vary", "corner.friction=0:1:3", "--out", "full"], "--out", "it holds other files"),
    (["--vary", "corner.friction=0:1:3", "--out", "file/below"], "--out", "the folder cannot be made"),
]


@pytest.mark.parametrize(("arguments", "key", "message"), WRONG)
def test_wrong_input_is_told_and_nothing_is_written(arguments, key, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("kept")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "summary.json").write_text("{}")
    assert _status(["sweep", SCENE, *arguments]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"tailslap: {key}: given")
    assert message in said
    assert {path.name for path in tmp_path.rglob("*")} == {"file", "full", "summary.json"}


def test_a_scene_without_plate_is_refused(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text('name = "x"\n[vehicle]\nlength = 10\nwidth = 2.4\nmass = 9979\n')
    with pytest.raises(InputError, match=r"plate: given nothing; a run needs"):
        make_definition(str(scene), (), ("vehicle.mass=1:2:3",), None, 307)
