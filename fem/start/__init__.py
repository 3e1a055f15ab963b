"""State of the plate at t = 0.

`start_kinds` registers the kinds of start and places the plate. `inertia_relief` is the elastic state under the
accelerations of the rigid body, and `equilibrium` that state at large displacements.
"""
