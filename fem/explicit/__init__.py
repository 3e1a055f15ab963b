"""Time: central differences, compiled, and what is recorded of them.

`internal_force` goes through the elements in the SIMD blocks of `simd_blocks`; `time_loop` is the step, `parallel` the
same on several threads, `elastic_damping` damping that leaves rigid motion alone. `measures` reads a state, `recording`
does so for many rows, `columns` registers what the history has of it, and `simulate` runs from the start to the
tail-slap.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "columns": "COLUMNS Column Measures",
        "simulate": "Run Strike",
    },
)
