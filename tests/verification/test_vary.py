"""Verification: a scene is varied by values as by text, the given one is left alone, and what was changed is noted."""

import json
import math

import pytest

from tailslap.errors import InputError
from tailslap.scene.read import read_scene, read_source
from tailslap.scene.vary import Source, parse_changes, shown, varied, vary
from tailslap.scene.write import scene_inputs

SCENE = "mash-tl4-sut"


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("plate.youngs_modulus=2 TPa", "plate.youngs_modulus", 2e12),
        ("impact.angle=20 deg", "impact.angle", math.radians(20.0)),
        ("plate.elements=[10,3]", "plate.elements", (10, 3)),
        ("corner.reaction=signed", "corner.reaction", "signed"),
        ("damping.ratio=0.1", "damping.ratio", 0.1),
        ("wall=", "wall", None),
        ("strike.duration=0.2", "strike", {"duration": 0.2}),
    ],
)
def test_values_are_what_text_says(text, key, value):
    source = read_source(SCENE)
    assert vary(source, {key: value})[0] == read_scene(SCENE, (text,))[0]


def test_changes_travel_as_json():
    source = read_source(SCENE)
    changes = {"plate.elements": (10, 3), "plate.youngs_modulus": 0.1 + 0.2, "wall": None}
    assert vary(source, json.loads(json.dumps(changes)))[0] == vary(source, changes)[0]


def test_the_given_tables_are_left_alone_and_changes_add_up():
    source = read_source(SCENE)
    before = json.dumps(source.given)
    first = vary(source, {"corner.friction": 0.1, "damping.ratio": 0.1})[1]
    second = vary(first, {"damping": None, "damping.ratio": 0.2, "corner.friction": 0.3})[0]
    assert json.dumps(source.given) == before
    assert first.given["damping"] == {"ratio": 0.1}
    assert second.damping is not None
    assert (second.damping.ratio, second.corner.friction) == (0.2, 0.3)


def test_what_was_changed_is_noted_and_where_it_comes_from():
    scene, source = vary(read_source(SCENE), {"corner.friction": 0.1, "wall": None, "verify": None})
    assert source.text.endswith("# changed by --set corner.friction=0.1\n# changed by --set wall=\n")
    assert source.changed == {"corner.friction", "wall"}  # there was no table verify
    origins = {row.key: row.origin for row in scene_inputs(scene, source)}
    assert origins["corner.friction"] == "--set"
    assert origins["vehicle.mass"] == "scene"


def test_changes_are_shown_as_they_could_be_given_again():
    changes = {"plate.elements": (10, 3), "plate.element": "quad9", "damping": None, "time.rows": 20}
    texts = shown(changes)
    assert texts == ("plate.elements=[10, 3]", "plate.element=quad9", "damping=", "time.rows=20")
    assert parse_changes(texts, {"damping": {}}) == changes | {"plate.elements": [10, 3]}


@pytest.mark.parametrize(
    ("changes", "key", "allowed"),
    [
        ({"plate.thickness": -1.0}, "plate.thickness", "from 1e-06 m to 1e+06 m"),
        ({"plate.colour": 1}, "plate.colour", "no such key"),
        ({"plate.thickness.x": 1}, "plate.thickness.x", "not a table"),
        ({"corner.reaction": "none", "corner.friction": 0.1}, "corner.friction", "no meaning"),
        ({"vehicle.mass": None}, "vehicle.mass", "required"),
        ({"time.rows": 20.5}, "time.rows", "integer"),
    ],
)
def test_what_makes_no_scene_is_refused_by_its_key(changes, key, allowed):
    with pytest.raises(InputError) as caught:
        vary(read_source(SCENE), changes)
    assert caught.value.key == key
    assert allowed in caught.value.allowed


def test_a_scene_is_its_own_source():
    scene = read_scene(SCENE)[0]
    assert vary(Source.of(scene), {})[0] == scene
    assert varied(scene, {"corner.friction": 0.2}).corner.model_fields_set >= {"friction"}
    assert varied(scene, {}).plate == scene.plate
