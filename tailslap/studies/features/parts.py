"""The scene without its parts, and with one of them at a time."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from tailslap.errors import InputError
from tailslap.planning.fe_plan import FePlan, make_fe_plan, needed_plate
from tailslap.planning.plan import Plan, make_plan
from tailslap.scene.schema import Corner, Damping, Material, Scene, Wall

PLAIN, AGAIN, BARE = "plain", "plain again", "bare loop"
"""The loop without parts, the same a second time, and the loop that has no code for them."""

ONE_POINT = "one-point elements"


@dataclass(frozen=True)
class Part:
    """A scene with a part; `without` is the name of the one it is held against, "" for none.

    controlled: False where the hourglass control of one-point elements is taken out of the model.
    """

    name: str
    what: str
    scene: Scene
    without: str = PLAIN
    controlled: bool = True


def plain_scene(scene: Scene) -> Scene:
    """The scene with a plate, a penalty spring, and nothing else that a step has to work for."""
    plate = needed_plate(scene)
    element = "quad4" if plate.element == "quad4-reduced" else plate.element
    return _changed(
        scene,
        corner=Corner(reaction="none", penalty_scale=scene.corner.penalty_scale),
        plate=plate.model_copy(update={"element": element}),
        time=scene.time.model_copy(update={"threads": 1}),
        **dict.fromkeys(("material", "damping", "wall")),
    )


def parts_of(scene: Scene) -> list[Part]:
    """The plain scene, and the plain scene with each part; values are the scene's own where it has them."""
    plain = plain_scene(scene)
    given, plate, damping = scene.corner, needed_plate(plain), scene.damping
    ratio = (damping.ratio if damping else None) or 0.02
    patch = given.patch_length or 0.1 * scene.vehicle.length
    dashpot = given.damping_ratio or 0.2
    law = given.reaction if given.reaction != "none" else "drag"
    friction = scene.corner_friction or (scene.impact.friction if scene.impact else 0.0) or 0.47
    one_point = _changed(plain, plate=plate.model_copy(update={"element": "quad4-reduced"}))

    def corner(**changes: Any) -> Scene:
        return _changed(plain, corner=plain.corner.model_copy(update=changes))

    parts = [
        Part(PLAIN, "internal forces, penalty spring, drift", plain, without=""),
        Part("friction", f"{law}, coefficient {friction:g}", corner(reaction=law, friction=friction)),
        Part("damping", f"damping.ratio = {ratio:g}", _changed(plain, damping=Damping(ratio=ratio))),
        Part("dashpot", f"corner.damping_ratio = {dashpot:g}", corner(damping_ratio=dashpot)),
        Part("exact constraint", 'corner.constraint = "exact"', corner(constraint="exact")),
        Part("patch", f"corner.patch_length = {patch:g}", corner(patch_length=patch)),
        Part("neo-Hookean", "material.law", _changed(plain, material=Material(law="neo-hookean"))),
        Part(ONE_POINT, "no control", one_point, controlled=False),
        Part("hourglass control", 'plate.element = "quad4-reduced"', one_point, ONE_POINT),
    ]
    if (os.cpu_count() or 1) > 1:
        parts.append(Part("two threads", "time.threads = 2", _changed(plain, time=_threads(plain))))
    if _loop_tables(scene) != _loop_tables(plain):
        parts.append(Part("the scene as given", "all its parts", scene))
    return parts


def with_wall(scene: Scene, plan: Plan) -> Scene:
    """The plain scene with a wall: its own, or one as long as the slide needs."""
    wall = scene.wall or Wall(
        length=2.0 * max(1.0, abs(plan.motion.strike.slide)), depth=5.0, elements=(60, 10)
    )
    return _changed(plain_scene(scene), wall=wall)


def fe_plan_of(part: Part) -> FePlan:
    """The part's model. Raises InputError where theory or mesh refuse it."""
    return make_fe_plan(make_plan(part.scene))


def refusal(part: Part) -> str:
    """Why this part cannot be had in this scene; "" where it can."""
    try:
        fe_plan_of(part)
    except InputError as error:
        return str(error)
    return ""


def _threads(scene: Scene) -> Any:
    return scene.time.model_copy(update={"threads": 2})


def _loop_tables(scene: Scene) -> tuple[Any, ...]:
    """What the time loop of a scene depends on."""
    plate = needed_plate(scene)
    return scene.corner, plate.element, scene.material, scene.damping, scene.time.threads


def _changed(scene: Scene, **tables: Any) -> Scene:
    return scene.model_copy(update=tables)
