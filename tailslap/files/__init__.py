"""The result folder, complete or absent, and never at the expense of other files.

`folder` fills it, `manifest` lists its files, `load` reads it again, `export` writes it for other programs,
`checkpoints` keep an unfinished run beside it.
"""
