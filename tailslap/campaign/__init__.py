"""Many runs of a scene: parts computed by workers, a record of each on disk as it comes.

`engine.py` hands parts to workers, processes of this machine or of a Dask cluster, and puts what they find into
`records.py`, an SQLite file. A study brings its own parts. A sweep is a `Definition` (definition.py):
its runs become rows, kept in a folder that can be resumed (perform.py), and at the end a page (report.py).
`sampling.py` draws inputs over ranges, and says which of them a spread comes from; `levels.py` says down to which
frequency a difference stays below a level.
"""
