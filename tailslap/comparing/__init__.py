"""Comparison of results of this program and histories of other programs.

`source` reads the histories, `compare_report` compares and reports them, `validation` makes the page of NCHRP W179.
"""
