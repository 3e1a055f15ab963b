"""Campaigns of many runs.

`engine.py` sends parts to workers (`pools.py`), processes of this machine or of a Dask cluster, and adds their results
to `records.py`, an SQLite file. A study defines its own parts.

A sweep is a `Definition` (sweep_definition.py). Its runs become rows of a table (sweep_table.py) in a folder that can
be resumed (sweep_run.py), and end in a page (sweep_report.py).

Inputs vary over ranges (input_ranges.py), from which samples and Sobol indices follow (sampling.py). `levels.py` seeks
the lowest frequency at which a difference remains below a level, and `random_scenes.py` draws scenes.
"""
