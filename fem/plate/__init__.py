"""The discretised plate with its masses, stiffness and frequencies.

`properties` are the input, `kinds` registers elements and mass lumping, `discretisation` has the tables of the
compiled loop and the stiffness, `nodal_masses` the masses. `elastic` inverts the stiffness without rigid motion,
large ones by `multigrid`, and `free_modes` follow from it. `spectrum` is the highest frequency by `lanczos`, for
large plates bounded by `windows`.
"""

from fem.lazy import defer

# SciPy imports all names of NumPy; these modules, which no run uses, would take 50 ms.
defer("numpy", "ctypeslib f2py testing")
