"""Central differences in time, compiled, and the histories of their states.

`time_loop` is the step, `impact_loop` that of a whole impact, `parallel` the step on several threads.
`internal_force` passes through the elements in SIMD blocks (`simd_blocks`), one quadrature point at a time
(`point_force`). `elastic_damping` is the damping that does not affect rigid motion. `measures` evaluates a state, and
`columns` registers the columns of the histories.
"""
