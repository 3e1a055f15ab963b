"""Values for the design of a wall, of a motion in space.

Loads as force, height and length; intrusion of the body over the wall; exit box. Distances from the face are in the
direction away from the road for intrusion and working width, and onto the road for the exit box.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from postprocess.figures import space as drawings
from postprocess.report.tables import Column, columns
from postprocess.units import force, measure
from solver.impact.strips import names_of_places
from tailslap.case.impact.space import figures

if TYPE_CHECKING:
    from solver.space import SpaceMotion, SpaceVehicle, SpaceWall

CAR, HEAVIEST_CAR = (2.2, 10.0), 3500.0
OTHER, OF_LENGTH = (4.4, 20.0), 0.16
"""Margin and length of the exit box [m] of cars and pickups up to a mass, assumed [kg], and of other vehicles; part of
the vehicle's length that adds to its width.

EN 1317-2 and MASH 2016, see `NOT_CONFIRMED`.
"""

NOT_CONFIRMED = "distances of EN 1317-2 and MASH, not confirmed here"
LACKING = "wall.depth", "width of the road"
"""What the working width of the wall and the exit box need and no scene with [body] has."""

OVER = (
    *columns({"name": "Strip of the body", "key": "Key"}, form=str),
    *columns({"intrusion": "Intrusion", "height": "At a height of"}, unit="m", form=".2f"),
    Column("t", "At", "s", form=".2f"),
)
MEANING = (
    "Intrusion: farthest point of a strip above the wall's top behind the upper edge of its face (zone of intrusion, "
    "NCHRP Research Report 1018). Parts without a strip, as a cab, are not seen."
)


class ExitBox(NamedTuple):
    """Exit box on the road, from the last contact on.

    width, length: of the box [m]; reached: largest distance of a wheel of the first unit from the face within its
    length, the motion continued straight beyond its end [m].
    """

    width: float
    length: float
    reached: float


def strip_names(vehicle: SpaceVehicle) -> list[str]:
    """Return the strips' names by their place and height."""
    lengths, names = [unit.length for unit in vehicle.units], []
    for strip in vehicle.strips:
        alone = [[strip.at] if unit == strip.unit else [] for unit in range(len(lengths))]
        low, high = (f"{float(end):.4g}" for end in strip.height)
        names.append(
            f"{names_of_places(alone, lengths)[0]}, {low if low == high else f'{low} to {high}'} m high"
        )
    return names


def intrusions(vehicle: SpaceVehicle, wall: SpaceWall, motion: SpaceMotion) -> list[dict[str, Any]]:
    """Return the largest intrusion of strips of the body.

    Those over the wall have strip, its name, unit, intrusion behind the upper edge of the face and height [m], and
    instant [s].
    """
    drawn, history, rows = figures.geometry(vehicle, wall), motion.history, list[dict[str, Any]]()
    names = strip_names(vehicle)
    edge, top = drawn.face[-1]
    for number, strip in enumerate(drawn.strips):
        if strip.axle >= 0:
            continue
        half = 0.5 * drawn.units[strip.unit].width - strip.inset
        ends = [
            (-at, side * half, z) for at, z in zip(strip.at, strip.height, strict=True) for side in (-1, 1)
        ]
        places = drawings.moved(drawn, history, strip.unit, ends)
        beyond = np.where(places[..., 2] > top, edge - places[..., 1], 0.0)
        row, end = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
        if beyond[row, end] > 0.0:
            rows.append({
                "strip": number, "name": names[number], "unit": strip.unit + 1, "intrusion": float(beyond[row, end]),
                "height": float(places[row, end, 2]), "t": float(history["t"][row]),
            })  # fmt: skip
    return rows


def exit_box(vehicle: SpaceVehicle, wall: SpaceWall, motion: SpaceMotion) -> ExitBox:
    """Return the exit box, and how far wheels reach."""
    drawn, h = figures.geometry(vehicle, wall), motion.history
    fronts = np.cumsum([0.0, *(float(unit.hitch) - float(unit.kingpin) for unit in vehicle.units[1:])])
    total = max(front + unit.length for front, unit in zip(fronts, drawn.units, strict=True))
    margin, length = CAR if sum(unit.mass for unit in drawn.units) <= HEAVIEST_CAR else OTHER
    after = h["t"] >= float(motion.answers.last_contact) - 1e-9
    state = {name: values[after] for name, values in h.items()}
    state = {name: values[state["x_g"] - state["x_g"][0] <= length] for name, values in state.items()}
    across = np.stack([
        drawings.moved(drawn, state, 0, [(-axle.position, 0.5 * axle.track, 0.0)], number)[:, 0, 1]
        for number, axle in enumerate(drawn.axles) if axle.unit == 0
    ])  # fmt: skip
    rest = length - (state["x_g"][-1] - state["x_g"][0])
    beyond = across[:, -1] + rest * max(state["v_gy"][-1] / max(state["v_gx"][-1], 1e-9), 0.0)
    width = margin + max(unit.width for unit in drawn.units) + OF_LENGTH * total
    return ExitBox(width, length, float(max(across.max(), beyond.max())))


def numbers(vehicle: SpaceVehicle, wall: SpaceWall, motion: SpaceMotion, outcome: str) -> dict[str, Any]:
    """Return moment, working width, intrusion and exit box, SI."""
    one = motion.answers
    over, box = intrusions(vehicle, wall, motion), exit_box(vehicle, wall, motion)
    edge = float(figures.geometry(vehicle, wall).face[-1, 0])
    moment, height = float(one.moment), float(one.moment_height)
    is_judged = outcome == "upright" and float(one.last_contact) < float(one.end)
    return {
        "moment": {
            "mean_50ms": moment,
            "height": height,
            "length": float(one.moment_length),
            "force": moment / height if height else 0.0,
        },
        "working_width": max((row["intrusion"] for row in over), default=0.0) - edge,
        "intrusion": over,
        "exit_box": box._asdict() | {"inside": box.reached <= box.width if is_judged else None},
        "lacking": list(LACKING),
    }


def sentences(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Return numbers of `SpaceAnswer.numbers` in sentences."""
    moment, box, over, load = (values[name] for name in ("moment", "exit_box", "intrusion", "force"))
    metres = lambda value: measure(value, "m", ".2f")  # noqa: E731
    at_force = measure(load["mean_50ms"] * load["height"], "N m", ".0f")
    largest = max(over, key=lambda row: row["intrusion"], default=None)
    reach = "none over the wall"
    if largest:
        reach = (
            f"{metres(largest['intrusion'])} at a height of {metres(largest['height'])} ({largest['name']})"
        )
    inside = {True: "stays within", False: "leaves"}
    stays = inside.get(
        box["inside"], "does not remain upright or leans on the wall to the end, and is not judged by"
    )
    return (
        f"Largest 50 ms moment about the foot of the wall: {measure(moment['mean_50ms'], 'N m', '.0f')}, of "
        f"{force(moment['force'])} at {metres(moment['height'])} over {metres(moment['length'])}; at the largest "
        f"force {at_force}.",
        f"Intrusion over the wall, behind the upper edge of its face: {reach}; working width "
        f"{metres(values['working_width'])} by the vehicle alone: the scene has no wall.depth.",
        f"An exit box of {metres(box['width'])} by {metres(box['length'])} ({NOT_CONFIRMED}) needs a road as wide, "
        f"which the scene does not state: a wheel reaches {metres(box['reached'])} from the face, the vehicle {stays} "
        "the box.",
    )
