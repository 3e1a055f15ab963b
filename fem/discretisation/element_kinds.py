"""Kinds of elements. Each is one object; adding one is adding it here, or in any file that registers it.

scikit-fem supplies shape functions and quadrature; all elements go through the same compiled kernel.
"""

from __future__ import annotations

from dataclasses import dataclass

from fem.registry import Registry


@dataclass(frozen=True)
class ElementKind:
    """A kind of element.

    Attributes
    ----------
    name : str
        In a scene.
    element : str
        scikit-fem's.
    order : int
        That the quadrature integrates; 0 stands for the one point in the middle, which scikit-fem does not choose by
        itself.
    cells : str
        That it sits on.
    hourglass : bool
        Whether it needs hourglass control.
    richer : str
        Kind of twice the order on the same mesh, "" where this one is of second order.
    row_sums : bool
        Whether row sums of its mass matrix are positive.
    """

    name: str
    element: str
    order: int
    cells: str
    hourglass: bool = False
    richer: str = ""
    row_sums: bool = True


ELEMENT_KINDS: Registry[ElementKind] = Registry("element")
"""Kinds of elements by their names in a scene."""

for _kind in (
    ElementKind("quad4", "ElementQuad1", 2, "quad", richer="quad9"),
    ElementKind("quad4-reduced", "ElementQuad1", 0, "quad", hourglass=True, richer="quad9"),
    ElementKind("quad9", "ElementQuad2", 4, "quad"),
    ElementKind("tri3", "ElementTriP1", 1, "triangle", richer="tri6"),
    ElementKind("tri6", "ElementTriP2", 2, "triangle", row_sums=False),
):
    ELEMENT_KINDS.register(_kind)
