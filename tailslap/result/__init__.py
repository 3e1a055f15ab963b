"""Results of commands in Python, new or read from folders.

`result` is the record that all functions return, `columns` its histories and tables, `load` reads a folder again.
"""
