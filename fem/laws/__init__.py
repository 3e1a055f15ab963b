"""Laws of the compiled code: materials, constraints and friction of the corner, contact with the wall.

`materials`, `constraints`, `friction` and `unilateral` register laws as plain functions; `corner` calls them in the
step of the constrained plate, `wall_contact` in that of a whole impact, on the wall's face, which is rigid unless it is
an `elastic_wall`.
"""
