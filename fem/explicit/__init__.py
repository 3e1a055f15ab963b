"""Time: central differences, compiled, and what is recorded of them.

`internal_force` goes through the elements in the SIMD blocks of `simd_blocks`; `time_loop` is the step, `parallel` the
same on several threads, `elastic_damping` damping that leaves rigid motion alone. `measures` reads a state, once
or for many rows, and `columns` registers what the history has of it. `impact_loop` is the step of a whole impact.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "columns": "COLUMNS Column Measures",
    },
)
