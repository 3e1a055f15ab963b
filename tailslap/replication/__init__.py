"""Replication of the numbers that Chuong and Malla (2025) print.

`tables` holds the printed numbers and computes them, `page` shows both.
"""
