"""Fields of the plate over time.

The record, formats of other programs, and contour pictures.
"""

MESHES, TABLES, PICTURES = ("vtkhdf", "xdmf", "vtu", "msh"), ("csv", "parquet"), ("png", "gif")
FORMATS = (*MESHES, *TABLES, *PICTURES)
"""Formats of exports: meshes with fields, tables, and pictures of fields."""
