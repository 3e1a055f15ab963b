"""Time: central differences, compiled, and what is recorded of them.

`internal_force` goes through the elements in SIMD blocks, quadrature point by quadrature point (`point_force`), and
has the damping that leaves rigid motion alone; `time_loop` is the step, `impact_loop` that of a whole impact,
`parallel` the same on several threads. `measures` reads a state, once or for many rows, and `columns`
registers what the histories have of it.
"""
