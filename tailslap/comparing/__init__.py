"""`tailslap compare`: results of this program, and histories of others, side by side.

`source` reads what is compared, `report` compares and reports.
"""
