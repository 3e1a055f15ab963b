"""Proven bounds of the collapse load of plates in bending."""
