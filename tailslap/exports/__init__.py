"""Results and scenes for other programs.

`export` writes fields and histories of a result, `deck` an input file of a scene, from `templates`; `calculix` runs
it, and `confirm` compares the motions.
"""

PROGRAMS = ("calculix", "abaqus")
"""Programs for which decks are written."""

SOLVERS = ("calculix",)
"""Programs that can be run."""
