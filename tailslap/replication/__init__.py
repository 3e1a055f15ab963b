"""Replication of the numbers that Chuong and Malla (2025) print.

`paper_values` holds the printed numbers, `paper_numbers` computes them, and `paper_page` shows both.
"""
