"""Growth, noise and frequency of a plate during its run.

`flutter` predicts growth by friction, `rounding` the energy that rounding feeds in. `deformed` is the highest
frequency and the stress of the elements in deformed positions.
"""
