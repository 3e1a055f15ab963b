"""The scene without its parts, and with one of them at a time."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from tailslap.errors import InputError
from tailslap.planning.fe_plan import FePlan, make_fe_plan
from tailslap.planning.plan import Plan, make_plan
from tailslap.scene.schema import Scene, Wall
from tailslap.scene.vary import Changes, varied

PLAIN, AGAIN, BARE = "plain", "plain again", "bare loop"
"""The loop without parts, the same a second time, and the loop that has no code for them."""

ONE_POINT = "one-point elements"


@dataclass(frozen=True)
class Part:
    """A scene with a part; `without` is the name of the one it is compared with, "" for none.

    controlled: False where the hourglass control of one-point elements is taken out of the model.
    """

    name: str
    what: str
    scene: Scene
    without: str = PLAIN
    controlled: bool = True


def plain_scene(scene: Scene) -> Scene:
    """The scene with a plate, a penalty spring, and nothing else that a step has to work for."""
    changes = {
        "corner": {"reaction": "none", "penalty_scale": scene.corner.penalty_scale},
        "time.threads": 1,
        **dict.fromkeys(("material", "damping", "wall")),
        **({"plate.element": "quad4"} if scene.needed_plate.element == "quad4-reduced" else {}),
    }
    return varied(scene, changes)


def parts_of(scene: Scene) -> list[Part]:
    """The plain scene, and the plain scene with each part; values are the scene's own where it has them."""
    plain = plain_scene(scene)
    given, damping = scene.corner, scene.damping
    ratio = (damping.ratio if damping else None) or 0.02
    patch = given.patch_length or 0.1 * scene.vehicle.length
    dashpot = given.damping_ratio or 0.2
    law = given.reaction if given.reaction != "none" else "drag"
    friction = scene.corner_friction or (scene.impact.friction if scene.impact else 0.0) or 0.47
    sliding = {"corner.reaction": law, "corner.friction": friction}
    exact = {"corner.constraint": "exact", "corner.penalty_scale": None}
    one_point = {"plate.element": "quad4-reduced"}

    def part(name: str, what: str, changes: Changes, *rest: Any, **more: Any) -> Part:
        return Part(name, what, varied(plain, changes), *rest, **more)

    parts = [
        Part(PLAIN, "internal forces, penalty spring, drift", plain, without=""),
        part("friction", f"{law}, coefficient {friction:g}", sliding),
        part("damping", f"damping.ratio = {ratio:g}", {"damping.ratio": ratio}),
        part("dashpot", f"corner.damping_ratio = {dashpot:g}", {"corner.damping_ratio": dashpot}),
        part("exact constraint", 'corner.constraint = "exact"', exact),
        part("patch", f"corner.patch_length = {patch:g}", {"corner.patch_length": patch}),
        part("neo-Hookean", "material.law", {"material.law": "neo-hookean"}),
        part(ONE_POINT, "no control", one_point, controlled=False),
        part("hourglass control", 'plate.element = "quad4-reduced"', one_point, ONE_POINT),
    ]
    if (os.cpu_count() or 1) > 1:
        parts.append(part("two threads", "time.threads = 2", {"time.threads": 2}))
    if _loop_tables(scene) != _loop_tables(plain):
        parts.append(Part("the scene as given", "all its parts", scene))
    return parts


def with_wall(scene: Scene, plan: Plan) -> Scene:
    """The plain scene with a wall: its own, or one as long as the slide needs."""
    length = 2.0 * max(1.0, abs(plan.motion.strike.slide))
    wall = scene.wall or Wall(length=length, depth=5.0, elements=(60, 10))
    return varied(plain_scene(scene), {"wall": wall.model_dump()})


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


def _loop_tables(scene: Scene) -> tuple[Any, ...]:
    """What the time loop of a scene depends on."""
    plate = scene.needed_plate
    return scene.corner, plate.element, scene.material, scene.damping, scene.time.threads
