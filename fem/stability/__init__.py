"""Stability of a plate: growth by friction and rounding, and its frequencies and stress as it is deformed.

`flutter` has growth by friction, and what rounding feeds into an undamped plate; `deformed` the highest frequency, and
the stress, of the plate at an instant of the run.
"""
