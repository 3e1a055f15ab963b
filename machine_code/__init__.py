"""Kernels in Python, compiled by LLVM and stored as machine code.

A kernel is translated from its syntax tree to LLVM's language (`translate`, `statements`, `expressions`), optimised
(`llvm_code`), and kept with the layout of its arguments (`object_code`, `folder`). llvmlite loads it, and ctypes
calls it.
"""
