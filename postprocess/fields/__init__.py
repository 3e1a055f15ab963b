"""Fields of the plate over time: one record, its file in a result folder, and the formats of other programs."""
