"""Result folders that are complete or absent, and spare other files.

`folder` fills a folder, `manifest` lists its files, `checkpoints` save an unfinished run beside it.
"""
