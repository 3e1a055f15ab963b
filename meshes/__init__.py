"""Meshes by gmsh, as `meshio.Mesh` with named physical groups.

The plate is meshed in its body frame: corner P at the origin, the side PE along -X, the body in Y >= 0, so that the
mesh itself is the plate at the tail-slap. Importing this package loads neither gmsh nor meshio.
"""

from meshes.rectangle import distorted, plate_mesh, wall_mesh

__all__ = ["distorted", "plate_mesh", "wall_mesh"]
