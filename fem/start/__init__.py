"""The plate at the first instant.

`start_kinds` registers the kinds of start and places the plate; `rigid_state` has the rigid body's motion,
accelerations and loads, `inertia_relief` the elastic state that belongs to them, at finite strain by `equilibrium`.
"""
