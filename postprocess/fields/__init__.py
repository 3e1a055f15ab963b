"""Fields of the plate over time: one record, its file in a result folder, and the formats of other programs."""

FORMATS = ("vtkhdf", "xdmf", "vtu", "msh", "csv", "parquet")
"""What results are written in for others: the first four hold the mesh and its fields, the last two tables."""
