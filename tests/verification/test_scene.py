"""Verification: what a scene may say, what it is told otherwise, and that units arrive in SI."""

import math

import pytest

from tailslap.case import case_of
from tailslap.case.corner.case import CornerCase
from tailslap.errors import InputError
from tailslap.scene.read import read_scene, shipped_scenes
from tailslap.scene.schema import Scene

SHIPPED = {"mash-tl4-sut", "paper-table-3", "paper-abaqus"}


def changed(*changes: str, scene: str = "paper-table-3") -> Scene:
    return read_scene(scene, changes)[0]


@pytest.mark.parametrize("name", sorted(shipped_scenes()))
def test_shipped_scenes_have_their_own_name_and_a_solution(name):
    scene, text = read_scene(name)
    assert scene.name == name
    plan = case_of(scene, text)
    instants = [strike.start for strike in plan.motion.strikes] if scene.contact else [plan.motion.strike.t]
    assert instants[-1] > 0.0


def test_the_papers_scenes_are_there():
    assert set(shipped_scenes()) >= SHIPPED


@pytest.mark.parametrize(
    ("change", "path", "value"),
    [
        ("impact.speed=56 mph", ("impact", "speed"), 56 * 1609.344 / 3600),
        ("impact.speed=90 km/h", ("impact", "speed"), 25.0),
        ("vehicle.length=2438 mm", ("vehicle", "length"), 2.438),
        ("vehicle.length=10 ft", ("vehicle", "length"), 3.048),
        ("vehicle.length=12", ("vehicle", "length"), 12.0),
        ('vehicle.mass="22000 lb"', ("vehicle", "mass"), 22000 * 0.45359237),
        ("impact.angle=15 deg", ("impact", "angle"), math.pi / 12),
        ("impact.angle=0.26", ("impact", "angle"), 0.26),
        ("plate.youngs_modulus=2 TPa", ("plate", "youngs_modulus"), 2e12),
        ("plate.youngs_modulus=2e5 N/mm^2", ("plate", "youngs_modulus"), 2e11),
        ("plate.density=7.8 g/cm**3", ("plate", "density"), 7800.0),
        ("start.omega=40 deg/s", ("start", "omega"), math.radians(40.0)),
        ("strike.duration=100 ms", ("strike", "duration"), 0.1),
    ],
)
def test_units_arrive_in_si(change, path, value):
    table = getattr(changed(change), path[0])
    assert getattr(table, path[1]) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("change", "key", "allowed"),
    [
        ("vehicle.length=0", "vehicle.length", "from 1e-06 m to 1e+06 m"),
        ("vehicle.width=-3 m", "vehicle.width", "from 1e-06 m to 1e+06 m"),
        ("vehicle.length=3 kg", "vehicle.length", "the unit does not fit"),
        ("vehicle.length=3 blub", "vehicle.length", "the unit does not fit"),
        ("vehicle.mass=nan", "vehicle.mass", "a mass from 1e-06 kg"),
        ("vehicle.mass=inf", "vehicle.mass", "a mass from 1e-06 kg"),
        ('vehicle.mass="nan kg"', "vehicle.mass", "a mass from 1e-06 kg"),
        ("vehicle.mass=true", "vehicle.mass", "a mass from 1e-06 kg"),
        ("vehicle.mass=9979 lbf", "vehicle.mass", "the unit does not fit"),
        ('vehicle.mass="9979"', "vehicle.mass", "a string with its unit"),
        ("impact.angle=15", "impact.angle", "below 90 deg"),
        ("impact.angle=90 deg", "impact.angle", "below 90 deg"),
        ('impact.angle="15"', "impact.angle", "a string with its unit"),
        ("impact.friction=-0.1", "impact.friction", "from 0 to"),
        ("impact.friction=0.4 m", "impact.friction", "a plain number"),
        ("impact.restitution=1.2", "impact.restitution", "from 0 to 1"),
        ("impact.convention=mine", "impact.convention", "'paper' or 'newton'"),
        ("start.omega=-1", "start.omega", "from 1e-09 rad/s"),
        ("start.angle=100 deg", "start.angle", "below 90 deg"),
        ("corner.reaction=push", "corner.reaction", "'drag', 'none' or 'signed'"),
        ("corner.penalty_scale=0", "corner.penalty_scale", "from 1e-06"),
        ("plate.elements=[0, 6]", "plate.elements", "two whole numbers from 1"),
        ("plate.elements=[20, 6.5]", "plate.elements", "two whole numbers from 1"),
        ("plate.elements=[20]", "plate.elements", "two whole numbers from 1"),
        ("plate.elements=[100000, 100000]", "plate.elements", "at most 4000000"),
        ("plate.poissons_ratio=0.5", "plate.poissons_ratio", "to 0.4999"),
        ("plate.thicknes=1", "plate.thicknes", "there is no such key; allowed are thickness"),
        ("colour.red=1", "colour", "there is no such key; allowed are name, vehicle"),
        ("vehicle=3", "vehicle", "a table"),
        ("time.safety_factor=1.1", "time.safety_factor", "to 1"),
        ("damping.ratio=0", "damping.ratio", "from 1e-09"),
        *(
            (f"name={name}", "name", "letters, digits")
            for name in ("../up", "..", ".x", "a/b", "a b", "x" * 81)
        ),
        ('name="."', "name", 'no "." in front'),
        ('name=""', "name", "1 to 80"),
        ("name=3", "name", "letters, digits"),
        ("wall.length=-1 m", "wall.length", "from 1e-06 m to 1e+06 m"),
        ("vehicle.length", "--set", "KEY=VALUE"),
        ("=3", "--set", "KEY=VALUE"),
        ("vehicle.length.x=3", "--set", "not a table"),
    ],
)
def test_wrong_values_are_told_which_key_and_what_is_allowed(change, key, allowed):
    with pytest.raises(InputError) as caught:
        changed(change)
    assert caught.value.key == key
    assert allowed in caught.value.allowed
    assert str(caught.value).startswith(f"{key}: given ")


@pytest.mark.parametrize("name", ["a", "a.b", "v1..2", "-_+", "Müller-3", "x" * 80])
def test_names_that_can_be_a_folder_s(name):
    assert changed(f"name='{name}'").name == name


@pytest.mark.parametrize(
    ("changes", "key", "allowed"),
    [
        (("impact.friction=2",), "impact.friction", "cot"),
        (("impact.restitution=1",), "impact.restitution", "never reaches the wall"),
        (("impact.angle=80 deg",), "impact.angle", "less than"),
        (("corner.friction=4",), "corner.friction", "not unique"),
        (("start.angle=80 deg",), "start.angle", "less than"),
        (("corner.reaction=signed", "corner.friction=4"), "corner.friction", ""),
        (("start.corner_speed=0.01",), "start.corner_speed", ""),
    ],
)
def test_what_the_theory_refuses_names_the_scenes_key(changes, key, allowed):
    with pytest.raises(InputError) as caught:
        CornerCase(*read_scene("mash-tl4-sut", changes))
    assert caught.value.key == key
    assert allowed in caught.value.allowed


def test_friction_has_no_meaning_without_friction():
    with pytest.raises(InputError, match=r"corner\.friction: given 0\.3; it has no meaning"):
        changed("corner.friction=0.3", scene="paper-abaqus")


def test_tables_that_need_each_other(tmp_path):
    vehicle = 'name = "x"\n[vehicle]\nlength = 10\nwidth = 2\nmass = 1000\n'
    start = "[start]\nangle = 0.26\nomega = 0.7\ncorner_speed = 25\n"
    for text, key in (
        (vehicle, "impact"),
        (vehicle + "[start]\nangle = 0.26\n", "impact"),
        (vehicle + start, "corner.friction"),
        (vehicle + start + "[corner]\nreaction = 'none'\n[damping]\nratio = 0.1\n", "damping"),
        (
            vehicle + start + "[corner]\nreaction = 'none'\n[wall]\nlength=30\ndepth=5\nelements=[1,1]\n",
            "wall",
        ),
        ("name = 'x'\n", "vehicle"),
    ):
        path = tmp_path / "scene.toml"
        path.write_text(text)
        with pytest.raises(InputError) as caught:
            read_scene(str(path))
        assert caught.value.key == key
    path.write_text(vehicle + start + "[corner]\nreaction = 'none'\n")
    assert CornerCase(*read_scene(str(path))).stage1 is None


def test_a_partial_start_takes_the_rest_from_stage_one():
    plan = CornerCase(*read_scene("mash-tl4-sut", ("start.angle=0.2",)))
    assert plan.stage1 is not None
    assert plan.start.angle == 0.2
    assert plan.start.omega == plan.stage1.omega


@pytest.mark.parametrize(
    ("text", "message"),
    [("name = ", "not TOML"), ("\x00", "not TOML"), ('name = "a"\nname = "b"', "not TOML")],
)
def test_malformed_files(tmp_path, text, message):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_scene(str(path))


@pytest.mark.parametrize("name", ["nowhere.toml", "paper-table3"])
def test_scenes_that_are_not_there(name):
    with pytest.raises(InputError, match="SCENE"):
        read_scene(name)


def test_a_file_that_is_not_text(tmp_path):
    (tmp_path / "scene.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not text in UTF-8"):
        read_scene(str(tmp_path / "scene.toml"))
