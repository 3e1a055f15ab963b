"""Runs: rows of a history until somebody says that it is over.

`runner` makes rows with a compiled stepper and lets observers look at them now and then; `corner` is the run of the
constrained plate to its tail-slap, `impact` that of a whole impact from its first touch.
"""
