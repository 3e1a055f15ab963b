"""The plate: what it is made of, its elements, its stiffness and masses, and its frequencies.

`kinds` has properties, registers kinds of elements and of mass lumping, and has the tables of the compiled loop, from
scikit-fem, and the stiffness; `elastic` inverts it beside rigid motion and finds the free modes; `spectrum` the
highest frequency, of large plates bounded by windows of it.
"""
