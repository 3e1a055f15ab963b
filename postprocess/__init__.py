"""Presentation of a run's numbers: comparison, tables on disk, pictures, curves, report.

Nothing here knows how the numbers were computed or how a scene is written: every function takes plain NumPy
arrays, mappings and the frozen records defined here. SI units throughout. The picture, plot and template
libraries are imported inside the functions that need them: importing a module is cheap.
"""
