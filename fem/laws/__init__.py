"""Laws of materials, constraints, friction and contact for the compiled loop.

`materials`, `constraints`, `friction` and `unilateral` register laws as plain functions; `constraints` calls them in
the step of the constrained plate, `wall_contact` in that of a whole impact, on the face of a rigid or deformable wall.
"""
