"""Measures of roadside engineers: filtered forces, peaks, durations, design forces, occupant risk."""
