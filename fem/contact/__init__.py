"""The constrained corner: its constraint, the friction law, and the side that supports it."""
