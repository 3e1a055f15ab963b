"""The plate at the first instant.

`start_kinds` registers the kinds of start and places the plate; `inertia_relief` has the rigid body's
motion, accelerations and loads, and the elastic state that belongs to them, at finite strain by Newton's method.
"""
