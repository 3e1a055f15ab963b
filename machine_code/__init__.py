"""Compiled kernels, stored on disk as machine code.

Importing Numba takes longer than most runs, and is needed only to compile. Object code is stored with the layout of
its arguments. llvmlite, Numba's own loader, loads it, and ctypes calls it.
"""
