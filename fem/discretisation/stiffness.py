"""The linear stiffness of the unstrained plate."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from fem.discretisation.elements import ElementTable, Hourglass


def stiffness_matrix(scalar: Any, thickness: float, moduli: Any) -> sp.csr_matrix:
    """Plane-stress stiffness [N/m] in the body frame, shape (2 nodes, 2 nodes): all x unknowns, then all y.

    moduli: anything with c_11, c_12, c_33: a `StVenantKirchhoff` [Pa], or a `Viscosity` [Pa s] for a damping matrix.
    """
    import skfem
    from skfem.helpers import grad

    def assemble(k: int, m: int) -> sp.csr_matrix:
        return skfem.BilinearForm(lambda u, v, w: grad(v)[k] * grad(u)[m]).assemble(scalar)

    xx, yy, xy = assemble(0, 0), assemble(1, 1), assemble(0, 1)
    coupling = moduli.c_12 * xy + moduli.c_33 * xy.T
    blocks = [
        [moduli.c_11 * xx + moduli.c_33 * yy, coupling],
        [coupling.T, moduli.c_11 * yy + moduli.c_33 * xx],
    ]
    return sp.csr_matrix(thickness * sp.bmat(blocks))


def hourglass_matrix(table: ElementTable, hourglass: Hourglass, nodes: int) -> sp.csr_matrix:
    """Stiffness [N/m] of the hourglass control at rest, shape (2 nodes, 2 nodes)."""
    elements = table.connectivity.shape[1]
    vectors = np.broadcast_to(hourglass.vectors, (hourglass.vectors.shape[0], elements))
    columns = np.broadcast_to(np.arange(elements), vectors.shape)
    gather = sp.csr_matrix(
        (vectors.ravel(), (table.connectivity.ravel(), columns.ravel())), shape=(nodes, elements)
    )
    k_11, k_22, k_12 = (
        gather @ sp.diags(np.broadcast_to(row, elements)) @ gather.T for row in hourglass.stiffness
    )
    return sp.csr_matrix(sp.bmat([[k_11, k_12], [k_12, k_22]]))
