"""Fields of the plate over time: one record (series.py), the formats of other programs, contour pictures by PyVista."""

MESHES, TABLES, PICTURES = ("vtkhdf", "xdmf", "vtu", "msh"), ("csv", "parquet"), ("png", "gif")
FORMATS = (*MESHES, *TABLES, *PICTURES)
"""What results are written in for others: mesh and fields, histories and fields as tables, pictures of fields."""
