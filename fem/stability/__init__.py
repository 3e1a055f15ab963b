"""What may grow in a plate, and how fast it swings as it is deformed.

`flutter` has growth by friction, and what rounding feeds into an undamped plate; `deformed` the highest frequency, and
the stress, of the plate at an instant of the run.
"""
