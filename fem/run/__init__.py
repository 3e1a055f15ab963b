"""Runs, which make rows of a history until an observer ends them.

`runner` makes rows with a compiled stepper, and `observers` are called between them; one of them saves checkpoints.
`corner` is the run of the constrained plate to its tail-slap, `impact` that of a whole impact from its first touch.
"""
