"""The command `sweep`: many runs of one scene, on all cores of this machine or on a Dask cluster.

Data flows one way: the words of the command become a `Definition` (values.py, variation.py, definition.py);
`dispatch.py` has its runs computed by workers (cluster.py, worker.py, row.py); their rows go into the folder's journal
as they come (folder.py, journal.py); at the end it becomes the table, the pictures and the page (table.py, write.py).

The folder of a sweep, unlike other result folders, is there from the start: it can be resumed.
"""
