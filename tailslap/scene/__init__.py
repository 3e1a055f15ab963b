"""Scenes, with their keys, units, reading, validation, variation and writing."""
