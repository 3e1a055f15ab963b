"""The result folder: complete or absent, and never at the expense of other files."""
