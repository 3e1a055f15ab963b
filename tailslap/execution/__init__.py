"""How many runs are made: functions of plain arguments, on workers, their records on disk as they come.

`record_file.py` keeps records by key, `journal.py` those of a study until it is done. `cluster.py` connects to workers,
`dispatch.py` hands them their parts in batches, and `worker.py` is what they do; `run_parts.py` puts these together for
a study, and a sweep does for itself.
"""
