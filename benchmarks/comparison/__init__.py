"""Parts of peers.py: what is compared, how it is run, what of an error is whose, table and picture."""
