"""Constrained corner, rigid and by finite elements."""
