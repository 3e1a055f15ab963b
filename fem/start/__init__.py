"""State of the plate at t = 0.

`start_kinds` registers the kinds of start and places the plate. `rigid_loads` has the accelerations and loads of the
rigid body, `inertia_relief` the elastic state that belongs to them, and `equilibrium` that state at large
displacements.
"""
