"""The command `paper`: what Chuong and Malla (2025) print, computed beside printed.

`tables` holds the printed numbers and computes them, `page` shows both.
"""
