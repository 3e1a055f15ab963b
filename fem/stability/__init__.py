"""What could spoil a run: stiffening as the plate deforms, flutter by friction, rounding."""
