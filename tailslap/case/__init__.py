"""Calculations of a scene, which are of two kinds, `corner` and `impact`.

`case` states what both kinds offer; the files beside it contain what they have in common.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tailslap.case.case import Case
    from tailslap.scene.schema import Scene
    from tailslap.scene.vary import Source


def case_of(scene: Scene, source: Source) -> Case:
    """Make the case of a scene.

    Raises InputError where the rigid body has no solution.
    """
    return kind_of(scene)(scene, source)


def kind_of(scene: Scene) -> type[Case]:
    """Return the class of a scene's case.

    A scene with [contact] is a whole impact, others are constrained corners. Only the modules of this kind are
    imported.
    """
    if scene.contact is None:
        from tailslap.case.corner.corner_case import CornerCase

        return CornerCase
    from tailslap.case.impact.case import ImpactCase

    return ImpactCase
