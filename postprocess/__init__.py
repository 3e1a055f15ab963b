"""Presentation of results.

Comparison, signals, fields, figures, tables and reports. Nothing here depends on how the numbers were computed or how
a scene is written: functions take plain NumPy arrays, mappings and the frozen records defined here, in SI units.
Libraries for pictures, plots and templates are imported inside functions, so that importing a module is fast.
"""
