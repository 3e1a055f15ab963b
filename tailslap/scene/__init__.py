"""The scene: its schema, where it is read from, units at the border."""
