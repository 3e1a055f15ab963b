"""What a run leaves out, and why."""

from __future__ import annotations

from fem.plate.kinds import LUMPINGS
from tailslap.scene.schema import Scene


def omitted_parts(scene: Scene, pictures: bool = True) -> list[tuple[str, str]]:
    """Parts that this scene does without, each with the reason."""
    parts = []
    if scene.impact is None:
        parts.append(("stage 1", "the scene has no [impact] table; [start] gives the state after the impact"))
    if scene.corner.frictionless:
        parts.append(
            ("friction", f'corner.reaction is "{scene.corner.reaction}": no friction code in the time loop')
        )
    elif scene.corner_friction == 0.0:
        parts.append(("friction", "the coefficient of friction is 0: no friction code in the time loop"))
    if scene.damping is None:
        parts.append(("damping", "none is asked for and none is needed: no damping code in the time loop"))
    if scene.plate and not scene.plate.relieved:
        parts.append(
            (
                "inertia relief",
                f'plate.start is "{scene.plate.start}": the plate starts without its elastic state',
            )
        )
    if scene.plate and (fault := LUMPINGS[scene.plate.lumping].fault):
        parts.append(("exact inertia", f'plate.lumping is "{scene.plate.lumping}": {fault}'))
    if scene.wall is None:
        parts.append(("wall", "the scene has no [wall] table: no wall mesh, the wall is the line Y = 0"))
    if not pictures:
        parts.append(("pictures", "--no-pictures, or none could be drawn: VTK has no part in this result"))
    return parts
