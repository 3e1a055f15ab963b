"""Pages of results in Chromium.

`session` opens them, `screen`, `charts` and `paper` check parts, `inspection` checks all.
"""
