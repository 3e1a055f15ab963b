"""Fields of the plate over time: record, formats of other programs (series.py), contour pictures by PyVista."""

MESHES, TABLES, PICTURES = ("vtkhdf", "xdmf", "vtu", "msh"), ("csv", "parquet"), ("png", "gif")
FORMATS = (*MESHES, *TABLES, *PICTURES)
"""Formats for other programs: mesh and fields, histories and fields as tables, pictures of fields."""
