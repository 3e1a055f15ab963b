"""Operating systems, and the folder of compiled code."""
