"""The command `paper`: what Chuong and Malla (2025) print, computed beside printed.

`data` holds the printed numbers, `tables` computes them, `page` shows both.
"""
