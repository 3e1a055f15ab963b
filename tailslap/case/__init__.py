"""A scene as a case to be planned, run, checked and reported: `corner` and `impact` are its two kinds.

`case` says what every kind offers; what both do stands beside it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tailslap.case.case import Case
    from tailslap.scene.schema import Scene
    from tailslap.scene.vary import Source


def case_of(scene: Scene, source: Source) -> Case:
    """Make the case of a scene. Raises InputError where the rigid body has no answer."""
    return kind_of(scene)(scene, source)


def kind_of(scene: Scene) -> type[Case]:
    """The class of its case: a whole impact if it has [contact], else the paper's constrained corner.

    Only the modules of this kind are imported.
    """
    if scene.contact is None:
        from tailslap.case.corner.corner_case import CornerCase

        return CornerCase
    from tailslap.case.impact.case import ImpactCase

    return ImpactCase
