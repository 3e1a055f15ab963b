"""Contour pictures of the plate, drawn off-screen by VTK."""
