"""Time: central differences, compiled, and what is recorded of them.

`internal_force` goes through the elements in the SIMD blocks of `simd_blocks`, quadrature point by quadrature point
(`point_force`); `time_loop` is the step, `impact_loop` that of a whole impact, `parallel` the same on several threads,
`elastic_damping` damping that leaves rigid motion alone. `measures` reads a state, once or for many rows, and `columns`
registers what the histories have of it.
"""
