"""Fields of the plate over time: one record, its file in a result folder, and the formats of other programs."""

MESHES, TABLES, PICTURES = ("vtkhdf", "xdmf", "vtu", "msh"), ("csv", "parquet"), ("png", "gif")
FORMATS = (*MESHES, *TABLES, *PICTURES)
"""What results are written in for others: mesh and fields, histories and fields as tables, pictures of fields."""
