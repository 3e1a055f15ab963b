"""An element from outside, the serendipity quadrilateral of eight nodes."""

from fem import ELEMENT_KINDS, ElementKind

ELEMENT = ElementKind("quad8", "ElementQuadS2", order=4, cells="quad", row_sums=False, cell_type="quad8")
ELEMENT_KINDS.register(ELEMENT)
