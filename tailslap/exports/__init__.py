"""Results and scenes for other programs.

`export` writes fields and histories of a result; `deck` an input file of a scene, from `templates`; `confirm` runs one
and compares what it computes.
"""

PROGRAMS = ("calculix", "abaqus")
"""Programs that decks are written for."""

SOLVERS = ("calculix",)
"""Programs that run them."""
