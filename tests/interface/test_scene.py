"""Verify keys, errors, units and variation of scenes."""

import json
import math
import warnings
from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest

import tailslap
from tailslap.campaign.sweep_definition import make_definition, varied_source
from tailslap.case.corner.corner_case import CornerCase
from tailslap.errors import InputError
from tailslap.scene.read import read_scene, read_source, remarks, shipped_scenes, source_of_text, unit_remarks
from tailslap.scene.schema import TABLES
from tailslap.scene.types import SceneTable
from tailslap.scene.vary import Source, changed_tables, parse_changes, shown, varied, vary, with_values
from tailslap.scene.write import scene_inputs, scene_text


def changed(*changes, scene="paper-table-3"):
    return read_scene(scene, changes)[0]


def test_one_file_is_read_for_a_shipped_scene(monkeypatch):
    names, read_text = list[str](), Path.read_text

    def noted(path: Path, **how: str) -> str:
        names.append(path.name)
        return read_text(path, **how)

    monkeypatch.setattr(Path, "read_text", noted)
    assert read_source("mash-tl4-sut").tables["vehicle"]
    assert names == ["mash-tl4-sut.toml"]


IN_SI = [
    ("impact.speed=56 mph", 56 * 1609.344 / 3600), ("impact.speed=90 km/h", 25.0),
    ("vehicle.length=2438 mm", 2.438), ("vehicle.length=10 ft", 3.048), ("vehicle.length=12", 12.0),
    ('vehicle.mass="22000 lb"', 22000 * 0.45359237), ("impact.angle=15 deg", math.pi / 12),
    ("impact.angle=0.26", 0.26), ("plate.youngs_modulus=2 TPa", 2e12),
    ("plate.youngs_modulus=2e5 N/mm^2", 2e11), ("plate.density=7.8 g/cm**3", 7800.0),
    ("start.omega=40 deg/s", math.radians(40.0)), ("strike.duration=100 ms", 0.1),
    ("plate.youngs_modulus=29000 ksi", 29e6 * 0.45359237 * 9.80665 / 0.0254**2),
]  # fmt: skip


@pytest.mark.parametrize(("change", "value"), IN_SI)
def test_units_arrive_in_si(change, value):
    read = attrgetter(change.partition("=")[0])
    assert read(changed(change)) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize("name", ["a", "a.b", "v1..2", "-_+", "Müller-3", "x" * 80])
def test_names_that_can_be_a_folder_s(name):
    assert changed(f"name='{name}'").name == name


def test_tables_that_need_each_other(tmp_path, refused):
    vehicle = 'name = "x"\n[vehicle]\nlength = 10\nwidth = 2\nmass = 1000\n'
    start = "[start]\nangle = 0.26\nomega = 0.7\ncorner_speed = 25\n"
    free = vehicle + start + "[corner]\nreaction = 'none'\n"
    for text, key in (
        (vehicle, "impact.speed"),
        (vehicle + "[start]\nangle = 0.26\n", "impact.speed"),
        (vehicle + start, "corner.friction"),
        (free + "[damping]\nratio = 0.1\n", "damping"),
        (free + "[wall]\nlength=30\ndepth=5\nelements=[1,1]\n", "wall"),
        ("name = 'x'\n", "vehicle.length"),
    ):
        path = tmp_path / "scene.toml"
        path.write_text(text)
        assert refused(read_scene, str(path)) == key
    path.write_text(vehicle + start + "[corner]\nreaction = 'none'\n")
    assert CornerCase(*read_scene(str(path))).stage1 is None


def test_a_file_without_a_name_takes_its_own(tmp_path, refused):
    path, text = tmp_path / "van.toml", shipped_scenes()["mash-tl4-sut"].read_text()
    path.write_text(text.replace('name = "mash-tl4-sut"', ""))
    assert read_scene(str(path))[0].name == "van"
    assert refused(vary, source_of_text(path.read_text()), {}) == "name"


def test_a_partial_start_takes_the_rest_from_stage_one():
    plan = CornerCase(*read_scene("mash-tl4-sut", ("start.angle=0.2",)))
    assert plan.stage1 is not None
    assert (plan.start.angle, plan.start.omega) == (0.2, plan.stage1.omega)


@pytest.mark.parametrize(("content", "message"), [
    (b"name = ", "not TOML"), (b'name = "a"\nname = "b"', "not TOML"), (b"\x00", "neither text in UTF-8"),
    (b"\xff\xfe\x00", "neither text in UTF-8"),
    (b'name = "a"\n[vehicle]\nlength = 5,9\n', "the decimal separator is a point"),
])  # fmt: skip
def test_malformed_files(tmp_path, content, message):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_scene(str(path))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_encodings_of_windows(tmp_path, encoding):
    text = shipped_scenes()["mash-tl4-sut"].read_text()
    (tmp_path / "scene.toml").write_bytes(text.replace("\n", "\r\n").encode(encoding))
    assert read_scene(str(tmp_path / "scene.toml")) == read_scene("mash-tl4-sut")


SCENE = "mash-tl4-sut"


SAID = [
    ("plate.youngs_modulus=2 TPa", "plate.youngs_modulus", 2e12),
    ("impact.angle=20 deg", "impact.angle", math.radians(20.0)),
    ("plate.elements=[10,3]", "plate.elements", (10, 3)),
    ("corner.reaction=signed", "corner.reaction", "signed"), ("damping.ratio=0.1", "damping.ratio", 0.1),
    ("wall=", "wall", None), ("strike.duration=0.2", "strike", {"duration": 0.2}),
]  # fmt: skip


@pytest.mark.parametrize(("text", "key", "value"), SAID)
def test_values_are_what_text_says(text, key, value):
    source = read_source(SCENE)
    assert vary(source, {key: value})[0] == read_scene(SCENE, (text,))[0]


def test_changes_travel_as_json():
    source = read_source(SCENE)
    changes = {"plate.elements": (10, 3), "plate.youngs_modulus": 0.1 + 0.2, "wall": None}
    assert vary(source, json.loads(json.dumps(changes)))[0] == vary(source, changes)[0]


def test_the_given_tables_are_left_alone_and_changes_add_up():
    source = read_source(SCENE)
    before = json.dumps(source.tables)
    first = vary(source, {"corner.friction": 0.1, "damping.ratio": 0.1})[1]
    second = vary(first, {"damping": None, "damping.ratio": 0.2, "corner.friction": 0.3})[0]
    assert (json.dumps(source.tables), first.tables["damping"]) == (before, {"ratio": 0.1})
    assert second.damping is not None
    assert (second.damping.ratio, second.corner.friction) == (0.2, 0.3)


def test_what_was_changed_is_noted_and_where_it_comes_from():
    scene, source = vary(read_source(SCENE), {"corner.friction": 0.1, "wall": None, "verify": None})
    assert "# changed: corner.friction, wall\n" in scene_text(source)
    assert source.changed == {"corner.friction", "wall"}  # there was no table verify
    origins = {row.key: row.origin for row in scene_inputs(scene, source)}
    assert (origins["corner.friction"], origins["vehicle.mass"]) == ("--set", "scene")


def test_changes_are_shown_as_they_could_be_given_again():
    changes = {"plate.elements": (10, 3), "plate.element": "quad9", "damping": None, "time.rows": 20}
    texts = shown(changes)
    assert texts == ("plate.elements=[10, 3]", "plate.element=quad9", "damping=", "time.rows=20")
    assert parse_changes(texts, {"damping": {}}) == changes | {"plate.elements": [10, 3]}


TRAILER = {"length": "48 ft", "width": 2.6, "mass": 27770, "hitch": "5.6 m", "kingpin": 0.9}
LINEAR = str(Path(__file__).parents[2] / "examples" / "linear-truck.toml")


def test_a_trailer_is_changed_written_and_taken_out_by_its_number(tmp_path):
    changes: dict[str, Any] = {"plate": None, "vehicle.length": 6.9, "trailer": [TRAILER]}
    changes |= {"trailer.0.kingpin": -3.0, "trailer.0.mass": "20 klb"}
    scene, source = vary(read_source(LINEAR), changes)
    (trailer,) = scene.trailer
    sizes = (trailer.length, trailer.mass, trailer.kingpin)
    assert sizes == pytest.approx((14.6304, 9071.8474, -3.0), rel=1e-12)
    (tmp_path / "written.toml").write_text(scene_text(source))
    assert read_scene(str(tmp_path / "written.toml"))[0] == vary(Source.of(scene), {})[0] == scene
    origins = {row.key: row.origin for row in scene_inputs(scene, source)}
    assert (origins["trailer.0.mass"], origins["trailer.0.hitch"]) == ("--set", "scene")
    assert read_scene(str(tmp_path / "written.toml"), ("trailer.0=",))[0].trailer == ()
    source = read_source(str(tmp_path / "written.toml"))
    assert shown(parse_changes(["trailer.0.mass=1 t"], source.tables)) == ("trailer.0.mass=1 t",)
    remark = "trailer.0.width = 102 without a unit is 102 m, 334.6 ft"
    assert list(remarks(vary(source, {"trailer.0.width": 102.0})[1])) == [remark]


def test_a_scene_is_its_own_source():
    scene = read_scene(SCENE)[0]
    assert vary(Source.of(scene), {})[0] == scene
    assert varied(scene, {"corner.friction": 0.2}).corner.model_fields_set >= {"friction"}
    assert varied(scene, {}).plate == scene.plate


@pytest.mark.parametrize("changes", [
    {"plate.elements": (6, 3), "plate.element": "quad9"}, {"damping.kind": "elastic-velocity", "damping.rate": 3.0},
    {"corner.constraint": "exact", "output": None}, {"damping.kind": None, "damping.rate": None}, {"damping": None},
    {"time.threads": 2}, {"corner.penalty_scale": 0.1},
])  # fmt: skip
def test_values_are_those_of_the_validated_scene(changes):
    """Without validation, the same keys are set and have the same values."""
    damped = {
        "damping.ratio": 0.1,
        "damping.kind": "elastic-velocity",
        "damping.rate": 1.0,
        "output.fields": 3,
    }
    scene = varied(read_scene(SCENE)[0], damped)
    expected, scene = varied(scene, changes), with_values(scene, changes)
    assert scene == expected
    for name in TABLES:
        table, other = getattr(scene, name, None), getattr(expected, name, None)
        if isinstance(table, SceneTable):
            assert isinstance(other, SceneTable)
            assert table.model_fields_set == other.model_fields_set


@pytest.mark.parametrize(("change", "said"), [
    ("impact.speed=25", "impact.speed = 25 without a unit is 25 m/s, 55.92 mph; the scene has this key in mph"),
    ("impact.angle=15", "impact.angle = 15 without a unit is 15 rad, 859.4 deg; the scene has this key in deg"),
    ("vehicle.width=2438", "vehicle.width = 2438 without a unit is 2438 m, 2.438e+06 mm; the scene has this key in mm"),
    ("vehicle.mass=9979", None), ("impact.speed=25 m/s", None), ("impact.friction=0.4", None),
    ("start.omega=1", None), ("impact=", None),
])  # fmt: skip
def test_a_number_in_place_of_a_value_in_another_unit_is_remarked_upon(change, said):
    source = read_source("mash-tl4-sut")
    tables, noted = changed_tables(source.tables, parse_changes([change], source.tables))
    changed = Source(source.text, tables, frozenset(noted))
    assert list(unit_remarks(changed).values()) == ([said] if said else [])
    assert [text for text in remarks(changed) if "the scene has" in text] == ([said] if said else [])


def test_the_table_of_inputs_states_the_unit_that_a_number_has_not():
    origins = {row.key: row.origin for row in scene_inputs(*read_scene("mash-tl4-sut", ("impact.speed=25",)))}
    assert (origins["impact.speed"], origins["impact.angle"]) == ("--set, not in mph", "scene")


@pytest.mark.parametrize("values", ["25:30:3", "60 mph,25", "log:25:30:3"])
def test_varied_numbers_are_remarked_upon(values):
    definition = make_definition(
        "mash-tl4-sut", ("plate.elements=[4, 2]",), (f"impact.speed={values}",), None, 0
    )
    assert unit_remarks(varied_source(definition)).keys() == {"impact.speed"}
    assert unit_remarks(definition.source) == {}


def test_typed_changes_of_every_function_are_remarked_upon(tmp_path):
    """Numbers of Python are in SI, without a remark."""
    said = "the scene has this key in mph"
    with pytest.warns(UserWarning, match=said):
        tailslap.rigid("mash-tl4-sut", ["impact.speed=25"])
    with pytest.warns(UserWarning, match=said):
        tailslap.study("uncertainty", "mash-tl4-sut", ["impact.speed=25"], samples=1000)
    with pytest.warns(UserWarning, match=said):
        tailslap.study("uncertainty", "mash-tl4-sut", samples=1000, range={"impact.speed": "24:26"})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tailslap.rigid("mash-tl4-sut", {"impact.speed": 25.0})
        tailslap.study("uncertainty", "mash-tl4-sut", {"impact.speed": 25.0}, samples=1000)
