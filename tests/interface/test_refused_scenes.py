"""Verify that wrong scenes are refused by their key."""

import math
import re
from pathlib import Path
from typing import Any

import pytest

import tailslap
from tailslap.errors import InputError
from tailslap.scene.read import read_scene

PAPER, CORNER, PLANE = "paper-table-3", "mash-tl4-sut", "impact-mash-tl4-sut"
TRACTOR, SPACE, TRAIN_IN_SPACE = (
    *("impact-mash-tl5-tractor-van", "impact-tipping-tl4-sut"),
    "examples/train-in-space.toml",
)
LINEAR = str(Path(__file__).parents[2] / "examples" / "linear-truck.toml")

SIZE, UNIT, MASS = "from 1e-06 m to 1e+06 m", "the unit does not fit", "a mass from 1e-06 kg"
TYPED = {
    ("vehicle.length", SIZE): ["0"], ("vehicle.width", SIZE): ["-3 m"], ("wall.length", SIZE): ["-1 m"],
    ("plate.thickness", SIZE): ["-1"],
    ("vehicle.length", UNIT): ["3 kg", "3 blub"], ("vehicle.mass", UNIT): ["9979 lbf", "22 kip"],
    ("plate.youngs_modulus", UNIT): ["29000 kip"], ("plate.density", UNIT): ["490 lbf/ft^3"],
    ("impact.test_level", "'H3', 'H4a' or 'H4b'"): ["H4", "h1", "TL4"],
    ("vehicle.mass", MASS): ["nan", "inf", '"nan kg"', "true"],
    ("vehicle.mass", "a string with its unit"): ['"9979"'], ("vehicle.mass", "did you mean lb?"): ["22000 lbs"],
    ("vehicle.width", "the decimal separator is a point"): ["2,4 m", '"2,4"'],
    ("impact.angle", "of at least 0.0001 deg and below 90 deg"): ["90 deg"],
    ("impact.angle", "of at least 1.75e-06 rad and below 1.57 rad"): ["15"],
    ("impact.speed", "from 2.24e-06 mph to 22300 mph"): ["0 mph", "1e5 mph"],
    ("impact.angle", "a string with its unit"): ['"15"'], ("impact.friction", "from 0 to"): ["-0.1"],
    ("impact.friction", "a plain number"): ["0.4 m", '"0.47"'], ("impact.restitution", "from 0 to 1"): ["1.2"],
    ("impact.convention", "'paper' or 'newton'"): ["mine"], ("start.omega", "from 1e-09 rad/s"): ["-1"],
    ("start.angle", "below 90 deg"): ["100 deg"], ("corner.reaction", "'drag', 'none' or 'signed'"): ["push"],
    ("corner.penalty_scale", "from 1e-06"): ["0"],
    ("plate.elements", "two whole numbers from 1"): ["[0, 6]", "[20, 6.5]", "[20]"],
    ("plate.elements", "at most 4000000"): ["[100000, 100000]"], ("plate.poissons_ratio", "to 0.4999"): ["0.5"],
    ("plate.thicknes", "this key does not exist; allowed are thickness"): ["1"],
    ("plate.thicknes", "did you mean plate.thickness?"): ["1 mm"],
    ("contact.stifness", "did you mean contact.stiffness?"): ["1 MN/m"],
    ("plate.mass", "did you mean vehicle.mass?"): ["1 kg"], ("pltae", "did you mean plate?"): ["{}"],
    ("vehicle", "a table"): ["3"], ("time.safety_factor", "to 1"): ["1.1"], ("damping.ratio", "from 1e-09"): ["0"],
    ("time.rows", "integer"): ["20.5"],
    ("verify.companion", "true or false"): ["1", "maybe"], ("verify.mesh", "below 1"): ["0", "1"],
    ("name", "letters, digits"): ["../up", "..", ".x", "a/b", "a b", "x" * 81, "3"],
    ("name", 'no "." in front'): ['"."'], ("name", "1 to 80"): ['""'],
}  # fmt: skip
"""Values of a key and what is allowed, as typed."""

HIGH = {"at": 0.0, "height": [0.4, 0.9], "stiffness": 4e6}
TRAILER = {"length": "48 ft", "width": 2.6, "mass": 27770, "hitch": "5.6 m", "kingpin": 0.9}
ONE_TRAILER = {"vehicle.length": 6.9, "trailer": [TRAILER]}
BEHIND = "from 0 to twice the length of the unit ahead, 13.8 m"

WRONG: list[tuple[Any, Any, str, str]] = [
    *((PAPER, [f"{key}={value}"], key, words) for (key, words), values in TYPED.items() for value in values),
    (PAPER, ["vehicle.length"], "--set", "KEY=VALUE"), (PAPER, ["=3"], "--set", "KEY=VALUE"),
    (PAPER, ["vehicle.length.x=3"], "--set", "not a table"),
    (PAPER, ["colour.red=1"], "colour", "this key does not exist; allowed are name, vehicle"),
    ("paper-abaqus", ["corner.friction=0.3"], "corner.friction", "no effect"),
    (CORNER, {"corner.reaction": "none", "corner.friction": 0.1}, "corner.friction", "no effect"),
    (CORNER, {"vehicle.mass": None}, "vehicle.mass", "required"),
    (CORNER, {"plate.thickness.x": 1}, "plate.thickness.x", "not a table"),
    (CORNER, {"body.centre_height": 1.3}, "body", ""),
    # Refused by the theory:
    (CORNER, ["impact.friction=2"], "impact.friction", "cot"),
    (CORNER, ["impact.restitution=1"], "impact.restitution", "never reaches the wall"),
    (CORNER, ["impact.angle=80 deg"], "impact.angle", "less than"),
    (CORNER, ["start.angle=80 deg"], "start.angle", "less than"),
    (CORNER, ["corner.friction=4"], "corner.friction", "not unique"),
    (CORNER, ["start.corner_speed=0.01 m/s"], "start.corner_speed", ""),
    (CORNER, ["corner.reaction=signed", "corner.friction=4"], "corner.friction", ""),
    # Trains:
    (CORNER, ONE_TRAILER, "trailer", "that of one rigid body"),
    *((LINEAR, ONE_TRAILER | changes, key, words) for changes, key, words in (
        ({"trailer.0.hitch": 13.9}, "trailer.0.hitch", BEHIND),
        ({"trailer.0.kingpin": 15.0}, "trailer.0.kingpin", "to the trailer's length, 14.6304 m"),
        ({"damping.kind": "elastic-velocity", "damping.rate": 5.0}, "damping.kind", "the hinges"),
        ({"trailer.0.kingpin": -15.0, "plate": None}, "trailer.0.kingpin", "from -14.6304, a"),
        ({"trailer.0.mass": 0}, "trailer.0.mass", "a mass from 1e-06 kg"),
        ({"trailer.0.kingpin": None}, "trailer.0.kingpin", "required"),
        ({"trailer": [TRAILER] * 8}, "trailer", "allowed are at most 7"),
        ({"trailer": TRAILER}, "trailer", "a list of tables, [[trailer]]"),
        ({"trailer.1.mass": 1.0}, "trailer.1.mass", "allowed are 0 to 0"),
        ({"trailer.0.colour": 1}, "trailer.0.colour", "this key does not exist; allowed are length"),
    )),
    (TRACTOR, {"trailer.0.centre_of_mass": 15.0}, "trailer.0.centre_of_mass", ""),
    (TRACTOR, {"trailer.0.yaw_inertia": 9e6}, "trailer.0.yaw_inertia", ""),
    (TRACTOR, {"vehicle.yaw_inertia": 9e6}, "vehicle.yaw_inertia", ""),
    (PLANE, {"axle": [{"position": 9.0, "friction": 0.7}]}, "axle.0.position", "before and behind the centre"),
    # Keys of space and [body] require each other:
    (PLANE, {"axle.0.track": "1.85 m"}, "axle.0.track", ""), (PLANE, {"wall.height": "32 in"}, "wall.length", ""),
    (PLANE, {"strip": [HIGH], "contact.stiffness": None, "contact.plateau_force": None}, "strip.0.height", ""),
    (TRAIN_IN_SPACE, {"trailer.0.hitch_height": None}, "trailer.0.hitch_height", ""),
    (TRAIN_IN_SPACE, {"axle.3.spring": None}, "axle.3.spring", ""),
    (TRAIN_IN_SPACE, {f"axle.{n}.{key}": 1 for n in (3, 4) for key in ("unit", "position")}, "axle",
     "unit 2 of the train requires at least 1"),
    *((SPACE, changes, key, words) for changes, key, words in (
        ({"axle.1.position": "11 m"}, "axle.1.position", "10 m"),
        ({"axle.0.position": "6 m"}, "axle.1.position", "before and behind the centre"),
        ({"axle": None}, "axle", "at least 2"), ({"axle.0.tyre": None}, "axle.0.tyre", "required"),
        ({"axle.0.mass": "9.5 t"}, "vehicle.mass", "more than the axles"),
        ({"strip": None, "contact.restitution": None}, "strip", "at least one strip"),
        ({"strip.0.height": None}, "strip.0.height", "with [body] a strip has heights"),
        ({"contact.stiffness": "2 MN/m"}, "contact.stiffness", "all units have [[strip]]"),
        ({"strip.0.unloading_stiffness": 1e7, "strip.0.restitution": 0.2}, "strip.0.unloading_stiffness", "remove one"),
        ({"strip.0.initial_force": "1 MN/m"}, "strip.0.plateau", "at least that, 1e+06, above 0"),
        ({"strip.0.initial_force": "9 kN/m", "strip.0.restitution": 0.8}, "strip.0.restitution", "sqrt(1/2)"),
        ({"strip.3.height": ["49 in", "5 m"]}, "strip.3.height", "4.05 m"),
        ({"strip.0.at": "12 m"}, "strip.0.at", "10 m"), ({"strip.0.unit": 2}, "strip.0.unit", "1 to 1"),
        ({"strip.0.height": ["0.9 m", "0.45 m"]}, "strip.0.height", "upwards"),
        ({"strip.0.inset": "1.3 m"}, "strip.0.inset", "1.219 m"), ({"strip.1.axle": 5}, "strip.1.axle", "0, 1"),
        ({"contact.restitution": None}, "strip.0.restitution", "required"),
        ({"body.centre_height": "0.4 m"}, "body.centre_height", "0.5 m"),
        ({"body.centre_height": math.nan}, "body.centre_height", "from 0.05"),
        ({"body.roll_inertia": "100 kg m^2"}, "body.roll_inertia", "more than"),
        ({"wall.profile": [[0, 0], [0.1, 0.9]]}, "wall.profile", "y not"),
        ({"wall.profile": [[0, 0], [-0.1, 0.5], [-0.2, 0.4]]}, "wall.profile", "z growing"),
        ({"wall.profile": [[0, 0]]}, "wall.profile", "at least two points"),
        ({"wall.profile": "jersey"}, "wall.profile", "new-jersey"), ({"wall.height": None}, "wall.height", "required"),
        ({"wall.foundation_stiffness": 1e6}, "wall.foundation_stiffness", "rigid"),
        ({"wall.elements": [3, 3]}, "wall.elements", "rigid"),
    )),
]  # fmt: skip
"""Scene, changes, the key by which they are refused, and words of what is allowed."""


@pytest.mark.parametrize(("scene", "changes", "key", "allowed"), WRONG)
def test_a_wrong_scene_is_refused_by_its_key_with_what_is_allowed(scene, changes, key, allowed):
    with pytest.raises(InputError) as caught:
        tailslap.rigid(scene, changes)
    assert (caught.value.key, str(caught.value).startswith(f"{key}: given ")) == (key, True)
    assert allowed in caught.value.allowed


def test_all_missing_keys_are_named_at_once(tmp_path):
    path = tmp_path / "van.toml"
    path.write_text("[vehicle]\nlength = 5\n[impact]\nspeed = 20\n[plate]\nthickness = 0.04\n")
    with pytest.raises(InputError) as caught:
        read_scene(str(path))
    missing = {"vehicle.mass", "impact.angle", "impact.friction", "impact.restitution"}
    missing |= {"plate.poissons_ratio", "plate.youngs_modulus"}
    assert caught.value.key == "vehicle.width"
    assert set(re.findall(r"[a-z]+\.[a-z_]+", caught.value.allowed)) == missing | {"plate.first_frequency"}


@pytest.mark.parametrize(("name", "words"), [
    ("nowhere.toml", "SCENE"), ("paper-table3", "SCENE"), ("impact-tl4", r"did you mean impact-mash-tl4-sut\?"),
])  # fmt: skip
def test_scenes_that_are_not_there(name, words):
    """The most similar one with all words given is suggested, not tl5cmb-2."""
    with pytest.raises(InputError, match=words):
        read_scene(name)
