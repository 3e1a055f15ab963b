"""Machine code of the kernels: compiled by Numba once, kept on disk, and called from there without Numba.

Importing Numba takes longer than most runs, and it is needed only to compile. What is kept is the object code that it
has made, with the layout of its arguments; llvmlite, Numba's own loader, puts it into memory, ctypes calls it.
"""
