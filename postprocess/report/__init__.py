"""Reports of commands.

Tables that are declared once, pages, files and terminal text.
"""
